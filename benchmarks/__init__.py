"""Speed, as a ratio to plain methods of the same run."""
