"""Which tolerance: machines of a production, each drawn from all tolerances at once, and which of these is to blame.

A production is a set of machines whose numbers lie within tolerances, independently of one another. Two sets of
scrambled Sobol' points draw them. Each machine meets the same departures (common random numbers), so what differs from
one to the next is the machine alone. From both sets come the distributions over the production. For Sobol's indices,
one column of the first set after the other is replaced by that of the second (Saltelli 2010):

    S_j  = Var(E[y | x_j])/Var(y)         what the j-th number takes away of the variance if it is held
    ST_j = E[Var(y | others)]/Var(y)      what remains of it if all others are held

The number with the largest total index is the guilty one: it is tightened, and the production is drawn again with the
same random numbers. Of what remains `proven` says how fast teeth may part and fall quiet, in every machine within.

Saltelli et al., Computer Physics Communications 181 (2010) 259-270. docs/theory/tolerances.md.
"""

import math
import os
import re
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from scipy.special import ndtr, ndtri
from scipy.stats import qmc, sobol_indices

from rattle_kernels import OutsideDomain, expected_loudness, loudness, shares_of
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_machine.departures import sample_of
from rattle_machine.estimates import Estimate, for_json, mean_of
from rattle_machine.numbers import number_of, unit_of, with_number
from rattle_machine.proven import Mapper, Proven, can_prove, prove_quiet
from rattle_machine.pulses import Distribution, Pressing, measured_sizes, rate_in_si
from worker.errors import InvalidJob
from worker.gear_pair import GearPair, in_si, number_and_unit

if TYPE_CHECKING:
    from collections.abc import Callable

    from worker.gear_pair import Quantity

    # A text, or limits.
    Tolerance = str | tuple[Quantity, Quantity] | tuple[Quantity, Quantity, str]

YEAR = 31_557_600.0
"""Seconds of a year."""
QUIET, POWER, EPISODES = "quiet_share", "impact_power_w", "episodes_a_year"
_PLUS_MINUS = re.compile(
    r"\s*(?P<middle>\S+)\s*(?:\+-|\u00b1|\+/-)\s*(?P<half>\S+)\s*(?P<unit>.*?)\s*(?P<law>,\s*normal)?\s*"
)
# Of a normal law the tolerance is three deviations, and parts beyond it are sorted out.
_DEVIATIONS = 3.0
_NORMAL = "normal"
_CONFIDENCE = 0.95
_RESAMPLES = 400
_LEAST = 16
_A_BLOCK = 32


@dataclass(frozen=True)
class Range:
    """Tolerance of a number of a machine.

    Attributes
    ----------
    name, unit : str
        The number, and its unit in SI.
    low, high : float
    normal : bool
        Whether parts are normally distributed about the middle, with limits at three deviations; else each value is as
        likely as the other.
    """

    name: str
    unit: str
    low: float
    high: float
    normal: bool = False

    def at(self, part: np.ndarray) -> np.ndarray:
        """Values at parts between 0 and 1 of the distribution."""
        middle, half = 0.5 * (self.low + self.high), 0.5 * (self.high - self.low)
        if not self.normal:
            return middle + half * (2.0 * part - 1.0)
        outside = float(ndtr(-_DEVIATIONS))
        return np.asarray(middle + half / _DEVIATIONS * ndtri(outside + (1.0 - 2.0 * outside) * part))

    def tightened(self, factor: float) -> "Range":
        """The same about the same middle, so many times as wide."""
        middle, half = 0.5 * (self.low + self.high), 0.5 * factor * (self.high - self.low)
        return replace(self, low=middle - half, high=middle + half)

    @property
    def limits(self) -> list[float | str]:
        """As JSON: both limits, and ``"normal"`` behind them if it is."""
        return [self.low, self.high, *([_NORMAL] if self.normal else [])]

    def __str__(self) -> str:
        """As it is written, in SI."""
        middle, half = 0.5 * (self.low + self.high), 0.5 * (self.high - self.low)
        return f"{middle:.6g} +- {half:.3g} {self.unit}".rstrip() + (", normal" if self.normal else "")


@dataclass(frozen=True)
class Production:
    """What machines of a production do.

    Attributes
    ----------
    mean : Estimate
        Of the quiet share.
    quantiles : dict of float to float
        Of the quiet share: the shares that 5, 50 and 95 % of all machines stay below.
    bad : Estimate
        Part of all machines whose quiet share is below the limit.
    power : Estimate
        Mean of the expected impact power, W; of the machines for which it is known.
    """

    mean: Estimate
    quantiles: dict[float, float]
    bad: Estimate
    power: Estimate


