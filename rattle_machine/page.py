"""One page for the person who decides: what a machine does, how loud, how often, and which tolerance is to blame.

The page is one HTML file with its pictures inside. It needs no network, and prints on A4. It is put together from what
was computed: the same numbers give the same bytes.
"""

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from importlib.resources import files
from typing import Any, Literal

import numpy as np
import xarray as xr
from jinja2 import Environment
from markupsafe import Markup
from matplotlib.figure import Figure

from rattle_machine.estimates import in_words, with_error
from rattle_machine.numbers import RPM, unit_of
from rattle_machine.pulses import PulseStudy
from rattle_machine.tolerances import QUIET, Range, ToleranceStudy
from worker.gear_pair import GearPair
from worker.pictures.figure_file import PictureFormat, new_figure, save_figure
from worker.results.shares import draw_shares

_LISTED = 12
_WORDS = {
    "speed": "speed of the driven shaft", "inertia": "inertia of the driven shaft",
    "inertia_ratio": "ratio of inertias, driven to driving", "drag_torque": "drag torque on the driven shaft",
    "base_radius": "base radius of the driven gear", "backlash": "backlash along the line of action",
    "mesh_stiffness": "mesh stiffness", "contact_damping": "damping ratio of the contact",
    "restitution": "restitution of an impact", "drag_law": "drag torque over speed",
    "turns": "turns after which the transmission error repeats",
}  # fmt: skip
_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_NOT_MODELLED = (
    "Speeds are mean speeds in steady motion. A run-up from rest and a load that changes with time are not looked at.",
    "The shafts are rigid, and there is one mesh: other meshes, bearings and the housing do not move.",
    "Drag is linear in speed within a turn; the driving torque is constant.",
    "There is no film of oil between the teeth: what it takes is part of the restitution or of the damping.",
    "Impact power is what the teeth exchange, not the sound that the housing radiates.",
)


@dataclass(frozen=True)
class _Part:
    """A text, a note, a list, a table, or a picture."""

    kind: Literal["text", "note", "list", "table", "picture"]
    text: str = ""
    head: Sequence[str] = ()
    rows: Sequence[Any] = ()
    numbers: Sequence[int] = ()
    svg: Markup | str = ""


@dataclass(frozen=True)
class _Section:
    heading: str
    parts: Sequence[_Part]


@dataclass(frozen=True)
class Findings:
    """What was computed for a report.

    Parameters
    ----------
    machine : GearPair
    basin : xarray.Dataset
        At the machine's own speed.
    over : xarray.Dataset
        The machine at several speeds.
    pulses : PulseStudy, optional
    production : ToleranceStudy, optional
    """

    machine: GearPair
    basin: xr.Dataset
    over: xr.Dataset
    pulses: PulseStudy | None
    production: ToleranceStudy | None

    @property
    def answers(self) -> list[str]:
        """What the person who decides reads first."""
        return _answers(self.machine, self.basin, self.pulses, self.production)

    def page(self, title: str) -> str:
        """The page as HTML.

        Parameters
        ----------
        title : str
            Which machine it is.

        Returns
        -------
        str
        """
        pair, of_pulses, production = self.machine, self.pulses, self.production
        sections = [
            _machine_section(pair), _gamma_section(pair, self.over), _basin_section(pair, self.basin),
            _speed_section(pair, self.over),
            *([] if of_pulses is None else [_pulse_section(of_pulses)]),
            *([] if production is None else [_tolerance_section(pair, production)]),
            _Section("What is not modelled", [_Part("list", rows=_NOT_MODELLED)]),
        ]  # fmt: skip
        template = Environment(autoescape=True, trim_blocks=True).from_string(
            files("rattle_machine").joinpath("report.html").read_text(encoding="utf-8")
        )
        made = (
            f"Computed by gear-rattle {version('gear-rattle')}. All numbers are of the model that is described below."
        )
        text = template.render(
            title=f"{title}: does it rattle?", sections=sections, answers=self.answers, made=made
        )  # fmt: skip
        return text + "\n"


