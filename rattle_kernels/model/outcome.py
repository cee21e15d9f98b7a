"""Outcome codes that stand beside every result: that a motion ends is no error."""

from enum import IntEnum


class Outcome(IntEnum):
    """How one initial condition ended. Codes are append-only."""

    RETURNED = 0
    """Left ``Phi = +beta`` again; time and velocity are those of that departure."""
    PERMANENT_CONTACT = 1
    """Never rattles again: contact does not end, or ever lower bounces have captured the motion."""
    NOT_CONVERGED = 2
    """A root-finder gave up. None is expected; the result is NaN and is counted, never hidden."""
    OUTSIDE_SECTION = 3
    """The input is no departure, as a motion that has come to rest is none. The result is NaN."""


# The codes as plain integers, which kernels compare.
OUTCOME_RETURNED = int(Outcome.RETURNED)
OUTCOME_PERMANENT_CONTACT = int(Outcome.PERMANENT_CONTACT)
OUTCOME_NOT_CONVERGED = int(Outcome.NOT_CONVERGED)
OUTCOME_OUTSIDE_SECTION = int(Outcome.OUTSIDE_SECTION)
