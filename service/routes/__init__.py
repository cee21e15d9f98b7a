"""Routes of the API: validate, call one function, translate."""
