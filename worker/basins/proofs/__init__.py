"""The proof of a basin: its tasks, the order in which they run, and the certificate."""
