"""Attractors: the motions that trajectories end in."""
