"""Proofs of basins, beside `rattle`: of each cell, that every departure in it ends as the cell is coloured.

`enclosures` has the mathematics, `verification` proves again what a store claims, by other means.

Floors, the highest first; each imports from lower ones alone ::

    command
    verifying | addition
    verification
    arguments | page | results | routes | run | unproven
    tasks
    certificate | stored_proof
    arrays
    layout | request
    enclosures
"""

from rattle_proof.verifying import verify

__all__ = ["verify"]
COMMAND = (
    "rattle_proof.command:verify",
    "Prove again, by Arb balls, what a basin's store claims to be proven; exit with 1 if anything is not.",
    ("rattle verify basin.zarr --cells 1000", "rattle verify basin.zarr --boxes all"),
)
"""``rattle verify``: the entry point `verify` of `rattle.commands` names it."""