def _answers(
    pair: GearPair, basin: xr.Dataset, of_pulses: PulseStudy | None, production: ToleranceStudy | None
) -> list[str]:
    quiet = float(basin.share.values[0])
    top = float(basin.rattle.job.grid.velocity_stop) * pair.scales.speed
    speed, of_drag = f"{pair.speed * RPM:.6g} rpm", f"inertia torque is {100.0 * pair.gamma:.3g} % of drag torque"
    all_ways = f"all ways in which its teeth part with up to {_with_prefix(top, 'm/s')}"
    if pair.can_be_quiet:
        line = f"At {speed} the machine can run quietly: {of_drag}. Of {all_ways}, {100.0 * quiet:.3g} % end in quiet."
    else:
        power = _or_unknown(basin.rattle.loudness().expected_impact_power_w.item(), "W")
        line = f"At {speed} the machine always rattles: {of_drag}, and no motion keeps the teeth together. "
        line += f"Expected impact power, over {all_ways}: {power}."
    lines = [line]
    if of_pulses is not None:
        if of_pulses.lasting.value:
            lines.append(
                f"Of the torque pulses {100.0 * of_pulses.lasting.value:.3g} % end in rattle that lasts: once in "
                f"{in_words(of_pulses.time_between.value)} on average."
            )
        else:
            low, _ = of_pulses.time_between_interval
            lines.append(
                f"None of {of_pulses.departures:,} torque pulses ends in rattle that lasts: less often than once in "
                f"{in_words(low)} (95 %)."
            )
    if production is not None:
        bad = production.production.bad.times(100.0)
        line = f"Of the production {bad} % are quiet after less than {100.0 * production.limit:g} % of departures."
        if production.guilty is not None:
            line += f" The tolerance of {_in_words(production.guilty)} is to blame most."
        if production.tightened is not None:
            tight, then = production.tightened
            line += f" Within {_between(tight)} it is {then.bad.times(100.0)} %."
        lines += [line, *_always_rattling(pair, production)]
    return lines


def _always_rattling(pair: GearPair, production: ToleranceStudy) -> list[str]:
    """How many machines are loose, as a sentence; none if none is."""
    part = float((production.table["gamma"] >= 1.0).mean())
    of_all, why = f"{100.0 * part:.3g} % of all machines of the production", "inertia torque reaches drag torque"
    said = f"{of_all} always rattle: {why}." if pair.mesh_stiffness is None else f"In {of_all} {why}."
    return [said] if part else []


def _in_words(name: str) -> str:
    if name.startswith("transmission_error."):
        _, order, part = name.split(".")
        return f"the {part} of order {order} of the transmission error"
    return f"the {_WORDS.get(name, name.replace('_', ' '))}"


