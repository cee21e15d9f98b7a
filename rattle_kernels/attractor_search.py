"""The catalogue of motions that landing points end in: permanent contact, periodic orbits, chaos.

A seed (a landing point) is followed by P itself until it is clear where it ends:

1. captured by ever lower bounces: permanent contact;
2. it lands on an attractor already in the catalogue (`neighbourhoods`): nothing new;
3. it comes back close to itself after p impacts: the orbit there is polished by Newton and its multipliers decide.
   Slow convergence is not chaos;
4. else its largest Lyapunov exponent over a long run is positive by several standard errors: chaos, and where its
   points are seen to leave it (`chaotic_leak`) a transient. One with a mean life of less than 16,000 impacts is no part
   of the catalogue, what is on it is followed to its end; one that lasts longer is listed as what it is. Below a
   damping of 0.02 chaos that is not seen to end is left undecided;
5. else it is undecided, and says so.

Seeds are taken in ascending order, so the catalogue depends on the set of seeds alone.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from rattle_kernels.attractor import PERMANENT_CONTACT_ATTRACTOR, UNDECIDED_ATTRACTOR, Attractor, AttractorKind
from rattle_kernels.chaotic_leak import chaotic_leak
from rattle_kernels.impact_lanes import run_lanes
from rattle_kernels.iterations import WEAK_DAMPING
from rattle_kernels.lyapunov import lyapunov_exponent
from rattle_kernels.neighbourhoods import hit_the_same_boxes, locate, neighbourhoods
from rattle_kernels.oscillator import Oscillator, check_domain
from rattle_kernels.outcome import Outcome
from rattle_kernels.settled_orbit import attractor_of, settled_orbit

_SETTLING = 4096
# A quarter of a second.
_APPLICATIONS_AT_A_TIME = 1 << 24
_LYAPUNOV_IMPACTS = 32_768
# Transients through a chaotic saddle are given this many rounds of settling before a motion is left undecided.
_PATIENCE = 4
# After so many seeds in a row that led to nothing new, the rest is left to be named, and counted where it cannot be.
_FRUITLESS_SEEDS = 8
# Impacts: an eighth of what a landing point is followed for before it is called a stranger.
_LONG_LIFE = 16_000.0


def _motion_of(oscillator: Oscillator, t: float, v: float) -> Attractor:
    """Motion that one trajectory ends in, whatever the catalogue holds."""
    orbit = settled_orbit(oscillator, t, v)
    for _ in range(_PATIENCE):
        if orbit is not None:
            break
        run = lyapunov_exponent(oscillator, t, v, _LYAPUNOV_IMPACTS)
        if run.captured:
            return PERMANENT_CONTACT_ATTRACTOR
        t, v = float(run.t[-1]), float(run.v[-1])
        # A transient that settled on the way has a positive mean exponent too: the end of the run must still be
        # irregular.
        orbit = settled_orbit(oscillator, t, v)
        if orbit is None and run.chaotic:
            return Attractor(AttractorKind.CHAOTIC, 0, 0, 0, run.exponent, run.error, run.t, run.v)
    return UNDECIDED_ATTRACTOR if orbit is None else attractor_of(orbit)


def _is_known(oscillator: Oscillator, motion: Attractor, catalogue: Sequence[Attractor]) -> bool:
    """Whether a motion is in the catalogue: by itself where it has no points, else by where its last point arrives."""
    if not motion.time.size:
        return any(listed.kind == motion.kind for listed in catalogue)
    return bool(
        locate(oscillator, neighbourhoods(oscillator, catalogue), motion.time[-1:], motion.velocity[-1:])[0] >= 0
    )


def _overlapping(oscillator: Oscillator, motion: Attractor, catalogue: Sequence[Attractor]) -> int | None:
    """Which chaotic attractor of the catalogue a chaotic motion is a part of, or has as its part; None where none is.

    One of the two may be a long transient through the other's surroundings. Listed apart, they would share their boxes,
    which then would tell nothing, so that every seed would find one attractor more.
    """
    if not motion.wanders:
        return None
    chaotic = [i for i, listed in enumerate(catalogue) if listed.wanders]
    return next((i for i in chaotic if hit_the_same_boxes(oscillator, motion, catalogue[i])), None)


def _news(oscillator: Oscillator, motion: Attractor, catalogue: Sequence[Attractor]) -> list[Attractor]:
    """What a motion adds to a catalogue: itself; of a transient what it leads to, and itself if it is long."""
    if motion.kind != AttractorKind.CHAOTIC:
        return [] if _is_known(oscillator, motion, catalogue) else [motion]
    leak = chaotic_leak(oscillator, motion, catalogue)
    if leak.mean_life < _LONG_LIFE:
        return list(leak.orbits)
    if math.isfinite(leak.mean_life):
        return [*leak.orbits, motion._replace(kind=AttractorKind.CHAOTIC_TRANSIENT)]
    # There low bounces may sink for longer than anything is followed, and look chaotic.
    if oscillator.damping <= WEAK_DAMPING:
        return [] if _is_known(oscillator, UNDECIDED_ATTRACTOR, catalogue) else [UNDECIDED_ATTRACTOR]
    return [motion]


def _united(known: Attractor, motion: Attractor) -> Attractor:
    """One attractor with half of the points of either; its exponent is that of the run that settled for longer."""
    time = np.concatenate([known.time[::2], motion.time[::2]])
    velocity = np.concatenate([known.velocity[::2], motion.velocity[::2]])
    return motion._replace(kind=known.kind, time=time, velocity=velocity)


def _settle(
    oscillator: Oscillator, t: np.ndarray, v: np.ndarray, applications: int, pause: Callable[[], None]
) -> tuple[np.ndarray, np.ndarray]:
    """Where points are after many applications, those captured left out."""
    times, speeds = [t[:0]], [v[:0]]
    at_a_time = max(64, _APPLICATIONS_AT_A_TIME // applications)
    for start in range(0, t.size, at_a_time):
        pause()
        part = slice(start, start + at_a_time)
        settled, _ = run_lanes(oscillator, t[part], v[part], applications, shortcuts=True)
        left = settled.outcome == Outcome.RETURNED
        times.append(settled.t[left])
        speeds.append(settled.v[left])
    return np.concatenate(times), np.concatenate(speeds)


def _canonical(found: Sequence[Attractor]) -> tuple[Attractor, ...]:
    def key(attractor: Attractor) -> tuple[float, ...]:
        kinds = AttractorKind.PERMANENT_CONTACT, AttractorKind.PERIODIC, AttractorKind.CHAOTIC
        place = {kind: number for number, kind in enumerate((*kinds, AttractorKind.CHAOTIC_TRANSIENT))}
        contacts = attractor.upper_contacts, attractor.forcing_periods, attractor.lower_contacts
        lowest = (round(float(attractor.velocity.min()), 9), float(attractor.time[0])) if attractor.time.size else ()
        return (place.get(attractor.kind, len(place)), *contacts, *lowest)

    return tuple(sorted(found, key=key))


def find_attractors(
    oscillator: Oscillator,
    t: np.typing.ArrayLike,
    v: np.typing.ArrayLike,
    known: Sequence[Attractor] = (),
    pause: Callable[[], None] = lambda: None,
) -> tuple[Attractor, ...]:
    """Catalogue of the motions that seeds end in.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model.
    t, v : array_like, shape (n,)
        Seeds: phases and speeds of departures from +beta, such as one landing point of every part of the plane.
    known : sequence of Attractor
        A catalogue to extend.
    pause : callable
        Called several times a second; what it raises ends the search.

    Returns
    -------
    tuple of Attractor
        Permanent contact first, always; then periodic orbits by (n+, m, n-) and lowest speed, then chaotic attractors,
        then chaotic transients; UNDECIDED last and only where some seed is.

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain of the map.
    """
    checked = check_domain(oscillator)
    catalogue = list(known) or [PERMANENT_CONTACT_ATTRACTOR]
    seeds = np.unique(np.column_stack([np.asarray(t, np.float64), np.asarray(v, np.float64)]), axis=0)
    t_left, v_left = _settle(checked, seeds[:, 0].copy(), seeds[:, 1].copy(), _SETTLING, pause)
    fruitless = 0
    while t_left.size and fruitless < _FRUITLESS_SEEDS:
        pause()
        places = locate(checked, neighbourhoods(checked, catalogue), t_left, v_left)
        t_left, v_left = t_left[places < 0], v_left[places < 0]
        if not t_left.size:
            break
        motion = _motion_of(checked, float(t_left[0]), float(v_left[0]))
        t_left, v_left = t_left[1:], v_left[1:]
        same = _overlapping(checked, motion, catalogue)
        if same is not None:
            catalogue[same] = _united(catalogue[same], motion)
            news: list[Attractor] = []
        else:
            news = _news(checked, motion, catalogue)
        catalogue += news
        fruitless = 0 if news else fruitless + 1
        if not news:
            # A long transient: the others are likely on one too, and lanes follow them a hundred times faster than one
            # by one.
            t_left, v_left = _settle(checked, t_left, v_left, 16 * _SETTLING, pause)
    return _canonical(catalogue)
