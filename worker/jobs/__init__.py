"""Jobs: requests, checked once."""
