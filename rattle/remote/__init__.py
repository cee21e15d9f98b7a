"""A service elsewhere: its jobs, and the verbs that it computes."""
