"""The catalogue of motions that landing points end in: permanent contact, periodic orbits, chaos.

P is applied to a seed (a landing point) until its final motion is clear:

1. Ever lower bounces capture it: permanent contact.
2. It arrives at an attractor already in the catalogue (`neighbourhoods`): nothing new.
3. It returns close to itself after p impacts: Newton's method refines the orbit there, and its multipliers decide. Slow
   convergence is not chaos.
4. Otherwise an ensemble starts beside it (`chaotic_transient`). If most of it settles, the seed was on a short
   transient and ends as the ensemble does. If not, and the largest Lyapunov exponent is positive by several standard
   errors, this is chaos: an attractor if no trajectory leaves it, else a transient. The ensemble of a transient is
   followed to its end, and the motions there are listed, too. If none leaves there, over half a million impacts, this
   is an attractor after all: the others had begun beside it.
5. Otherwise it is listed as undecided.

A few seeds from all over the plane come first, as many as lanes follow at a time. Most of the others have arrived at
the motions of those already, and need not be followed until they settle. Within each part seeds are processed in
ascending order, so the catalogue depends only on the set of seeds.
"""

import math
from collections.abc import Sequence

import numpy as np

from rattle_kernels.attractors.attractor import (
    ENSEMBLE,
    PERMANENT_CONTACT_ATTRACTOR,
    UNDECIDED_ATTRACTOR,
    Attractor,
    AttractorKind,
)
from rattle_kernels.attractors.chaotic_boxes import hit_the_same_boxes
from rattle_kernels.attractors.chaotic_transient import follow_ensemble, follow_to_ends, note_orbits
from rattle_kernels.attractors.neighbourhoods import locate, neighbourhoods
from rattle_kernels.attractors.settled_orbit import attractor_of, settled_orbit
from rattle_kernels.lanes.lane_fields import LANES
from rattle_kernels.lanes.run import run_lanes
from rattle_kernels.model.departures import check_departures
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import Outcome
from rattle_kernels.numerics.pausing import Pause, never_stopped

_SETTLING = 4096
# These take a quarter of a second.
_APPLICATIONS_AT_A_TIME = 1 << 24
# Ensembles of 16,384 impacts for a transient through a chaotic saddle, before the motion is listed as undecided.
_PATIENCE = 4
# The search ends after this many seeds in a row without a new motion. The rest are named later or remain unassigned.
_FRUITLESS_SEEDS = 8


def _motions_of(oscillator: Oscillator, t: float, v: float, pause: Pause) -> list[Attractor]:
    """Final motion of one trajectory, whatever the catalogue holds; for a transient, the motions after it, and it last.

    The ends of a transient are places in this list.
    """
    for _ in range(_PATIENCE):
        orbit = settled_orbit(oscillator, t, v)
        if orbit is not None:
            return [attractor_of(orbit)]
        ensemble = follow_ensemble(oscillator, t, v, pause)
        after, members = [PERMANENT_CONTACT_ATTRACTOR], [ensemble.captured]
        settled_t, settled_v = np.ascontiguousarray((ensemble.settled if ensemble.chaotic else ensemble.ends).T)
        note_orbits(oscillator, settled_t, settled_v, after, members, pause)
        left = sum(members)
        if 2 * left > ENSEMBLE:
            return after[1:] or after
        if ensemble.chaotic:
            chaos = Attractor(AttractorKind.CHAOTIC, 0, 0, 0, *ensemble[1:3], ensemble.t, ensemble.v)
            if not left:
                return [chaos]
            after, members, later = follow_to_ends(oscillator, ensemble, after[1:], pause)
            if not later:  # those that left had begun beside the chaos, not on it
                return [*after, chaos]
            ends = tuple((place, number / ENSEMBLE) for place, number in enumerate(members) if number)
            kind, life = AttractorKind.CHAOTIC_TRANSIENT, ensemble.mean_life(left)
            return [*after, chaos._replace(kind=kind, mean_life=life, ends=ends)]
        t, v = float(ensemble.t[-1]), float(ensemble.v[-1])
    return [UNDECIDED_ATTRACTOR]