@dataclass(frozen=True)
class ToleranceStudy:
    """A production within its tolerances, what its machines do, and which tolerance is to blame.

    Attributes
    ----------
    machine : GearPair
        The nominal one.
    ranges : tuple of Range
    departures : int
        That each machine meets.
    limit : float
        Quiet share below which a machine is bad.
    production : Production
    indices : pandas.DataFrame
        A row for each number: ``first``, ``total`` and the ends of their 95 % intervals, ``first_low`` and so on. They
        are of the quiet share, and NaN where all machines do the same.
    guilty : str or None
        Number with the largest total index; None where all machines do the same.
    tightened : tuple of (Range, Production), optional
        The guilty one tightened, and the production then.
    table : pandas.DataFrame
        A row for each machine of the production: its numbers in SI, ``gamma``, ``quiet_share``, ``impact_power_w``, and
        ``episodes_a_year`` if a rate is given.
    proven : Proven, optional
        How fast teeth may part and fall quiet in every machine: of the tightened production if there is one. None if it
        was not asked for.
    """

    machine: GearPair
    ranges: tuple[Range, ...]
    departures: int
    limit: float
    production: Production
    indices: pd.DataFrame
    guilty: str | None
    tightened: tuple[Range, Production] | None
    table: pd.DataFrame = field(repr=False, compare=False)
    proven: Proven | None = None

    def to_dict(self) -> dict[str, Any]:
        """All but the table, for JSON: a number that is not finite is None.

        Returns
        -------
        dict
        """
        told = {
            "machine": self.machine.model_dump(exclude_none=True), "departures": self.departures,
            "machines": len(self.table), "limit": self.limit, "ranges": {each.name: str(each) for each in self.ranges},
            "production": _production_as_dict(self.production),
            "indices": self.indices.set_index("number").to_dict(orient="index"), "guilty": self.guilty,
            "tightened": self.tightened
            and {"range": str(self.tightened[0]), "production": _production_as_dict(self.tightened[1])},
            "proven": self.proven and vars(self.proven),
        }  # fmt: skip
        return for_json(told)

    def __str__(self) -> str:
        """Tables for people."""
        lines = [f"{len(self.table):,} machines with {self.departures:,} departures each, within"]
        lines += [f"  {each.name} = {each}" for each in self.ranges]
        lines += ["", *_said_of(self.production, self.limit), ""]
        lines += self._blame()
        if self.tightened is not None:
            tight, then = self.tightened
            lines += ["", f"with {tight.name} = {tight}", *_said_of(then, self.limit)]
        if self.proven is not None:
            lines += ["", str(self.proven)]
        return "\n".join(lines)

    def _blame(self) -> list[str]:
        if self.guilty is None:
            return ["all machines do the same: no tolerance is to blame"]
        return [f"{'number':<32}{'alone':>8}  {'with all others':>16}"] + [
            f"{row.number:<32}{row.first:>8.2f}  {row.total:>6.2f} ({row.total_low:.2f} to {row.total_high:.2f})"
            for row in self.indices.sort_values("total", ascending=False).itertuples()
        ]


