"""The numbers that docs/theory/manifolds.md prints are those that its own code finds."""

from tests.printed import demand_as_printed


def test_saddles_manifolds_and_shares_are_as_printed(capsys):
    # A cell on a boundary may go the other way on another processor.
    demand_as_printed("theory/manifolds.md", capsys, rtol=5e-3, atol=5e-3)
