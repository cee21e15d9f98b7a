"""The numbers that figures report."""
