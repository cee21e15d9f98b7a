import js from "@eslint/js";
import globals from "globals";

export default [
  { ignores: ["service/api_page/*-bundle.js", "service/explorer/js/film/gifenc.esm.js"] },
  js.configs.recommended,
  {
    files: ["service/explorer/js/**/*.js", "rattle_notebook/*.js"],
    languageOptions: { globals: globals.browser, ecmaVersion: 2024 },
    rules: {
      "no-unused-vars": ["error", { varsIgnorePattern: "^_", argsIgnorePattern: "^_" }],
      eqeqeq: ["error", "always", { null: "ignore" }],
      "prefer-const": "error",
    },
  },
  { files: ["service/api_page/show.js"], languageOptions: { globals: { ...globals.browser, SwaggerUIBundle: "readonly" }, sourceType: "script" } },
  { files: ["tests/explorer/**/*.js"], languageOptions: { globals: globals.node, ecmaVersion: 2024 } },
];
