"""Proofs of where motions end: enclosures of the impact map, targets, and what grows from them."""
