"""Discs around orbits, and permanent contact: what is proven is what motions do."""

import numpy as np
import pytest
from flint import arb, ctx

from rattle_kernels import (
    Oscillator,
    eccentricity_bound_quiet,
    find_orbits,
    largest_grazing_speed,
    next_impacts,
    time_history,
)
from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit
from rattle_proof.enclosures.orbit_disc import eigenframe
from rattle_proof.stiffness.contact import StiffMachine
from rattle_proof.stiffness.impact_map import NotProven
from rattle_proof.stiffness.orbit_disc import largest_disc, prove_disc
from rattle_proof.stiffness.permanent_contact import permanent_contact
from rattle_proof.verification.claims import Disc

FIG_6 = Oscillator(0.6, 0.1, 0.6, stiffness=1e4)
# As catalogues have them: impacts, time and speed.
ORBITS = {"P(1,1,0)": (1, 0.9133295804477, 3.7075602259586), "P(1,2,0)": (2, 0.473857125694, 2.072712884737)}


@pytest.fixture(autouse=True)
def digits():
    before, ctx.prec = ctx.prec, 128
    yield
    ctx.prec = before


def orbit_of(oscillator, impacts, t, v):
    return find_periodic_orbit(oscillator, t, v, impacts, largest_grazing_speed(oscillator))


def frame_of(orbit, oscillator, place=0):
    (a, b), (c, d) = eigenframe(orbit, place, largest_grazing_speed(oscillator)).tolist()
    return (a, b), (c, d)


def off(disc, t, v):
    dt = np.asarray(t) - disc.t
    return np.linalg.norm(np.array(disc.frame) @ [dt - np.rint(dt), np.asarray(v) - disc.v], axis=0)


@pytest.mark.parametrize("name", ORBITS)
def test_departures_of_a_disc_stay_in_it_come_closer_and_converge(name):
    orbit = orbit_of(FIG_6, *ORBITS[name])
    found = largest_disc(StiffMachine(FIG_6), orbit, 0, frame_of(orbit, FIG_6))
    disc = found.disc
    assert f"P({found.periods},{disc.impacts},{found.lower_contacts})" == name
    assert disc.radius > 1e-5 and 0.0 < found.contraction < 1.0
    angle = np.linspace(0.0, 2.0 * np.pi, 400)
    edge = disc.radius * np.array([np.cos(angle), np.sin(angle)])
    dt, dv = np.linalg.solve(np.array(disc.frame), edge)
    t, v = disc.t + dt, disc.v + dv
    assert found.slowest <= v.min()
    before = disc.radius
    for _ in range(20):
        landed = next_impacts(FIG_6, t, v, disc.impacts)
        t, v = landed.t, landed.v
        far = off(disc, t, v)
        assert (far <= found.contraction * before + 2 * found.apart + 1e-10).all()
        assert found.slowest <= v.min()
        before = far.max()
    landed = next_impacts(FIG_6, t, v, 200 * disc.impacts)
    assert off(disc, landed.t, landed.v).max() < 1e-9 + found.apart


def test_a_disc_about_a_saddle_or_off_its_orbit_or_over_the_graze_is_not_proven():
    machine = StiffMachine(FIG_6)
    saddles = [each.orbit for each in find_orbits(FIG_6, 1, cells=12) if not each.orbit.attracts]
    assert saddles
    for orbit in saddles:
        with pytest.raises(NotProven):
            largest_disc(machine, orbit, 0, frame_of(orbit, FIG_6))
    orbit = orbit_of(FIG_6, *ORBITS["P(1,1,0)"])
    frame = frame_of(orbit, FIG_6)
    disc = Disc(0, 1, float(orbit.t[0]), float(orbit.v[0]), frame, 1e-5)
    assert prove_disc(machine, disc).apart < 1e-9
    with pytest.raises(NotProven, match="leave it"):
        prove_disc(machine, disc._replace(v=disc.v + 1e-3))
    with pytest.raises(NotProven):
        prove_disc(machine, disc._replace(radius=0.2))
    with pytest.raises(NotProven, match="wide as a period"):
        prove_disc(machine, disc._replace(radius=1.0))


