"""Middleware for every request and response: limits, authentication, headers, metrics."""