def _place_of(oscillator: Oscillator, motion: Attractor, catalogue: Sequence[Attractor], pause: Pause) -> int:
    """Place of a motion in the catalogue, -1 if it has none: by its kind or by where its last point arrives.

    A periodic orbit is looked for among such orbits alone. If a chaotic transient ends in it, its points may well lie
    in boxes that the transient has marked on its way.
    """
    if not motion.time.size:
        return next((place for place, listed in enumerate(catalogue) if listed.kind == motion.kind), -1)
    if motion.kind == AttractorKind.PERIODIC:
        catalogue = [listed if listed.kind == motion.kind else PERMANENT_CONTACT_ATTRACTOR for listed in catalogue]
    around = neighbourhoods(oscillator, catalogue, pause)
    return int(locate(oscillator, around, motion.time[-1:], motion.velocity[-1:])[0])


def _overlapping(oscillator: Oscillator, motion: Attractor, catalogue: Sequence[Attractor]) -> int | None:
    """Index of the chaotic motion in the catalogue that contains a chaotic motion or is contained in it, if any.

    One of the two may be a long transient through the other's surroundings. Listed separately they would share boxes.
    Shared boxes identify neither, so every seed would add another attractor.
    """
    if not motion.is_chaotic:
        return None
    chaotic = [i for i, listed in enumerate(catalogue) if listed.is_chaotic]
    return next((i for i in chaotic if hit_the_same_boxes(oscillator, motion, catalogue[i])), None)


def _united(known: Attractor, motion: Attractor) -> Attractor:
    """Merge two chaotic motions, with half of the points of each; a transient if trajectories were seen to leave."""
    time = np.concatenate([known.time[::2], motion.time[::2]])
    velocity = np.concatenate([known.velocity[::2], motion.velocity[::2]])
    rates = np.nan_to_num([1.0 / known.mean_life, 1.0 / motion.mean_life])
    lasts = not rates.any()
    some, others = dict(known.ends), dict(motion.ends)
    shares = {place: 0.5 * (some.get(place, 0.0) + others.get(place, 0.0)) for place in some | others}
    return motion._replace(
        kind=AttractorKind.CHAOTIC if lasts else AttractorKind.CHAOTIC_TRANSIENT,
        time=time, velocity=velocity, mean_life=np.nan if lasts else float(1.0 / rates.mean()),
        ends=tuple(sorted(shares.items())),
    )  # fmt: skip


def _list(oscillator: Oscillator, motions: Sequence[Attractor], catalogue: list[Attractor], pause: Pause) -> bool:
    """Add motions to the catalogue, whose ends are places in their own list; return whether one is new."""
    before = len(catalogue)
    places: list[int] = []
    for motion in motions:
        motion = motion._replace(ends=tuple((places[end], share) for end, share in motion.ends))
        same = _overlapping(oscillator, motion, catalogue)
        if same is not None:
            catalogue[same] = _united(catalogue[same], motion)
            places.append(same)
            continue
        place = _place_of(oscillator, motion, catalogue, pause)
        places.append(place if place >= 0 else len(catalogue))
        if place < 0:
            catalogue.append(motion)
    return len(catalogue) > before


