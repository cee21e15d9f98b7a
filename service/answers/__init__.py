"""Response bodies: jobs, results, files, events."""