def _with_prefix(value: float, unit: str) -> str:
    """A number with the prefix that makes it 1 to 1000."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g} {unit}"
    size, prefix = next((each for each in _PREFIXES if abs(value) >= each[0]), _PREFIXES[-1])
    return f"{value / size:.4g} {prefix}{unit}"


def _written(value: float, unit: str) -> str:
    if unit == "rad/s":
        return f"{value * RPM:.6g} rpm"
    if unit == "kg m^2":
        return f"{value:.4g} kg m²"
    if unit in ("m", "N m", "N/m"):
        return _with_prefix(value, unit)
    return f"{value:.6g} {unit}".rstrip()


def _between(limits: Range) -> str:
    return f"{_written(limits.low, limits.unit)} to {_written(limits.high, limits.unit)}"


def _machine_section(pair: GearPair) -> _Section:
    fields = pair.model_dump(exclude_none=True)
    orders = fields.pop("transmission_error")
    rows = [
        (_WORDS[name], value if isinstance(value, str) else _written(float(value), unit_of(name)))
        for name, value in fields.items()
    ]
    for order, each in sorted(orders.items()):
        phase = f", phase {each['phase']:.4g} periods" if each["phase"] else ""
        rows.append((f"transmission error, order {order}", _written(each["amplitude"], "m") + phase))
    model, scales = pair.oscillator, pair.scales
    numbers = [
        ("damping δ", f"{model.damping:.6g}"), ("half backlash β", f"{model.half_backlash:.6g}"),
        ("eccentricity ε", f"{model.eccentricity:.6g}"),
    ]  # fmt: skip
    if math.isfinite(model.stiffness):
        numbers += [("stiffness κ", f"{model.stiffness:.6g}"), ("contact damping ζ", f"{model.contact_damping:.6g}")]
    else:
        numbers.append(("restitution r", f"{model.restitution:.6g}"))
    units = [
        ("a forcing period", _with_prefix(scales.time, "s")), ("a speed of 1", _with_prefix(scales.speed, "m/s")),
        ("an impact power of 1", _with_prefix(scales.power, "W")),
        ("a torque pulse that changes the speed by 1", _with_prefix(scales.impulse, "N m s")),
    ]  # fmt: skip
    return _Section(
        "The machine",
        [
            _Part("table", head=("", "value"), rows=rows, numbers=[1]),
            _Part("table", "In the model", ("", "value"), numbers, [1]),
            _Part("table", "One unit of the model", ("", "is"), units, [1]),
        ],
    )


def _reaches_beyond(over: xr.Dataset) -> bool:
    """Whether Gamma reaches 1 at one of the speeds."""
    return bool((over["gamma"] >= 1.0).any())


def _gamma_section(pair: GearPair, over: xr.Dataset) -> _Section:
    speed = pair.threshold_speed
    beyond = "what differs is how loud" if _reaches_beyond(over) else "this page does not reach so far"
    springs = pair.mesh_stiffness is not None
    above = (
        "With a mesh stiffness the force between the teeth also depends on how the mesh vibrates."
        if springs
        else f"From there on the teeth part in every turn: the machine always rattles, and {beyond}."
    )
    reached = (
        "It never reaches 1, since there is no transmission error."
        if math.isinf(speed)
        else f"It reaches 1 at {speed * RPM:.6g} rpm. {above}"
    )
    presses = "The mesh can press" if springs else "Below 1, drag presses"
    parts = (
        "No motion presses the teeth together all the time. They part again and again, whatever they did before."
        if springs
        else "Above 1, inertia parts the teeth for some of each turn, whatever they did before. They may come to rest "
        "in between, and are thrown again."
    )
    meant = (
        f"{presses} the teeth together all the time, and a machine that runs quietly goes on so. A disturbance can "
        "still part the teeth. Then they bounce until they are quiet again, or rattle for ever. The next sections say "
        "which."
        if pair.can_be_quiet
        else f"{parts} The next sections say in which motions they rattle, and how loud each is."
    )
    return _Section(
        "Inertia torque over drag torque",
        [
            _Part("text", f"Γ = {pair.gamma:.4g} at {pair.speed * RPM:.6g} rpm. {reached}"),
            _Part("text", meant),
        ],
    )


def _basin_section(pair: GearPair, basin: xr.Dataset) -> _Section:
    scales, heard, can_be_quiet = pair.scales, basin.rattle.loudness(), pair.can_be_quiet
    # Quiet, the first motion, is none of a machine that always rattles.
    order = np.argsort(-basin.share.values, kind="stable")
    order = order if can_be_quiet else order[order > 0]
    rows = []
    for place in order[:_LISTED].tolist():
        motion = heard.isel(attractor=place)
        rows.append(
            (
                str(basin["name"].values[place]),
                f"{100.0 * float(basin.share.values[place]):.3g} %",
                _or_unknown(float(motion.impacts_per_period) / scales.time, "/s"),
                _or_unknown(float(motion.largest_impact_speed_m_s), "m/s"),
                _or_unknown(float(motion.impact_power_w), "W"),
                _part_of_time(float(motion.time_in_contact)),
            )  # fmt: skip
        )
    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    axes = figure.subplots()
    basin.rattle.plot(ax=axes, overlays=["grazing"])
    more = [] if order.size <= _LISTED else [_Part("note", f"And {order.size - _LISTED} more motions.")]
    named = "P(m, n, l) repeats after m forcing periods with n impacts on one flank and l on the other"
    named = f"Permanent contact is quiet. {named}." if can_be_quiet else f"{named}; bounces that come to rest are one."
    proven = []
    if can_be_quiet and pair.gamma < 1.0:
        quiet = _with_prefix(float(basin.rattle.proven_quiet().min()) * scales.speed, "m/s")
        told = (
            f"Teeth that part with less than {quiet}, at any moment, fall quiet: that is proven by a bound, not tried."
        )
        proven = [_Part("text", told)]
    return _Section(
        "What it ends in when its teeth have parted",
        [
            _Part(
                "table",
                "Motions",
                ("motion", "share", "impacts", "fastest impact", "impact power", "teeth touch"),
                rows,
                [1, 2, 3, 4, 5],
            ),
            *more,
            _Part("text", f"{named} Shares are of all moments and speeds in the picture."),
            _Part("picture", "The motion that the teeth end in, by when and how fast they part.", svg=_as_svg(figure)),
            *proven,
        ],
    )


def _or_unknown(value: float, unit: str) -> str:
    return "not known" if math.isnan(value) else _with_prefix(value, unit) if value else "none"


def _part_of_time(value: float) -> str:
    return "not known" if math.isnan(value) else f"{100.0 * value:.3g} % of the time" if value else "at impacts alone"


def _speed_section(pair: GearPair, over: xr.Dataset) -> _Section:
    figure = Figure(layout="constrained")  # of no window: it is drawn in any thread
    draw_shares(over, figure)
    never = ", and no departure ends in quiet" if pair.mesh_stiffness is None else ""
    loose = f"From {pair.threshold_speed * RPM:.6g} rpm on Γ is 1 or more{never}."
    return _Section(
        "What it does at other speeds",
        [
            _Part("picture", "Shares of motions, loudness and Γ over speed.", svg=_as_svg(figure)),
            *([_Part("text", loose)] if _reaches_beyond(over) else []),
            _Part(
                "note",
                f"At each speed the machine runs steadily: this is no run-up. Its drag torque is {pair.drag_law} over "
                "speed.",
            ),
        ],
    )


def _pulse_section(study: PulseStudy) -> _Section:
    rows = [
        ("is quiet at once", f"{study.quiet.times(100.0)} %", "", ""),
        ("rattles, then is quiet", f"{study.passing.times(100.0)} %", with_error(study.passing_time), ""),
    ]
    rows += [
        (f"rattles on in {each.name}", f"{each.share.times(100.0)} %", "on", f"{each.impact_power} W")
        for each in study.rattles
    ]
    return _Section(
        "How often",
        [
            _Part("text", f"Torque pulses on the driven shaft, one in {in_words(1.0 / study.rate)} on average."),
            _Part("table", "After a pulse the machine", ("", "share", "lasts", "impact power"), rows, [1, 2, 3]),
            _Part(
                "text",
                f"Quiet is kept for {in_words(study.kept_at_least)} on average, at least (95 %). Expected impact power "
                f"after a pulse: {study.impact_power} W.",
            ),
        ],
    )


def _tolerance_section(pair: GearPair, study: ToleranceStudy) -> _Section:
    rows = [
        (_in_words(each.name), _written(each.low, each.unit), _written(each.high, each.unit)) for each in study.ranges
    ]
    blamed = [
        (
            _in_words(str(row["number"])), f"{row['first']:.2f}",
            f"{row['total']:.2f} ({row['total_low']:.2f} to {row['total_high']:.2f})",
        )
        for row in study.indices.sort_values("total", ascending=False).to_dict("records")
    ]  # fmt: skip
    figure = new_figure(7.0, 3.0)
    axes = figure.subplots()
    axes.hist(100.0 * study.table[QUIET], bins=30, color="#0b5394")
    axes.set_xlabel("departures after which a machine is quiet (%)")
    axes.set_ylabel("machines")
    parts = [
        _Part("table", f"{len(study.table):,} machines within", ("number", "from", "to"), rows, [1, 2]),
        _Part("picture", "How quiet the machines of the production are.", svg=_as_svg(figure)),
    ]
    for said in _always_rattling(pair, study):
        power = f"Mean of the expected impact power, over all for which it is known: {study.production.power} W."
        parts.append(_Part("text", f"{said} {power}"))
    if study.guilty is not None:
        parts.append(
            _Part(
                "table", "What the quiet share depends on (Sobol's indices)", ("number", "alone", "with all others"),
                blamed, [1, 2],
            )
        )  # fmt: skip
    if study.tightened is not None:
        tight, then = study.tightened
        parts.append(
            _Part(
                "text",
                f"With {_in_words(tight.name)} within {_between(tight)}, {then.bad.times(100.0)} % of the machines are "
                f"quiet after less than {100.0 * study.limit:g} % of departures, in place of "
                f"{study.production.bad.times(100.0)} %.",
            )
        )
    if study.proven is not None:
        parts.append(_Part("text", str(study.proven)))
    return _Section("Which tolerance", parts)


def _as_svg(figure: Figure) -> Markup:
    """A figure as an SVG element."""
    file = io.BytesIO()
    save_figure(figure, file, PictureFormat.SVG)
    text = file.getvalue().decode()
    # No declaration and no document type within HTML. The figure is the project's own: nothing in it is a user's.
    return Markup(text[text.index("<svg") :])
