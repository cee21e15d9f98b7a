"""Commands that compute here, without a service, what explains basins: diagrams, orbits, manifolds, grazing curves."""

from typing import Annotated

import typer

from rattle_kernels import CurveResolution, ManifoldLimits, Oscillator
from service.cli.analysis_tables import print_analysis
from service.cli.compute import Out, Workers, swept_of
from service.cli.console import print_seconds
from service.cli.local_run import run_here
from service.cli.oscillator import (
    AllowNoQuietSolution,
    Damping,
    Eccentricity,
    HalfBacklash,
    Rule,
    Stiffness,
    oscillator_of,
)
from service.models.oscillator import PermanentContact
from worker.analyses.run import AnalysisSummary
from worker.errors import InvalidJob
from worker.jobs.analysis_job import Region
from worker.jobs.bifurcation_job import BifurcationJob, Direction
from worker.jobs.grazing_curve_job import GrazingCurveJob
from worker.jobs.manifold_job import Itinerary, ManifoldJob, Side
from worker.jobs.orbits_job import Continuation, OrbitSeed, OrbitsJob

Time = Annotated[tuple[float, float], typer.Option(help="Phases of the region searched")]
Velocity = Annotated[tuple[float, float], typer.Option(help="Speeds of the region searched")]
Kept = Annotated[tuple[float, float], typer.Option(help="Speeds to keep")]
Chord = Annotated[float, typer.Option(help="Longest distance between neighbouring points")]
Angle = Annotated[float, typer.Option(help="Largest angle between chords, radians")]


def bifurcation(
    out_: Out,
    vary: Annotated[str, typer.Option(help="damping=0.5:0.6:1000[:geometric] or damping=0.5,0.55,0.6")],
    damping: Damping = 0.6,
    eccentricity: Eccentricity = 0.1,
    half_backlash: HalfBacklash = 0.6,
    stiffness: Stiffness = None,
    rule: Rule = PermanentContact.ENVELOPE,
    allow_no_quiet_solution: AllowNoQuietSolution = False,
    seed: Annotated[
        list[str] | None, typer.Option(help="Departure t,v to begin with; several; without, attractors are found")
    ] = None,
    time: Time = (0.0, 1.0),
    velocity: Velocity = (0.0, 7.0),
    direction: Annotated[Direction, typer.Option(help="Way in which values are visited")] = Direction.UP,
    transient: Annotated[int, typer.Option(help="Impacts at each value before any are kept")] = 1000,
    kept: Annotated[int, typer.Option(help="Departures kept at each value")] = 20,
    workers: Workers = 2,
) -> None:
    """Compute a bifurcation diagram: last departures at each value, the very last seeding the next value."""
    oscillator = oscillator_of(damping, eccentricity, half_backlash, stiffness, rule)

    def job() -> BifurcationJob:
        swept = swept_of(vary)
        about = oscillator
        if stiffness is None and swept.parameter == "stiffness":
            about = oscillator._replace(stiffness=1.0)
        seeds = tuple(_departure(text) for text in seed or ())
        return BifurcationJob(about, swept, seeds, Region(*time, *velocity), direction, transient, kept)

    run_here(job, out_, workers, _tell, quiet_or_not=allow_no_quiet_solution)


def orbits(
    out_: Out,
    damping: Damping = 0.6,
    eccentricity: Eccentricity = 0.1,
    half_backlash: HalfBacklash = 0.6,
    stiffness: Stiffness = None,
    rule: Rule = PermanentContact.ENVELOPE,
    allow_no_quiet_solution: AllowNoQuietSolution = False,
    longest: Annotated[int, typer.Option(help="Greatest n+ searched for")] = 4,
    time: Time = (0.0, 1.0),
    velocity: Velocity = (0.0, 7.0),
    cells: Annotated[int, typer.Option(help="Cells of the search each way")] = 40,
    seed: Annotated[
        list[str] | None, typer.Option(help="t,v[,period] close to an orbit; several; no search then")
    ] = None,
    follow: Annotated[str | None, typer.Option(help="damping=0.45:0.7[:points]: follow orbits in a parameter")] = None,
    curves: Annotated[
        str | None, typer.Option(help="eccentricity=0.05:0.15[:points]: and special points in a second one")
    ] = None,
    workers: Workers = 2,
) -> None:
    """Find periodic orbits, stable or not; follow them in a parameter and locate special points."""
    oscillator = oscillator_of(damping, eccentricity, half_backlash, stiffness, rule)

    def job() -> OrbitsJob:
        seeds = tuple(_orbit_seed(text) for text in seed or ())
        along = _continuation("follow", follow), _continuation("curves", curves)
        return OrbitsJob(oscillator, longest, Region(*time, *velocity), cells, seeds, *along)

    run_here(job, out_, workers, _tell, quiet_or_not=allow_no_quiet_solution)


