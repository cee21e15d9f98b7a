"""The HTTP service: validate, record, respond; no mathematics."""
