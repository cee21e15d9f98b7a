"""Contents of answers: jobs, results, files, events."""
