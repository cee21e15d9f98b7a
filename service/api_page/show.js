// Draws the API. No validator is asked: it would be one on the internet.
SwaggerUIBundle({ url: "openapi.json", dom_id: "#api", deepLinking: true, validatorUrl: null });
