"""What of a plane boxes can prove at all, by numbers: ``python -m benchmarks.provable [DAMPING ECCENTRICITY]``.

For the panels of Figs. 8 and 9 with motions that take long to come to their end, or for one machine, two things (but
for damping 0.65, whose transient outlasts what is followed here):

- Of boxes as wide as a 64th of a cell (1/1600 of a period on 200 x 200 cells), and as 1/8192: how many have corners and
  a centre that end in different motions. No method proves those whole. There are more of them than five points see.
- Of departures that end in each motion: how far P^n stretches what is near them until they come near the motion. A box
  that is torn apart before touches what ends elsewhere, or never: saddles lie among the wanderers. So boxes must be as
  small as 2^-m of a period for half, 80 and 95 % of them to arrive as a whole, a twentieth of a period wide.
"""

import sys

import numpy as np

from rattle_kernels import Oscillator, find_attractors, next_impacts

PANELS = tuple((0.6, e) for e in (0.078, 0.0835, 0.089, 0.0945)) + tuple(
    (d, 0.1) for d in (0.5, 0.525, 0.55, 0.575, 0.7)
)
WIDTHS = {"1/1600": 1 / 1600, "1/8192": 1 / 8192}
_TOP = 7.0
_DEPARTURES, _LONG, _SETTLED = 8000, 3000, 40_000
# In periods, and in as many parts of the highest speed: how near to an orbit is arrived, and how wide a box may arrive.
_NEAR, _WHOLE = 0.01, 0.05
# Of differences, which give slopes, and how much faster than at rest rebounds still are.
_APART, _SLOW = 1e-8, 0.35


def motions_of(oscillator, random):
    """Motions that random departures end in."""
    landed = next_impacts(oscillator, random.random(2000), _TOP * random.random(2000), _SETTLED, shortcuts=True)
    rattles = np.isfinite(landed.t)
    return find_attractors(oscillator, landed.t[rattles], landed.v[rattles])


def _nearest(orbits, t, v):
    """Number of the orbit that a departure is near, counted from 1, 0 near none."""
    number, least = np.zeros(t.size, int), np.full(t.size, _NEAR)
    for n, orbit in enumerate(orbits, 1):
        for time, speed in zip(orbit.time, orbit.velocity, strict=True):
            off = np.hypot((t - time + 0.5) % 1.0 - 0.5, (v - speed) / _TOP)
            number[off < least] = n
            least = np.minimum(least, off)
    return number


def ends_of(oscillator, orbits, t, v):
    """What departures end in: an orbit, counted from 1, 0 where they fall quiet or in no orbit."""
    landed = next_impacts(oscillator, t, v, _SETTLED, shortcuts=True)
    number, rattles = np.zeros(t.size, int), np.isfinite(landed.t) & (landed.v > _SLOW)
    number[rattles] = _nearest(orbits, landed.t[rattles] % 1.0, landed.v[rattles])
    return number


def differing(oscillator, orbits, width, random):
    """Part of random boxes whose corners and centre do not all end in the same motion."""
    t, v = random.random(_DEPARTURES), _TOP * random.random(_DEPARTURES)
    first, differ = ends_of(oscillator, orbits, t, v), np.zeros(t.size, bool)
    for x, y in ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.5, 0.5)):
        differ |= ends_of(oscillator, orbits, (t + x * width) % 1.0, v + y * width * _TOP) != first
    return differ.mean()


def stretches(oscillator, orbits, random):
    """For each departure its end, the impacts until it is near it, and the largest stretch until then."""
    t, v = random.random(_DEPARTURES), _TOP * random.random(_DEPARTURES)
    slope = np.broadcast_to(np.eye(2)[..., None], (2, 2, t.size)).copy()
    end, life, most = np.full(t.size, -1), np.zeros(t.size, int), np.ones(t.size)
    for _ in range(_LONG):
        on = np.flatnonzero(end < 0)
        if not on.size:
            break
        here, late, fast = (
            next_impacts(oscillator, t[on] + _APART * x, v[on] + _APART * _TOP * y)
            for x, y in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
        )
        step = np.array([[late.t - here.t, fast.t - here.t], [late.v - here.v, fast.v - here.v]]) / _APART
        step[1] /= _TOP
        slope[:, :, on] = np.einsum("abn,bcn->acn", step, slope[:, :, on])
        size = np.linalg.norm(slope[:, :, on], axis=(0, 1))
        most[on] = np.fmax(most[on], size)
        t[on], v[on], life[on] = here.t % 1.0, here.v, life[on] + 1
        quiet = ~np.isfinite(here.t) | (here.v < _SLOW)
        near = _nearest(orbits, t[on], v[on])
        end[on] = np.where(quiet, 0, np.where(near > 0, near, -1))
    return end, life, most


def main(arguments):
    panels = [tuple(map(float, arguments))] if arguments else PANELS
    for damping, eccentricity in panels:
        oscillator, random = Oscillator(damping, eccentricity), np.random.default_rng(0)
        orbits = [each for each in motions_of(oscillator, random) if each.name.startswith("P(")]
        parts = {name: differing(oscillator, orbits, width, random) for name, width in WIDTHS.items()}
        told = ", ".join(f"{100 * part:.1f} % of {name}" for name, part in parts.items())
        print(f"damping {damping}, eccentricity {eccentricity}: boxes whose corners end differently: {told}")
        end, life, most = stretches(oscillator, orbits, random)
        for n, name in enumerate(["quiet", *(each.name for each in orbits)]):
            own = end == n
            if own.mean() < 0.01:
                continue
            sizes = np.log2(np.quantile(most[own], (0.5, 0.8, 0.95)) / _WHOLE)
            boxes = ", ".join(f"2^-{size:.0f}" for size in sizes)
            print(
                f"  {name}: {100 * own.mean():.1f} %, {np.median(life[own]):.0f} impacts; boxes of {boxes}", flush=True
            )


if __name__ == "__main__":
    main(sys.argv[1:])
