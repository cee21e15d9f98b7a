"""What routes answer with: jobs, results, files, events."""
