"""How often: a quiet machine is hit by torque pulses, and some of them make it rattle.

Pulses come at a rate, each at its own moment (a Poisson process), so its phase is uniform. A pulse of T_imp on the
driven shaft changes the velocity between the teeth by T_imp over `Scales.impulse`. Where the machine departs then is
said in `rattle_kernels.impact_map.pulse`. Each departure is named by the motion that it ends in, and those that fall
quiet are followed until ever lower bounces have captured them.

docs/theory/pulses.md derives each number, its error, and the bound on how long quiet is kept.
"""

import csv
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import pandas as pd
from scipy.stats import binomtest

from rattle_kernels import (
    Attractor,
    AttractorKind,
    departures_after_pulses,
    expected_loudness,
    loudness,
    shares_of,
    until_captured,
)
from rattle_kernels.basin_measures.shares import weighted_shares
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_machine.estimates import Estimate, for_json, in_words, mean_of, with_error
from worker.errors import InvalidJob
from worker.gear_pair import GearPair, in_si

if TYPE_CHECKING:
    from worker.gear_pair import Quantity

Distribution = Literal["normal", "exponential", "fixed"]
Pressing = Literal["bounces", "held"]

_IMPULSE = "N m s"
_CONFIDENCE, _ONE_SIDED = 0.95, 1.96


@dataclass(frozen=True)
class Rattle:
    """A rattling motion that some pulses end in.

    Attributes
    ----------
    name : str
        As ``P(1,1,0)``; of a chaotic transient with its mean life.
    share : Estimate
        Of the pulses.
    time_between : Estimate
        Between pulses that end in it, s.
    impact_power : Estimate
        While it lasts, W; NaN of a motion that is not decided.
    """

    name: str
    share: Estimate
    time_between: Estimate
    impact_power: Estimate


@dataclass(frozen=True)
class PulseStudy:
    """What torque pulses do to a quiet machine.

    Attributes
    ----------
    machine : GearPair
    rate : float
        Of the pulses, 1/s.
    departures : int
        Pulses that were followed.
    quiet, passing, lasting : Estimate
        Shares of pulses: those after which the machine is quiet at once (the teeth do not part, or their bounces are
        captured from the beginning), those after which it rattles and then falls quiet, and those that end in rattle.
    lasting_interval : (float, float)
        Of the last share, at 95 % (Clopper and Pearson).
    time_between : Estimate
        Mean time between pulses that end in rattle, ``1/(rate lasting)``, s; infinite where none did.
    time_between_interval : (float, float)
        At 95 %, s.
    passing_turns, passing_time : Estimate
        Mean length of an episode that passes, from the pulse to capture, in turns of the driven gear and in s.
    longest_turns : float
        The longest of them.
    passing_energy : Estimate
        Mean impact energy of an episode that passes, J.
    passing_power : Estimate
        That of all of them over all time, rate times mean energy of a pulse, W.
    impact_power : Estimate
        Expected after a pulse in the long run, W: the sum over motions of share times impact power.
    kept_at_least : float
        Lower bound (95 %) of the mean time for which quiet is kept, also where pulses meet an episode before it has
        passed, s.
    overlap : float
        Share of pulses whose episode would pass, but is met by the next pulse before it has.
    rattles : tuple of Rattle
        The motions that ``lasting`` is the sum of.
    table : pandas.DataFrame
        Pulse by pulse: ``phase``, ``size_n_m_s``, ``motion``, ``turns`` until captured (infinite of a lasting one),
        ``impacts`` and ``impact_energy_j`` until then (NaN of a lasting one).
    """

    machine: GearPair
    rate: float
    departures: int
    quiet: Estimate
    passing: Estimate
    lasting: Estimate
    lasting_interval: tuple[float, float]
    time_between: Estimate
    time_between_interval: tuple[float, float]
    passing_turns: Estimate
    passing_time: Estimate
    longest_turns: float
    passing_energy: Estimate
    passing_power: Estimate
    impact_power: Estimate
    kept_at_least: float
    overlap: float
    rattles: tuple[Rattle, ...]
    table: pd.DataFrame = field(repr=False, compare=False)

    def to_dict(self) -> dict[str, Any]:
        """Everything but the table, for JSON: a number that is not finite is None.

        Returns
        -------
        dict
        """
        plain = {name: value for name, value in vars(self).items() if name not in ("machine", "table")}
        told: dict[str, Any] = {"machine": self.machine.model_dump(exclude_none=True)}
        for name, value in plain.items():
            told[name] = asdict(value) if isinstance(value, Estimate) else value
        told["rattles"] = [asdict(each) for each in self.rattles]
        return {name: for_json(value) for name, value in told.items()}

    def __str__(self) -> str:
        """Tables for people."""
        rpm = self.machine.speed * 60.0 / (2.0 * math.pi)
        heading = (
            f"{self.departures:,} pulses on a machine at {rpm:.6g} rpm, one in {in_words(1.0 / self.rate)} on average"
        )
        rows = [
            ("after a pulse the machine", "share", "once in", "lasts", "impact power"),
            ("is quiet at once", self.quiet, with_error(self.quiet.times(self.rate).inverse()), "", ""),
            ("rattles, then is quiet", self.passing, with_error(self.passing.times(self.rate).inverse()), "", ""),
        ]
        if self.passing.value:
            lasts = f"{self.passing_turns} turns, {with_error(self.passing_time)}"
            rows[-1] = (*rows[-1][:3], lasts, f"{self.passing_energy} J each")
        for each in self.rattles:
            power = "not known" if math.isnan(each.impact_power.value) else f"{each.impact_power} W"
            rows.append((f"rattles on in {each.name}", each.share, with_error(each.time_between), "on", power))
        lines = [heading, "", *_aligned(rows), ""]
        low, high = self.time_between_interval
        if self.lasting.value:
            lines.append(
                f"a pulse ends in rattle with {self.lasting} (95 %: {self.lasting_interval[0]:.4g} to "
                f"{self.lasting_interval[1]:.4g}): once in {with_error(self.time_between)} "
                f"(95 %: {in_words(low)} to {in_words(high)})"
            )
        else:
            lines.append(f"no pulse has ended in rattle: less often than once in {in_words(low)} (95 %)")
        lines.append(
            f"expected impact power after a pulse {self.impact_power} W; of episodes that pass, over all time, "
        )
        lines[-1] += f"{self.passing_power} W"
        lines.append(f"quiet is kept for {in_words(self.kept_at_least)} on average, at least (95 %)")
        return "\n".join(lines)


