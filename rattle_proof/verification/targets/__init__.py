"""Proofs of targets again: the quiet core, and discs around periodic orbits."""
