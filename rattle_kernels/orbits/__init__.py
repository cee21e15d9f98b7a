"""Periodic orbits: search, continuation, bifurcations and their diagrams."""
