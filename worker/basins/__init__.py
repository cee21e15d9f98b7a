"""From the job of a basin or a sweep to its finished store."""
