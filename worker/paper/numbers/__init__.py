"""Numbers that figures report."""
