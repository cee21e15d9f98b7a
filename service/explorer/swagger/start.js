/* Swagger UI (Apache 2.0, see LICENSE and NOTICE) shows this service's own description. */
window.SwaggerUIBundle({ url: "openapi.json", dom_id: "#swagger", deepLinking: true, validatorUrl: null });