def _aligned(rows: Sequence[Sequence[Any]]) -> list[str]:
    texts = [[str(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*texts, strict=True)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in texts]


@dataclass(frozen=True)
class Pulses:
    """Pulses of a sample, the same for every machine that they hit.

    Attributes
    ----------
    phase : ndarray of float64, shape (n,)
        Forcing periods.
    size : ndarray of float64, shape (n,)
        N m s on the driven shaft; a positive one, along its rotation, parts the teeth.
    pressing : {"bounces", "held"}
        What a pulse does that presses the teeth together.
    """

    phase: np.ndarray
    size: np.ndarray
    pressing: Pressing

    @classmethod
    def drawn(
        cls, size: Any, distribution: Distribution | None, departures: int, seed: int, pressing: Pressing
    ) -> "Pulses":
        """Draw independent pulses.

        Parameters
        ----------
        size, distribution, departures, seed, pressing
            As in `pulses`.

        Returns
        -------
        Pulses

        Raises
        ------
        InvalidJob
            Naming the argument at fault.
        """
        if isinstance(departures, bool) or not isinstance(departures, int | np.integer) or departures < 2:
            raise InvalidJob(f"departures must be a whole number from 2 on, not {departures!r}", ("departures",))
        if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
            raise InvalidJob(f"seed must be a whole number from 0 on, not {seed!r}", ("seed",))
        if pressing not in ("bounces", "held"):
            raise InvalidJob(f"pressing must be bounces or held, not {pressing!r}", ("pressing",))
        rng = np.random.default_rng(seed)
        phase = rng.random(departures)
        return cls(phase, _drawn_sizes(size, distribution, departures, rng), pressing)

    def check_pressing(self, machine: GearPair) -> None:
        """Refuse pulses that are held by teeth whose stiffness says otherwise, as an `InvalidJob`."""
        if self.pressing == "held" and machine.mesh_stiffness is not None:
            raise InvalidJob(
                "pressing=held is for impacts: with a mesh_stiffness the teeth spring back as it says", ("pressing",)
            )

    def departures_of(self, machine: GearPair) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """First departures from +beta of a quiet machine after the pulses, NaN where its teeth do not part.

        Parameters
        ----------
        machine : GearPair

        Returns
        -------
        t, v, delay : ndarray of float64, shape (n,)
            Phase, speed, and time since the pulse, of the model.

        Raises
        ------
        InvalidJob
            If the machine is never quiet or Gamma is 1 or more, or the pulses are held by teeth whose stiffness says
            otherwise.
        OutsideDomain
            If the machine has no quiet solution.
        """
        machine.check_pulses()
        self.check_pressing(machine)
        parting = self.size / machine.scales.impulse
        if self.pressing == "held":
            parting = np.maximum(parting, 0.0)
        after = departures_after_pulses(machine.oscillator, self.phase, parting)
        return after.t, after.v, after.delay


def _drawn_sizes(size: Any, distribution: Distribution | None, count: int, rng: np.random.Generator) -> np.ndarray:
    measured = measured_sizes(size)
    if measured is not None:
        if distribution is not None:
            message = "leave it out: measured sizes are drawn as they are, each as likely as the other"
            raise InvalidJob(f"distribution {distribution}: {message}", ("distribution",))
        return rng.choice(measured, count)
    try:
        value = in_si(size, _IMPULSE)
    except InvalidJob as error:
        raise InvalidJob(f"size: {error}, or the path of a CSV file of sizes", ("size",)) from None
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not math.isfinite(value):
        message = f'size must be a torque pulse in N m s, as in "0.05 N m s", or measured ones, not {size!r}'
        raise InvalidJob(message, ("size",))
    if value == 0.0:
        raise InvalidJob("size must not be 0: such a pulse changes nothing", ("size",))
    if distribution in (None, "normal"):
        if value < 0.0:
            raise InvalidJob(f"size of a normal distribution is its deviation: above 0, not {value:g}", ("size",))
        return rng.normal(0.0, float(value), count)
    if distribution == "exponential":
        return value * rng.exponential(1.0, count)
    if distribution == "fixed":
        return np.full(count, float(value))
    message = f"distribution must be normal, exponential or fixed, not {distribution!r}"
    raise InvalidJob(message, ("distribution",))


def measured_sizes(size: Any) -> np.ndarray | None:
    """Sizes that were measured: those of a list, or of a CSV file. None for a single number.

    Raises
    ------
    InvalidJob
        If they are none, or the file cannot be read.
    """
    if isinstance(size, Path) or (isinstance(size, str) and size.lower().endswith(".csv")):
        return _sizes_in(Path(size))
    if not isinstance(size, Sequence | np.ndarray | pd.Series) or isinstance(size, str) or np.ndim(size) == 0:
        return None
    try:
        measured = np.asarray(size, np.float64)
    except (TypeError, ValueError):
        raise InvalidJob("size: measured sizes are a list of numbers in N m s", ("size",)) from None
    if measured.ndim != 1 or not measured.size or not np.isfinite(measured).all():
        message = (
            f"size: measured sizes are one or more finite numbers in N m s, not an array of shape {measured.shape}"
        )
        raise InvalidJob(message, ("size",))
    return measured


def _sizes_in(path: Path) -> np.ndarray:
    """Sizes in the first column of a CSV file; its first line may be a heading."""
    sizes: list[float] = []
    heading = False
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = csv.reader(file)
            for row in rows:
                text = row[0].strip() if row else ""
                if not text or text.startswith("#"):
                    continue
                try:
                    value = float(text)
                except ValueError:
                    if not sizes and not heading:
                        heading = True
                        continue
                    value = math.nan
                if not math.isfinite(value):
                    message = f"{path}, line {rows.line_num}: a size in N m s is expected, not {text!r}"
                    raise InvalidJob(message, ("size",))
                sizes.append(value)
    except OSError as error:
        raise InvalidJob(f"{path} cannot be read: {error.strerror}", ("size",)) from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InvalidJob(f"{path} is no CSV file: {error}", ("size",)) from error
    if not sizes:
        raise InvalidJob(f"{path}: there are no sizes; each line has one, in N m s", ("size",))
    return np.array(sizes)


def rate_in_si(rate: Any) -> float:
    """How often pulses come, 1/s, of a number or a text with a unit. Raises InvalidJob if it is no rate above 0."""
    try:
        value = in_si(rate, "1/s")
    except InvalidJob as error:
        raise InvalidJob(f"rate: {error}", ("rate",)) from None
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not 0.0 < value < math.inf:
        message = f'rate must be how often pulses come, above 0, as in "3 / hour", not {rate!r}'
        raise InvalidJob(message, ("rate",))
    return float(value)


def _share(chosen: np.ndarray) -> Estimate:
    """Share of those chosen, with the binomial law's error; Laplace's rule where all are alike."""
    _, error, _ = weighted_shares(chosen.astype(np.int64), np.ones(chosen.size), 2)
    return Estimate(float(chosen.mean()), float(error[1]))


def pulses(
    machine: "GearPair | str | Path",
    *,
    rate: "Quantity",
    size: "Quantity | Path | Sequence[float] | np.ndarray",
    distribution: Distribution | None = None,
    pressing: Pressing = "bounces",
    departures: int = 10_000,
    seed: int = 0,
) -> PulseStudy:
    """Hit a quiet machine by torque pulses: how often it rattles then, for how long, and with what power.

    Pulses are momentary and come as a Poisson process, so their phases are uniform. Each meets a machine that is quiet
    again; ``PulseStudy.overlap`` says how often that is not so.

    Parameters
    ----------
    machine : GearPair, str or path
        A machine in its own units, or a TOML file of it.
    rate : float or str
        Mean number of pulses a second, or with a unit, as in ``"3 / hour"``.
    size : float, str, path or array_like
        Torque pulse on the driven shaft, N m s, as in ``"0.05 N m s"``: the scale of ``distribution``. Or sizes that
        were measured: an array, or the path of a CSV file (``.csv``) with one in each line. A positive pulse acts along
        the rotation of the driven shaft and parts the teeth; a negative one presses them together.
    distribution : {"normal", "exponential", "fixed"}, optional
        Of the sizes: normal about 0 with this deviation (the default), exponential with this mean, or all alike.
        Measured sizes are drawn as they are, with replacement.
    pressing : {"bounces", "held"}
        What a pulse does, without a mesh stiffness, that presses the teeth together: it is short against a contact, and
        they bounce with the restitution; or it is long, and they hold.
    departures : int
        How many pulses are followed.
    seed : int
        Of the pulses: the same seed gives the same.

    Returns
    -------
    PulseStudy
        Printed, it is a table.

    Raises
    ------
    InvalidJob
        If an argument is wrong, or inertia torque reaches drag torque (Gamma of 1 or more). It is a ValueError.
    OutsideDomain
        If the machine has no quiet solution (Eq. 3).

    Examples
    --------
    >>> import math
    >>> import rattle
    >>> drag = 0.6 * 0.01 * 300.0**2 / (2.0 * math.pi)
    >>> pair = rattle.GearPair(speed=300.0, inertia=0.01, drag_torque=drag, base_radius=0.1, backlash=0.12,
    ...                        transmission_error=0.01)
    >>> found = rattle.pulses(pair, rate=1 / 1200, size=2.5 * pair.scales.impulse, departures=2000)
    >>> print(found.lasting, [each.name for each in found.rattles])
    0.1300 ± 0.0075 ['P(1,1,0)', 'chaotic']
    """
    pair = GearPair.of(machine)
    every = rate_in_si(rate)
    return follow(pair, every, Pulses.drawn(size, distribution, departures, seed, pressing))


def follow(machine: GearPair, rate: float, drawn: Pulses, pause: Pause = never_stopped) -> PulseStudy:
    """What pulses that are drawn do to a machine.

    Parameters
    ----------
    machine : GearPair
    rate : float
        1/s.
    drawn : Pulses
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    PulseStudy

    Raises
    ------
    InvalidJob, OutsideDomain
        As `pulses`.
    """
    motions, solution, length, impacts, energy = _followed(machine, drawn, pause)
    return _study(machine, rate, drawn, motions, solution, length, impacts, energy)


def _followed(
    machine: GearPair, drawn: Pulses, pause: Pause
) -> tuple[tuple[Attractor, ...], np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Catalogue, and for each pulse its motion, the time until captured, impacts and their energy, of the model."""
    oscillator = machine.oscillator
    t, v, delay = drawn.departures_of(machine)
    parts = np.isfinite(v)
    found = shares_of(oscillator, t[parts], v[parts], pause=pause) if parts.any() else None
    solution = np.zeros(t.size, np.int64)
    length, impacts, energy = np.zeros((3, t.size))
    if found is None:
        return (), solution, length, impacts, energy
    solution[parts] = found.solution
    falls = parts & (solution == 0)
    heard = until_captured(oscillator, t[falls], v[falls], pause=pause)
    # Bounces that are captured from the beginning are quiet at once, whatever came before them.
    length[falls] = np.where(heard.impacts > 0, heard.duration + delay[falls], 0.0)
    impacts[falls], energy[falls] = heard.impacts, heard.impact_energy
    length[solution > 0] = np.inf
    impacts[solution > 0] = energy[solution > 0] = np.nan
    return found.attractors, solution, length, impacts, energy


def _study(
    machine: GearPair, rate: float, drawn: Pulses, motions: tuple[Attractor, ...], solution: np.ndarray,
    length: np.ndarray, impacts: np.ndarray, energy: np.ndarray,
) -> PulseStudy:  # fmt: skip
    """Estimates of all that is said of the pulses."""
    scales, count = machine.scales, solution.size
    lasting, passing = solution > 0, (solution == 0) & (length > 0.0)
    ended = length[passing]
    interval = binomtest(int(lasting.sum()), count).proportion_ci(_CONFIDENCE, "exact")
    shares, errors, _ = weighted_shares(solution, np.ones(count), max(len(motions), 1))
    heard = [loudness(machine.oscillator, each) for each in motions[1:]]
    rattles = tuple(
        _rattle(machine, rate, motion, Estimate(float(shares[place]), float(errors[place])), own)
        for place, (motion, own) in enumerate(zip(motions[1:], heard, strict=True), 1)
        if shares[place] > 0.0
    )
    silent = loudness(machine.oscillator, motions[0]) if motions else None
    power = expected_loudness(shares, [silent, *heard], count) if silent else None
    of_pulses = np.where(lasting, 0.0, energy)
    # Of pulses that do not end in rattle: the next one comes first. Those that do have lost quiet.
    met = np.where(lasting, 0.0, -np.expm1(-rate * scales.time * np.where(lasting, 0.0, length)))
    all_lasting = _share(lasting)
    return PulseStudy(
        machine=machine, rate=rate, departures=count,
        quiet=_share(~lasting & ~passing), passing=_share(passing), lasting=all_lasting,
        lasting_interval=(float(interval.low), float(interval.high)),
        time_between=all_lasting.times(rate).inverse(),
        time_between_interval=(1.0 / (rate * interval.high), _over(1.0, rate * interval.low)),
        passing_turns=mean_of(ended * machine.turns), passing_time=mean_of(ended * scales.time),
        longest_turns=float(ended.max(initial=0.0) * machine.turns),
        passing_energy=mean_of(energy[passing] * scales.energy),
        passing_power=mean_of(of_pulses * scales.energy).times(rate),
        impact_power=Estimate(power.impact_power, power.impact_power_error).times(scales.power)
        if power else Estimate(0.0, 0.0),
        kept_at_least=_kept(rate, scales.time, float(interval.high), mean_of(met)), overlap=float(met.mean()),
        rattles=rattles,
        table=pd.DataFrame(
            {
                "phase": drawn.phase, "size_n_m_s": drawn.size,
                "motion": np.array([each.name for each in motions] or ["permanent contact"])[solution],
                "turns": length * machine.turns, "impacts": impacts, "impact_energy_j": energy * scales.energy,
            }
        ),
    )  # fmt: skip


def _over(one: float, other: float) -> float:
    return one / other if other else math.inf


def _rattle(machine: GearPair, rate: float, motion: Attractor, share: Estimate, own: Any) -> Rattle:
    name = motion.label if motion.kind != AttractorKind.UNDECIDED else "a motion that has not settled"
    power = Estimate(own.impact_power, own.impact_power_error).times(machine.scales.power)
    return Rattle(name, share, share.times(rate).inverse(), power)


def _kept(rate: float, period: float, lasting: float, met: Estimate) -> float:
    """Lower bound of the mean time for which quiet is kept, s.

    A pulse loses quiet if it ends in rattle, and at worst if the next one comes before its episode has passed. Both
    chances are bounded from above at 97.5 %, so their sum is at 95 %.
    """
    chance = lasting + met.value + _ONE_SIDED * met.error
    # The phase of the next pulse is not quite uniform once quiet has returned: its density is at most this.
    density = rate * period / -math.expm1(-rate * period)
    return 1.0 / (rate * density * chance)
