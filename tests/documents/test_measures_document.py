"""The numbers that docs/guide/measures.md prints are those that its own code finds."""

import pytest

from tests.printed import demand_as_printed


def test_the_measures_of_the_papers_panel_are_as_printed(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("RATTLE_CACHE", str(tmp_path))
    # A cell on a boundary may go the other way on another processor.
    demand_as_printed("guide/measures.md", capsys, after="## Fig. 7 (bottom)", rtol=5e-3, atol=5e-3)


@pytest.mark.slow
def test_the_dimension_of_its_boundary_is_as_printed(capsys):
    demand_as_printed("guide/measures.md", capsys, after="### Is the boundary fractal?", rtol=5e-3, atol=5e-3)


def test_the_shares_of_own_departures_are_as_printed(capsys):
    demand_as_printed("guide/measures.md", capsys, after="## Departures of one's own", atol=2e-3)
