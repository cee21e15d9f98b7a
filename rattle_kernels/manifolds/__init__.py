"""Invariant curves: saddles, their manifolds, and pre-images of the grazing curve."""
