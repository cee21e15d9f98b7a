"""Proofs beside `rattle`: of each cell of a basin, that every departure in it ends as it is coloured; and of motions.

`enclosures` has the mathematics, `verification` proves again what a store claims, by other means. `chaos` has what is
proven of chaotic motions, `stiffness` what is proven of the piecewise linear model.

Floors, the highest first; each imports from lower ones alone ::

    command
    verifying | proving_chaos | proving_orbits | addition
    stiffness
    verification | chaos
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
    ("rattle verify basin.zarr --cells all", "rattle verify basin.zarr --boxes all"),
)
"""``rattle verify``: the entry point `verify` of `rattle.commands` names it."""

CHAOS = (
    "rattle_proof.command:prove_chaos",
    "Prove that chaos is chaos: its topological entropy is positive, and its short cycles repel.",
    (
        "rattle prove-chaos --damping 0.65",
        "rattle prove-chaos --tolerance damping=.59999:.60001 --columns 1024 --cycles 0",
    ),
)
"""``rattle prove-chaos``: the entry point `prove-chaos` of `rattle.commands` names it."""

ORBITS = (
    "rattle_proof.command:prove_orbits",
    "Prove that motions of finite stiffness attract: permanent contact and periodic orbits.",
    ("rattle prove-orbits --stiffness 1e5", "rattle prove-orbits --stiffness 1e4 --contact-damping 0.1 --json"),
)
"""``rattle prove-orbits``: the entry point `prove-orbits` of `rattle.commands` names it."""