def _settle(
    oscillator: Oscillator, t: np.ndarray, v: np.ndarray, applications: int, pause: Pause
) -> tuple[np.ndarray, np.ndarray]:
    """Points after many applications, without those captured."""
    times, speeds = [t[:0]], [v[:0]]
    at_a_time = max(64, _APPLICATIONS_AT_A_TIME // applications)
    for start in range(0, t.size, at_a_time):
        part = slice(start, start + at_a_time)
        settled, _ = run_lanes(oscillator, t[part], v[part], applications, shortcuts=True, pause=pause)
        left = settled.outcome == Outcome.RETURNED
        times.append(settled.t[left])
        speeds.append(settled.v[left])
    return np.concatenate(times), np.concatenate(speeds)


def _unknown(
    oscillator: Oscillator, t: np.ndarray, v: np.ndarray, catalogue: Sequence[Attractor], pause: Pause
) -> tuple[np.ndarray, np.ndarray]:
    """Those of some points that arrive at no motion of the catalogue."""
    places = locate(oscillator, neighbourhoods(oscillator, catalogue, pause), t, v)
    return t[places < 0], v[places < 0]


def _search(oscillator: Oscillator, t: np.ndarray, v: np.ndarray, catalogue: list[Attractor], pause: Pause) -> None:
    """Add the motions that some seeds end in, and that the catalogue lacks."""
    if any(motion.time.size for motion in catalogue):
        t, v = _unknown(oscillator, t, v, catalogue, pause)
    t, v = _settle(oscillator, t, v, _SETTLING, pause)
    fruitless = 0
    while fruitless < _FRUITLESS_SEEDS:
        pause()
        t, v = _unknown(oscillator, t, v, catalogue, pause)
        if not t.size:
            return
        motions = _motions_of(oscillator, float(t[0]), float(v[0]), pause)
        t, v = t[1:], v[1:]
        if _list(oscillator, motions, catalogue, pause):
            fruitless = 0
        else:
            fruitless += 1
            # A long transient: the other seeds are probably on one too. Lanes follow them a hundred times faster than
            # one by one.
            t, v = _settle(oscillator, t, v, 16 * _SETTLING, pause)


def _canonical(found: Sequence[Attractor]) -> tuple[Attractor, ...]:
    def key(attractor: Attractor) -> tuple[float, ...]:
        kinds = AttractorKind.PERMANENT_CONTACT, AttractorKind.PERIODIC, AttractorKind.CHAOTIC
        place = {kind: number for number, kind in enumerate((*kinds, AttractorKind.CHAOTIC_TRANSIENT))}
        contacts = attractor.upper_contacts, attractor.forcing_periods, attractor.lower_contacts
        lowest = (round(float(attractor.velocity.min()), 9), float(attractor.time[0])) if attractor.time.size else ()
        return (place.get(attractor.kind, len(place)), *contacts, *lowest)

    order = sorted(range(len(found)), key=lambda place: key(found[place]))
    now_at = {before: place for place, before in enumerate(order)}
    return tuple(
        found[before]._replace(ends=tuple(sorted((now_at[end], share) for end, share in found[before].ends)))
        for before in order
    )


def find_attractors(
    oscillator: Oscillator,
    t: np.typing.ArrayLike,
    v: np.typing.ArrayLike,
    known: Sequence[Attractor] = (),
    pause: Pause = never_stopped,
) -> tuple[Attractor, ...]:
    """Catalogue of the motions that seeds end in.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    t, v : array_like, shape (n,)
        Seeds: phases and speeds of departures from +beta, such as one landing point from each part of the plane.
    known : sequence of Attractor
        A catalogue to extend.
    pause : callable
        Called several times a second; an exception raised there ends the search.

    Returns
    -------
    tuple of Attractor
        Always permanent contact first. Then periodic orbits by (n+, m, n-) and lowest speed, chaotic attractors and
        chaotic transients. UNDECIDED last, if any seed is.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If a seed is no departure: not finite, or without a positive speed.
    """
    checked = check_oscillator(oscillator)
    catalogue = list(known) or [PERMANENT_CONTACT_ATTRACTOR]
    seeds = np.unique(np.column_stack(check_departures(t, v)), axis=0)
    every = max(1, math.ceil(len(seeds) / LANES))
    first = np.arange(len(seeds)) % every == 0
    for some in (seeds[first], seeds[~first]):
        _search(checked, some[:, 0].copy(), some[:, 1].copy(), catalogue, pause)
    return _canonical(catalogue)
