"""The command that makes harmonics of a measured transmission error."""

import json
import math
from pathlib import Path
from typing import Annotated, Any

import typer

from rattle.cli.console import give_up, out
from rattle.measured_curve import COLUMNS
from rattle.measured_curve import transmission_error as measured_curve
from rattle_kernels import AngleUnit, Oscillator, TransmissionError

_DAMPING = Oscillator().damping


def transmission_error(
    curve: Annotated[Path, typer.Argument(help="CSV file of angle and error, over one revolution or more")],
    unit: Annotated[AngleUnit, typer.Option(help="Of the angle")] = AngleUnit.TURNS,
    explained: Annotated[float, typer.Option(help="Keep the fewest orders that explain this part of it")] = 0.99,
    scale: Annotated[float, typer.Option(help="Errors times this are in the units of --half-backlash")] = 1.0,
    columns: Annotated[tuple[str, str], typer.Option(help="Names of the columns of angle and error")] = COLUMNS,
    damping: Annotated[float, typer.Option(help="delta, for which Eq. (8) is checked")] = _DAMPING,
    as_json: Annotated[bool, typer.Option("--json", help="Print what is found as JSON alone")] = False,
) -> None:
    """Make harmonics of a measured transmission error: the options to copy, and what they leave out."""
    try:
        error = measured_curve(curve, unit=unit, explained=explained, scale=scale, columns=columns)
    except ValueError as fault:
        give_up(str(fault), 2)
    if not 0.0 < damping < math.inf:
        give_up(f"damping must be positive and finite, not {damping:g}", 2)
    if as_json:
        typer.echo(json.dumps(_as_json(error, damping), indent=1))
        return
    for line in _report(error, damping):
        out.print(line, highlight=False, soft_wrap=True)


def _as_json(error: TransmissionError, damping: float) -> dict[str, Any]:
    """Eccentricity and harmonics as requests have them, and the report."""
    least, phase = error.least_acceleration(damping)
    return {
        "eccentricity": error.eccentricity,
        "harmonics": [each._asdict() | {"order": int(each.order)} for each in error.harmonics],
        "shift": error.shift,
        "explained": error.explained,
        "left_out": error.left_out._asdict(),
        "scale": error.scale,
        "highest_order": error.highest,
        "damping": damping,
        "least_acceleration": least,
        "least_acceleration_phase": phase,
        "defined": least > 0.0,
    }


def _report(error: TransmissionError, damping: float) -> list[str]:
    """What a person asks, and the options to copy."""
    kept = ", ".join(map(str, error.orders))
    left, (least, phase) = error.left_out, error.least_acceleration(damping)
    rest = "" if left.order is None else f"; the largest order among it is {left.order}, with {left.amplitude:.3g}"
    verdict = "holds" if least > 0.0 else "does not hold, and no basin can be computed"
    options = [f"--harmonic {order:g}:{amplitude!r}:{phase!r}" for order, amplitude, phase in error.harmonics]
    return [
        f"kept: order {kept}, which explain {100.0 * error.explained:.4g} % of the variance",
        f"left out: rms {left.rms:.3g}{rest} (of orders up to {error.highest}, scaled by {error.scale:g})",
        f"t = 0 lies at {error.shift:.6g} turns of the measurement",
        f"Eq. (8) at damping {damping:g} {verdict}: the least acceleration is {least:.4g}, at t = {phase:.4f}",
        " ".join([f"--eccentricity {error.eccentricity!r}", *options]),
    ]
