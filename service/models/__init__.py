"""Models of requests and responses over HTTP."""