def tolerances(
    machine: "GearPair | str | Path",
    numbers: "Mapping[str, Tolerance]",
    *,
    machines: int = 1024,
    departures: int = 1000,
    size: "Quantity | Path | Sequence[float] | np.ndarray | None" = None,
    distribution: Distribution | None = None,
    pressing: Pressing = "bounces",
    rate: "Quantity | None" = None,
    fastest: float | None = None,
    limit: float = 0.99,
    tighten: float = 0.5,
    prove: bool = False,
    seed: int = 0,
    workers: int | None = None,
) -> ToleranceStudy:
    """Draw machines within tolerances: how quiet are they, and which tolerance is to blame for those that are not.

    Parameters
    ----------
    machine : GearPair, str or path
        The nominal machine, or a TOML file of it.
    numbers : mapping
        Tolerances of its numbers, as ``"35 +- 10 um"``, each value of which is as likely as the other;
        ``"35 +- 10 um, normal"``, normal with three deviations to the limits; a pair of limits, with ``"normal"``
        behind it or not; or ``"any"`` phase.
        Numbers are those of the machine (``speed``, ``backlash``, ...), and of its transmission error
        ``transmission_error.2.amplitude`` and ``transmission_error.2.phase``.
    machines : int
        How many are computed, at most: two sets of a power of two, and one more for each of several numbers.
    departures : int
        That each machine meets.
    size, distribution, pressing
        Departures are those after torque pulses, as ``rattle.pulses`` takes them. Without a size they are uniform over
        a window of phases and speeds.
    rate : float or str, optional
        How often pulses come, as in ``"3 / hour"``: for episodes a year. It needs a size.
    fastest : float, optional
        Upper end of the window, m/s. By default it follows the nominal machine.
    limit : float
        Quiet share below which a machine is bad.
    tighten : float
        Part of its width to which the guilty tolerance is tightened; 1 leaves that out.
    prove : bool
        Whether to prove how fast teeth may part and fall quiet in every machine of the tightened production, or of the
        whole one where none is tightened. It takes minutes, and the package ``rattle_proof``.
    seed : int
        Of all random numbers.
    workers : int, optional
        Threads; by default one for each core.

    Returns
    -------
    ToleranceStudy
        Printed, it is a table.

    Raises
    ------
    InvalidJob
        If an argument is wrong, or a machine cannot have a value. It is a ValueError.

    Examples
    --------
    >>> import rattle
    >>> pair = rattle.GearPair(speed=305.0, inertia=0.0173, drag_torque=150.0, base_radius=0.0571, backlash=0.06,
    ...                        transmission_error=5e-3, restitution=0.9)
    >>> found = rattle.tolerances(pair, {"transmission_error.1.amplitude": "5 +- 1 mm", "restitution": (0.8, 1.0)},
    ...                           machines=64, departures=64)
    >>> len(found.table), [each.name for each in found.ranges]
    (32, ['transmission_error.1.amplitude', 'restitution'])
    """
    asked = Question.of(
        GearPair.of(machine), numbers, machines=machines, departures=departures, size=size, distribution=distribution,
        pressing=pressing, rate=rate, fastest=fastest, limit=limit, tighten=tighten, seed=seed,
    )  # fmt: skip
    if prove:
        demand_proof()
    with ThreadPoolExecutor(workers or len(os.sched_getaffinity(0))) as threads:

        def all_do(ranges: tuple[Range, ...], places: np.ndarray) -> np.ndarray:
            return np.concatenate(list(threads.map(lambda block: asked.machines_do(ranges, block), blocks_of(places))))

        found = all_do(asked.ranges, asked.places())
        narrow = asked.narrowed(found)
        then = None if narrow is None else all_do(narrow, asked.places_of_production())
        proven = asked.prove(narrow, mapper=threads.map) if prove else None
    return asked.study(found, then, proven)


def demand_proof() -> None:
    """Refuse to prove without the package that does."""
    if not can_prove():
        raise InvalidJob("prove needs the package rattle_proof, which is not installed", ("prove",))


def blocks_of(places: np.ndarray) -> list[np.ndarray]:
    """Machines in blocks, each of which is computed at one place."""
    return [places[begin : begin + _A_BLOCK] for begin in range(0, len(places), _A_BLOCK)]


