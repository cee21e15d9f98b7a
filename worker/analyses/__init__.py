"""The analyses: bifurcation diagrams, orbits, manifolds and grazing curves."""
