"""The HTTP service and the command line: validate, record, answer; no mathematics."""