@dataclass(frozen=True, kw_only=True)
class Question:
    """What is asked of a production, checked: which machines there are, and what is made of what they do.

    What each machine does depends on that machine alone, so they may be computed anywhere, in any order.

    Parameters
    ----------
    machine : GearPair
    ranges : tuple of Range
    count : int
        Machines in each of the two sets, a power of two.
    departures, size, distribution, pressing, rate, fastest, limit, tighten, seed
        As `tolerances` takes them; the rate in 1/s.
    """

    machine: GearPair
    ranges: tuple[Range, ...]
    count: int
    departures: int
    size: Any
    distribution: Distribution | None
    pressing: Pressing
    rate: float | None
    fastest: float | None
    limit: float
    tighten: float
    seed: int

    @classmethod
    def of(
        cls, machine: GearPair, numbers: Any, *, machines: Any, departures: int, size: Any,
        distribution: Distribution | None, pressing: Pressing, rate: Any, limit: float, seed: int,
        fastest: float | None = None, tighten: float = 0.5,
    ) -> "Question":  # fmt: skip
        """Question of the arguments of `tolerances`, with its errors."""
        ranges = tuple(_range_of(machine, name, given) for name, given in _checked(numbers).items())
        count = _size(machines, len(ranges))
        for name, value in (("limit", limit), ("tighten", tighten)):
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value <= 1.0:
                raise InvalidJob(f"{name} must be above 0 and at most 1, not {value!r}", (name,))
        if rate is not None and size is None:
            raise InvalidJob("rate is how often pulses come: give their size as well", ("rate",))
        every, measured = None if rate is None else rate_in_si(rate), measured_sizes(size)
        asked = cls(
            machine=machine, ranges=ranges, count=count, departures=departures,
            size=size if measured is None else measured, distribution=distribution, pressing=pressing, rate=every,
            fastest=fastest, limit=limit, tighten=tighten, seed=seed,
        )  # fmt: skip
        asked._sample()
        return asked

    def _sample(self) -> "Callable[[GearPair], tuple[np.ndarray, np.ndarray]]":
        return sample_of(
            self.machine, size=self.size, distribution=self.distribution, pressing=self.pressing, fastest=self.fastest,
            departures=self.departures, seed=self.seed,
        )  # fmt: skip

    def places(self) -> np.ndarray:
        """Where each machine lies within each tolerance, from 0 to 1: a row for each machine, the production first.

        Behind the two sets that are the production come those in which one column is mixed, for the indices.
        """
        first, second = self._sets()
        columns = range(len(self.ranges)) if len(self.ranges) > 1 else ()
        return np.concatenate([first, second, *(_with_column(first, second, column) for column in columns)])

    def places_of_production(self) -> np.ndarray:
        """Those of the production alone."""
        return np.concatenate(self._sets())

    def _sets(self) -> tuple[np.ndarray, np.ndarray]:
        points = qmc.Sobol(2 * len(self.ranges), rng=self.seed).random_base2(self.count.bit_length() - 1)
        first, second = np.hsplit(points, 2)
        return first, second

    def machines_do(self, ranges: tuple[Range, ...], places: np.ndarray, pause: Pause = never_stopped) -> np.ndarray:
        """Quiet share, expected impact power in W, and Gamma of machines, in columns.

        Parameters
        ----------
        ranges : tuple of Range
            The tolerances, or those of which one is narrower.
        places : ndarray, shape (n, number of tolerances)
        pause : callable
            Called several times a second.

        Returns
        -------
        ndarray, shape (n, 3)
        """
        sample = self._sample()
        values = np.column_stack([each.at(part) for each, part in zip(ranges, places.T, strict=True)])
        return np.array([_machine_does(self.machine, ranges, row, sample, pause) for row in values])

    def narrowed(self, found: np.ndarray) -> tuple[Range, ...] | None:
        """Tolerances of which the guilty one is tightened; None if none is to blame, or none is to be tightened.

        Parameters
        ----------
        found : ndarray
            What the machines at `places` do.
        """
        guilty = _guilty(self._indices_of(found, _totals))
        if guilty is None or self.tighten >= 1.0:
            return None
        return tuple(each.tightened(self.tighten) if each.name == guilty else each for each in self.ranges)

    def prove(self, narrow: tuple[Range, ...] | None, *, mapper: Mapper = map, pause: Pause = never_stopped) -> Proven:
        """Prove how fast teeth may part and fall quiet in every machine of the production that is tightened, or is not.

        Parameters
        ----------
        narrow : tuple of Range, optional
            The tolerances `narrowed`.
        mapper, pause
            As `prove_quiet` takes them.

        Returns
        -------
        Proven
        """
        within = {each.name: (each.low, each.high) for each in narrow or self.ranges}
        return prove_quiet(
            self.machine, within, fastest=self.fastest, tightened=narrow is not None, mapper=mapper, pause=pause
        )

    def _indices_of(self, found: np.ndarray, of: "Callable[..., pd.DataFrame]") -> pd.DataFrame:
        quiet = found[:, 0]
        mixed = quiet[2 * self.count :].reshape(-1, self.count)
        return of(self.ranges, quiet[: 2 * self.count], mixed, self.seed)

    def study(self, found: np.ndarray, then: np.ndarray | None, proven: Proven | None = None) -> ToleranceStudy:
        """What is said of the production.

        Parameters
        ----------
        found : ndarray
            What the machines at `places` do.
        then : ndarray, optional
            What those at `places_of_production` do with the tolerances `narrowed`.
        proven : Proven, optional
            What is proven of these, or of all.

        Returns
        -------
        ToleranceStudy
        """
        both, narrow = found[: 2 * self.count], self.narrowed(found)
        indices = self._indices_of(found, _indices)
        guilty, tightened = _guilty(indices), None
        if narrow is not None and then is not None:
            (tight,) = (each for each in narrow if each.name == guilty)
            tightened = tight, _production(then, self.limit)
        parts = self.places_of_production().T
        table = pd.DataFrame({each.name: each.at(part) for each, part in zip(self.ranges, parts, strict=True)})
        table = table.assign(**{QUIET: both[:, 0], POWER: both[:, 1], "gamma": both[:, 2]})
        if self.rate is not None:
            table[EPISODES] = YEAR * self.rate * (1.0 - both[:, 0])
        return ToleranceStudy(
            self.machine, self.ranges, self.departures, self.limit, _production(both, self.limit), indices, guilty,
            tightened, table, proven,
        )  # fmt: skip


