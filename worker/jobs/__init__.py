"""Jobs: what may be asked, checked once."""
