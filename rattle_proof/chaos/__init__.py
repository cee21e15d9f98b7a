"""Chaos that is chaos: a positive topological entropy of P on a set that it maps into itself, by proof.

Floors, the highest first; each imports from lower ones alone ::

    entropy
    leaf_search
    crossings
    leaves
"""

from rattle_kernels.numerics.jit import key_by

key_by(__path__[0])