def _checked(numbers: Any) -> Mapping[str, Any]:
    if not isinstance(numbers, Mapping) or not numbers:
        message = 'numbers are tolerances by name, as in {"backlash": "35 +- 10 um"}, one or more'
        raise InvalidJob(message, ("numbers",))
    return numbers


def _size(machines: Any, numbers: int) -> int:
    """Machines in each set: the largest power of two for which all sets together are at most so many."""
    sets = numbers + 2 if numbers > 1 else 2
    least = _LEAST * sets
    if isinstance(machines, bool) or not isinstance(machines, int) or machines < least:
        raise InvalidJob(f"machines must be at least {least} for {numbers} tolerances, not {machines!r}", ("machines",))
    return 1 << ((machines // sets).bit_length() - 1)


def _range_of(pair: GearPair, name: str, given: Any) -> Range:
    unit = unit_of(name)
    if number_of(pair, name) is None:
        raise InvalidJob(f"the machine has no {name}, which could have a tolerance", ("numbers", name))
    if given == "any" and name.endswith(".phase"):
        return Range(name, unit, 0.0, 1.0)
    right = 'write it as "35 +- 10 um", "35 +- 10 um, normal", or a pair of limits'
    normal = False
    if isinstance(given, str):
        parts = _PLUS_MINUS.fullmatch(given)
        if parts is None:
            raise InvalidJob(f"{name}: {given!r} is no tolerance: {right}", ("numbers", name))
        normal = parts["law"] is not None
        middle, half = (_value(name, unit, f"{parts[each]} {parts['unit']}".strip()) for each in ("middle", "half"))
        low, high = middle - half, middle + half
    elif isinstance(given, tuple | list) and (len(given) == 2 or (len(given) == 3 and given[2] == _NORMAL)):
        low, high = (_value(name, unit, each) for each in given[:2])
        normal = len(given) == 3
    else:
        raise InvalidJob(f"{name}: {given!r} is no tolerance: {right}", ("numbers", name))
    if not low < high:
        raise InvalidJob(f"{name}: the limits {low:g} and {high:g} enclose nothing: {right}", ("numbers", name))
    for limit in (low, high):  # said before anything is computed
        try:
            with_number(pair, name, limit)
        except InvalidJob as error:
            raise InvalidJob(f"the machine cannot have {name} = {limit:g}: {error}", ("numbers", name)) from None
    return Range(name, unit, low, high, normal)


def _value(name: str, unit: str, given: Any) -> float:
    """A number in SI units; what has no unit in a text is one in SI."""
    try:
        if isinstance(given, str):
            number, written = number_and_unit(given)
            given = float(in_si(given, "turn" if unit == "periods" else unit)) if written and unit else number
            if written and not unit:
                raise InvalidJob(f"{name} is a pure number: it has no unit")
    except InvalidJob as error:
        raise InvalidJob(f"{name}: {error}", ("numbers", name)) from None
    if isinstance(given, bool) or not isinstance(given, int | float) or not math.isfinite(given):
        raise InvalidJob(f"{name}: {given!r} is no number", ("numbers", name))
    return float(given)


def _machine_does(
    pair: GearPair, ranges: Sequence[Range], values: np.ndarray,
    sample: "Callable[[GearPair], tuple[np.ndarray, np.ndarray]]", pause: Pause,
) -> tuple[float, float, float]:  # fmt: skip
    """Quiet share, expected impact power in W, NaN where it is not known, and Gamma of one machine."""
    pause()
    machine = pair
    for each, value in zip(ranges, values.tolist(), strict=True):
        machine = with_number(machine, each.name, value)
    try:
        t, v = sample(machine)
        parts = np.isfinite(v)
        if not parts.any():
            return 1.0, 0.0, machine.gamma
        found = shares_of(machine.oscillator, t[parts], v[parts], pause=pause)
    except (InvalidJob, OutsideDomain):  # not followed, or with no quiet solution that pulses could hit
        return 0.0, math.nan, machine.gamma
    counts = np.bincount(found.solution, minlength=len(found.attractors)) / t.size
    counts[0] += 1.0 - parts.mean()
    own = [loudness(machine.oscillator, each) for each in found.attractors]
    power = expected_loudness(counts, own, t.size).impact_power * machine.scales.power
    return float(counts[0]), float(power), machine.gamma


def _with_column(first: np.ndarray, second: np.ndarray, column: int) -> np.ndarray:
    mixed = first.copy()
    mixed[:, column] = second[:, column]
    return mixed


_INDICES = ("first", "first_low", "first_high", "total", "total_low", "total_high")


def _totals(ranges: Sequence[Range], of_both: np.ndarray, mixed: np.ndarray, seed: int) -> pd.DataFrame:
    """Sobol's indices of the quiet share, without their intervals, which take a second."""
    found = _without_sampling(ranges, of_both)
    if found is not None:
        return found
    first, total = _sobol(np.arange(of_both.size // 2), of_both, mixed, seed)
    return pd.DataFrame({"number": [each.name for each in ranges], "first": first, "total": total})


def _without_sampling(ranges: Sequence[Range], of_both: np.ndarray) -> pd.DataFrame | None:
    """Indices where nothing needs to be estimated; None elsewhere."""
    names = [each.name for each in ranges]
    if np.ptp(of_both) == 0.0:
        return pd.DataFrame({"number": names} | dict.fromkeys(_INDICES, math.nan))
    if len(ranges) == 1:  # all of it
        return pd.DataFrame({"number": names} | dict.fromkeys(_INDICES, 1.0))
    return None


def _sobol(chosen: np.ndarray, of_both: np.ndarray, mixed: np.ndarray, seed: int) -> np.ndarray:
    """First and total indices from chosen machines of the sets."""
    a, b = np.split(of_both, 2)
    values: Any = {"f_A": a[None, chosen], "f_B": b[None, chosen], "f_AB": mixed[:, None, chosen]}
    with np.errstate(invalid="ignore", divide="ignore"):  # 0/0 of a resample whose machines all do the same
        found = sobol_indices(func=values, n=a.size, rng=seed)
    return np.array([np.ravel(found.first_order), np.ravel(found.total_order)])


def _indices(ranges: Sequence[Range], of_both: np.ndarray, mixed: np.ndarray, seed: int) -> pd.DataFrame:
    """Sobol's indices of the quiet share, with bootstrapped intervals."""
    known = _without_sampling(ranges, of_both)
    if known is not None:
        return known
    size, rng = of_both.size // 2, np.random.default_rng(seed)
    resampled = np.array([_sobol(rng.integers(size, size=size), of_both, mixed, seed) for _ in range(_RESAMPLES)])
    tail = 0.5 * (1.0 - _CONFIDENCE)
    ends = np.nanquantile(resampled, (tail, 1.0 - tail), axis=0)
    found = _sobol(np.arange(size), of_both, mixed, seed)
    numbers = [part for index in (0, 1) for part in (found[index], ends[0, index], ends[1, index])]
    return pd.DataFrame({"number": [each.name for each in ranges]} | dict(zip(_INDICES, numbers, strict=True)))


def _guilty(indices: pd.DataFrame) -> str | None:
    """Number with the largest total index; None where all machines do the same."""
    return None if indices["total"].isna().all() else str(indices["number"][indices["total"].idxmax()])


def _production(of_both: np.ndarray, limit: float) -> Production:
    quiet, power = of_both[:, 0], of_both[:, 1]
    levels = (0.05, 0.5, 0.95)
    quantiles = dict(zip(levels, np.quantile(quiet, levels).tolist(), strict=True))
    known = power[np.isfinite(power)]
    return Production(mean_of(quiet), quantiles, mean_of((quiet < limit).astype(np.float64)), mean_of(known))


def _production_as_dict(production: Production) -> dict[str, Any]:
    return {
        name: {"value": value.value, "error": value.error} if isinstance(value, Estimate) else value
        for name, value in vars(production).items()
    }


def _said_of(production: Production, limit: float) -> list[str]:
    low, middle, high = (100.0 * each for each in production.quantiles.values())
    return [
        f"quiet after {production.mean.times(100.0)} % of departures on average; 5, 50 and 95 % of the machines after "
        f"less than {low:.4g}, {middle:.4g} and {high:.4g} %",
        f"{production.bad.times(100.0)} % of the machines are quiet after less than {100.0 * limit:g} % of departures",
        f"expected impact power {production.power} W",
    ]
