"""Tables of what analyses have found: of their results as the service tells them."""

from typing import Any

from rich.table import Table

from service.cli.console import out

_MOST_ROWS = 40


def print_analysis(result: dict[str, Any]) -> None:
    """Tables of a result, of whatever kind."""
    _PRINTERS[result["kind"]](result)


def _more(total: int) -> None:
    if total > _MOST_ROWS:
        out.print(f"and {total - _MOST_ROWS} more, in the store", highlight=False)


def _print_bifurcation(result: dict[str, Any]) -> None:
    table = Table("motion", "way", "from", "to", "what", title=f"along {result['parameter']}")
    rows = [
        (f"{number}: {motion['name']}", run)
        for number, motion in enumerate(result["motions"])
        for run in motion["stretches"]
    ]
    for name, run in rows[:_MOST_ROWS]:
        table.add_row(name, run["way"], f"{run['start']:.8g}", f"{run['stop']:.8g}", run["what"])
    out.print(table)
    _more(sum(motion["stretches_total"] for motion in result["motions"]))


_PRINTERS = {"bifurcation": _print_bifurcation}
