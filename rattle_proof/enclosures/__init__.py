"""Proofs of where motions end: enclosures of the impact map, targets, and what grows from them.

With NumPy and Numba alone, on `rattle_kernels`. The first proof compiles these kernels, in a minute.
"""

from rattle_kernels.numerics.jit import key_by

key_by(__path__[0])

MOST_LEVELS = 3
"""How often a cell that is not proven whole is cut into four at most."""
