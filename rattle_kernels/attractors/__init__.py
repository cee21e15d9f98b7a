"""Attractors: which motion a point ends in."""
