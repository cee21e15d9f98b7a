"""Routes: validate, call one function, translate."""
