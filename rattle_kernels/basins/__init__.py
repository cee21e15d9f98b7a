"""Basins of attraction in memory: the whole of one at once, and the parts of which workers make those of a store."""
