"""The commands that guard a service: keys for its callers, certificates for its cluster."""