def test_the_periodic_point_is_as_near_as_is_said():
    # Its multipliers are positive: a turn moves a point beside it less far than it lies apart.
    orbit = orbit_of(FIG_6, 6, 0.6186371939363671, 4.500793492384444)
    assert np.isreal(orbit.multipliers).all() and (orbit.multipliers.real > 0.0).all()
    along = np.linalg.solve(np.array(frame_of(orbit, FIG_6)), np.eye(2))
    for dt, dv in 1e-8 * along.T:
        t, v = float(orbit.t[0] + dt), float(orbit.v[0] + dv)
        beside = Disc(0, 6, t, v, frame_of(orbit, FIG_6), 1e-6)
        found = prove_disc(StiffMachine(FIG_6), beside)
        assert off(beside, orbit.t[0], orbit.v[0]) <= found.apart < 1e-6


def test_a_disc_needs_the_norm_of_its_own_frame():
    # In a frame that is stretched a thousandfold the same orbit does not contract at once.
    orbit = orbit_of(FIG_6, *ORBITS["P(1,2,0)"])
    (a, b), (c, d) = frame_of(orbit, FIG_6)
    disc = Disc(0, 2, float(orbit.t[0]), float(orbit.v[0]), ((a, b), (1e3 * c + a, 1e3 * d + b)), 1e-7)
    with pytest.raises(NotProven, match="contract"):
        prove_disc(StiffMachine(FIG_6), disc)


@pytest.mark.parametrize("stiffness", [100.0, 1e3, 1e5])
def test_permanent_contact_is_proven_up_to_eq_3_and_not_beyond(stiffness):
    bound = eccentricity_bound_quiet(FIG_6.at(stiffness=stiffness))
    machine = FIG_6.at(stiffness=stiffness, eccentricity=bound * (1.0 - 1e-4))
    near = permanent_contact(StiffMachine(machine))
    assert near.depth > 0.0
    with pytest.raises(NotProven, match=r"Eq\. 3"):
        permanent_contact(StiffMachine(machine.at(eccentricity=bound * (1.0 + 1e-4))))
    # At no eccentricity the depth is 2 pi delta/kappa at all phases.
    flat = permanent_contact(StiffMachine(machine.at(eccentricity=0.0)))
    assert flat.depth == pytest.approx(2.0 * np.pi * 0.6 / stiffness, rel=1e-12)


def test_what_rings_by_less_than_the_depth_stays_in_contact_and_settles():
    machine = FIG_6.at(stiffness=1e3)
    stiff = StiffMachine(machine)
    found = permanent_contact(stiff)
    frequency, drag = float(stiff.frequency), float(stiff.drag)
    depths = [float(stiff.slow_part(arb(k) / 5003)[0]) for k in range(5003)]
    assert 0.99 * min(depths) < found.depth < min(depths)
    assert found.decay <= drag / 2.0 and found.velocity <= found.depth * frequency
    random = np.random.default_rng(6)
    for _ in range(20):
        phase, angle = random.random(), 2.0 * np.pi * random.random()
        value, rate, _ = (float(each) for each in stiff.slow_part(arb(phase)))
        z = 0.999 * found.depth * np.cos(angle)
        turn = 0.999 * found.depth * np.sin(angle) * frequency - drag * z / 2.0
        history = time_history(machine, phase, 0.6 + value + z, rate + turn, periods=20.0)
        assert (history.displacement > 0.6).all()
        end, _, _ = (
            float(each) for each in stiff.slow_part(arb(phase) + arb(float(history.time[-1] - history.time[0])))
        )
        assert abs(history.displacement[-1] - 0.6 - end) <= found.depth * np.exp(-found.decay * 20.0) + 1e-12


def test_what_rings_by_far_more_than_the_depth_may_leave():
    machine = FIG_6.at(stiffness=1e3)
    stiff = StiffMachine(machine)
    found = permanent_contact(stiff)
    left = []
    for phase in np.linspace(0.0, 1.0, 20, endpoint=False):
        value, rate, _ = (float(each) for each in stiff.slow_part(arb(float(phase))))
        history = time_history(machine, float(phase), 0.6 + value + 3.0 * found.depth, rate, periods=1.0)
        left.append((history.displacement < 0.6).any())
    assert any(left)