def _orbit_seed(text: str, option: str = "seed") -> OrbitSeed:
    """Departure and impact period as the command line writes them."""
    *departure, period = text.split(",") if text.count(",") == 2 else [*text.split(","), "1"]
    try:
        time, velocity = (float(part) for part in departure)
        return OrbitSeed(time, velocity, int(period))
    except ValueError as error:
        raise InvalidJob(f"--{option} {text}: write phase, speed and impact period, as in 0.786,1.613,2") from error


def _continuation(option: str, text: str | None) -> Continuation | None:
    """Parameter to follow something in, as the command line writes it."""
    if text is None:
        return None
    parameter, _, interval = text.partition("=")
    try:
        start, stop, *points = interval.split(":")
        return Continuation(parameter, float(start), float(stop), *(int(count) for count in points))
    except (ValueError, TypeError) as error:
        raise InvalidJob(f"--{option} {text}: write damping=0.45:0.7 or damping=0.45:0.7:5000") from error


def manifold(
    out_: Out,
    saddle: Annotated[list[str], typer.Option(help="t,v[,period] close to a saddle, or P(1,1,0); several")],
    damping: Damping = 0.6,
    eccentricity: Eccentricity = 0.1,
    half_backlash: HalfBacklash = 0.6,
    side: Annotated[Side, typer.Option(help="Which manifolds")] = Side.STABLE,
    arclength: Annotated[float, typer.Option(help="Of each branch")] = 20.0,
    velocity: Kept = (0.0, 7.0),
    chord: Chord = 0.01,
    angle: Angle = 0.2,
    workers: Workers = 2,
) -> None:
    """Grow stable and unstable manifolds of saddles of the impacting model."""

    def job() -> ManifoldJob:
        saddles = tuple(Itinerary.from_text(text) if "(" in text else _orbit_seed(text, "saddle") for text in saddle)
        limits = ManifoldLimits(arclength, *velocity)
        oscillator = Oscillator(damping, eccentricity, half_backlash)
        return ManifoldJob(oscillator, saddles, side, limits, _resolution(chord, angle))

    run_here(job, out_, workers, _tell, quiet_or_not=False)


def grazing_curve(
    out_: Out,
    damping: Damping = 0.6,
    eccentricity: Eccentricity = 0.1,
    half_backlash: HalfBacklash = 0.6,
    order: Annotated[int, typer.Option(help="Highest order of pre-images; 0 is the grazing curve itself")] = 2,
    velocity: Kept = (0.0, 7.0),
    chord: Chord = 0.01,
    angle: Angle = 0.2,
    workers: Workers = 2,
) -> None:
    """Draw the grazing curve of the impacting model and its pre-images."""

    def job() -> GrazingCurveJob:
        oscillator = Oscillator(damping, eccentricity, half_backlash)
        return GrazingCurveJob(oscillator, order, velocity, _resolution(chord, angle))

    run_here(job, out_, workers, _tell, quiet_or_not=False)


def _resolution(chord: float, angle: float) -> CurveResolution:
    """Resolution whose finest chord is the default one, or the chord where that is finer."""
    return CurveResolution(chord, angle, min(chord, CurveResolution().finest))


def _departure(text: str) -> tuple[float, float]:
    """Departure as the command line writes it."""
    try:
        time, velocity = (float(part) for part in text.split(","))
    except ValueError as error:
        raise InvalidJob(f"--seed {text}: write phase and speed of a departure, as in 0.6,3.77") from error
    return time, velocity


def _tell(summary: AnalysisSummary) -> None:
    print_analysis({"kind": summary.kind, **summary.result})
    print_seconds(summary.seconds)
