"""Tables of results of every kind, as the service returns them."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import typer
from rich.table import Column, Table

from rattle.cli.console import out
from worker.additions import additions
from worker.motion_words import ends_in_words

_MOST_ROWS = 40
_MOST_CHANGES = 20
_OF_ALL_KINDS = {"complete", "request", "pieces_done", "seconds", "zarr", "kind"}


def print_result(kind: str, result: dict[str, Any], *, as_json: bool = False) -> None:
    """Print a result as tables.

    Parameters
    ----------
    kind : str
        Kind of the job.
    result : dict
        Result as JSON.
    as_json : bool
        Whether to print JSON unchanged.
    """
    if as_json:
        typer.echo(json.dumps(result, indent=2))
        return
    _PRINTERS.get(kind, _print_other)(result)
    _print_seconds(result["seconds"])


def _print_other(result: dict[str, Any]) -> None:
    out.print_json(data={name: value for name, value in result.items() if name not in _OF_ALL_KINDS})


def _print_basins(result: dict[str, Any]) -> None:
    alone = result["basins"][0]["shares"] if len(result["basins"]) == 1 else []
    print_solutions(result["solutions"], {each["solution"]: each["standard_error"] for each in alone})
    if len(result["basins"]) == 1 and result["basins"][0]["expected"]:
        _print_expected(result["basins"][0]["expected"])
    names = [solution["name"] for solution in result["solutions"]]
    _print_changes(
        [
            (each["kind"], each["solution"], names[each["solution"]], each["parameter"], each["before"], each["after"])
            for each in result["changes"]
        ]
    )


def print_solutions(solutions: Sequence[Mapping[str, Any]], errors: Mapping[int, float | None] | None = None) -> None:
    """Print a table of solutions: name, share (and what packages say of it), exponent, power, life of chaos, a point.

    `errors` are the standard errors of shares that come from a sample, by number.
    """
    table = Table("", "solution", "share", "Lyapunov exponent", "impact power", "a departure (t, v)")
    names = [str(solution["name"]) for solution in solutions]
    for number, solution in enumerate(solutions):
        share, exponent, points = solution["share"], solution["lyapunov_exponent"], solution["points"]
        power = solution["impact_power"]
        life, error = solution["mean_life"], solution["mean_life_error"]
        # A service of an earlier version does not say what transients end in.
        ends = ends_in_words([(end["solution"], end["share"]) for end in solution.get("ends", ())], names)
        ends = f", {ends}" if ends else ""
        table.add_row(
            str(number),
            solution["name"] if life is None else f"{solution['name']} for some {life:.1g} ± {error:.1g} impacts{ends}",
            _share(share, (errors or {}).get(number)) + "".join(each.in_words(solution) for each in additions()),
            "" if exponent is None else f"{exponent:.4f}",
            "" if power is None else f"{power:.4g}",
            f"({points[0][0]:.6f}, {points[0][1]:.6f})" if points else "",
        )
    out.print(table)


def _share(share: float | None, error: float | None) -> str:
    if share is None:
        return "not known yet"
    return f"{100 * share:.3f} %" if error is None else f"{100 * share:.3f} ± {100 * error:.2g} %"


def _print_expected(expected: Mapping[str, float]) -> None:
    """Print how loud a basin is on average, and the share of cells that count as silent as they are undecided."""
    rate, speed, power = (expected[name] for name in ("impacts_per_period", "largest_impact_speed", "impact_power"))
    left = expected["undecided_share"]
    note = f" ({100 * left:.3g} % undecided, counted as silent)" if left else ""
    line = f"expected: {rate:.4g} impacts a period, largest impact speed {speed:.4g}, impact power {power:.4g}{note}"
    out.print(line, highlight=False, soft_wrap=True)


def _print_changes(rows: Sequence[tuple[str, int, str, str, float, float]]) -> None:
    """Print births and deaths of solutions: kind, number, name, parameter, its values before and after."""
    for kind, number, name, parameter, before, after in rows[:_MOST_CHANGES]:
        out.print(f"{kind} of {number}: {name} between {parameter} {before:g} and {after:g}", highlight=False)
    if len(rows) > _MOST_CHANGES:
        out.print(f"and {len(rows) - _MOST_CHANGES} more births and deaths", highlight=False)


def _print_seconds(seconds: Mapping[str, Any]) -> None:
    """Print how long each stage took."""
    if seconds:
        stages = ", ".join(f"{name.replace('_', ' ')} {value:.2f} s" for name, value in seconds.items())
        out.print(stages, highlight=False, soft_wrap=True)


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


def _stability(orbit: dict[str, Any]) -> str:
    if orbit["attracts"]:
        return "attracts"
    return "unstable" if any(imaginary for _, imaginary in orbit["multipliers"]) else "saddle"


def _complex(pair: list[float]) -> str:
    return f"{pair[0]:.4g}{pair[1]:+.4g}i" if pair[1] else f"{pair[0]:.6g}"


def _print_table_of_orbits(orbits: list[dict[str, Any]]) -> None:
    """Table of periodic orbits, each by its slowest departure."""
    columns = (Column(name, no_wrap=True) for name in ("orbit", "t", "v", "multipliers"))
    table = Table("", *columns, "grazing", "residual")
    for number, orbit in enumerate(orbits[:_MOST_ROWS]):
        first = orbit["departures"][0]
        table.add_row(
            str(number), f"{orbit['name']}\n{_stability(orbit)}", f"{first['time']:.10f}", f"{first['velocity']:.10f}",
            "\n".join(_complex(pair) for pair in orbit["multipliers"]), f"{orbit['grazing_distance']:.4g}",
            f"{orbit['residual']:.0e}",
        )  # fmt: skip
    out.print(table)
    _more(len(orbits))


def _print_orbits(result: dict[str, Any]) -> None:
    _print_table_of_orbits(result["orbits"])
    for number, branch in enumerate(result["branches"]):
        name = result["orbits"][branch["orbit"]]["name"]
        ends = "; ".join(end["message"] for end in branch["ends"])
        out.print(f"branch {number} of {name}, {branch['points']} points: {ends}", highlight=False, soft_wrap=True)
    if result["special_points"]:
        table = Table("", "special point", Column("value", no_wrap=True), "orbit", "branch", "error", "residual")
        for number, point in enumerate(result["special_points"][:_MOST_ROWS]):
            table.add_row(
                str(number), _kind_of(point), f"{point['value']:.13g}", point["orbit"], str(point["branch"]),
                f"{point['error']:.0e}", f"{point['residual']:.0e}",
            )  # fmt: skip
        out.print(table)
        _more(len(result["special_points"]))
    for curve in result["curves"]:
        ends = "; ".join(curve["ends"])
        line = f"curve of special point {curve['special_point']}, {curve['points']} points: {ends}"
        out.print(line, highlight=False, soft_wrap=True)


def _kind_of(point: dict[str, Any]) -> str:
    return f"{point['kind']}, {point['graze']['scenario']}" if point["graze"] else str(point["kind"])


def _print_manifold(result: dict[str, Any]) -> None:
    _print_table_of_orbits(result["saddles"])
    for branch in result["branches"][:_MOST_ROWS]:
        name = f"{branch['saddle']}: {result['saddles'][branch['saddle']]['name']}"
        where = f"departure {branch['departure']}, {'later' if branch['side'] > 0 else 'earlier'} phases"
        size = f"arclength {branch['arclength']:.4f}, {branch['pieces']} pieces, {branch['vertices']} vertices"
        out.print(
            f"{branch['manifold']} branch of {name}, {where}: {size}; {branch['end']}", highlight=False, soft_wrap=True
        )
    _more(len(result["branches"]))


def _print_grazing_curve(result: dict[str, Any]) -> None:
    table = Table("order", "pieces", "vertices", "arclength", "")
    for order in result["orders"]:
        note = "" if order["complete"] else "incomplete: it needs more points than allowed"
        sizes = (f"{order['arclength']:.4f}", note)
        table.add_row(*(str(order[name]) for name in ("order", "pieces", "vertices")), *sizes)
    out.print(table)


def what_is_missing(kind: str, result: dict[str, Any]) -> str | None:
    """What a result lacks that was asked for, and what to ask for instead; None if nothing.

    Parameters
    ----------
    kind : str
        Kind of the job.
    result : dict
        As from `summarise`.

    Returns
    -------
    str or None
    """
    if kind != "grazing_curve":
        return None
    missing = [order["order"] for order in result["orders"] if not order["complete"]]
    if not missing:
        return None
    which = f"order {missing[0]} is" if len(missing) == 1 else f"orders {missing[0]} to {missing[-1]} are"
    highest = f"--order {missing[0] - 1}, " if missing[0] > 0 else ""
    return (
        f"{which} incomplete: order {missing[0]} needs more points than a request may have; ask for {highest}"
        "coarser curves or lower speeds"
    )


_PRINTERS = {
    "basin": _print_basins,
    "sweep": _print_basins,
    "bifurcation": _print_bifurcation,
    "orbits": _print_orbits,
    "manifold": _print_manifold,
    "grazing_curve": _print_grazing_curve,
}
