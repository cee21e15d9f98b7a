"""P by an ODE integrator: an oracle that shares nothing with the kernels, for any forcing and both kinds of damping."""

import math

from scipy.integrate import solve_ivp


def _force(oscillator, time):
    """Right side of Eq. (1), of a forcing with several orders."""
    total = 4.0 * math.pi * oscillator.damping
    for order, amplitude, phase in ((1.0, oscillator.eccentricity, 0.0), *oscillator.harmonics):
        rate, angle = 2.0 * math.pi * order, 2.0 * math.pi * (order * time + phase)
        total -= amplitude * rate * (rate * math.cos(angle) + oscillator.damping * math.sin(angle))
    return total


def _integrated(oscillator, time, state, spring, crossings, longest, step=0.05):
    """Follow Eq. (1) on one branch to the first of some crossings (level, direction)."""
    square = 2.0 * oscillator.stiffness
    drag = oscillator.damping
    if spring is not None:
        drag += 2.0 * oscillator.contact_damping * math.sqrt(square)

    def motion(time, state):
        restoring = 0.0 if spring is None else square * (state[0] - spring)
        return [state[1], _force(oscillator, time) - drag * state[1] - restoring]

    def crossing(level, direction):
        def event(_, state):
            return state[0] - level

        event.terminal, event.direction = True, direction
        return event

    events = [crossing(*each) for each in crossings]
    small = min(abs(state[1]) / math.sqrt(square), 1.0)
    run = solve_ivp(
        motion, (time, time + longest), state, "DOP853", events=events, rtol=1e-12, atol=1e-12 * small, max_step=step
    )
    met = [i for i, times in enumerate(run.t_events) if times.size]
    return run.t[-1], float(run.y[1, -1]), met[0] if met else None


def integrated_departure(oscillator, t, v, longest):
    """One application of P by an ODE integrator; None where contact has not ended."""
    beta, lower = oscillator.half_backlash, 0
    time, speed, met = _integrated(oscillator, t, [beta, -v], None, [(beta, 1.0), (-beta, -1.0)], 1e3)
    if met == 1:
        lower = 1
        time, speed, _ = _integrated(oscillator, time, [-beta, speed], -beta, [(-beta, 1.0)], 1e3)
        time, speed, _ = _integrated(oscillator, time, [-beta, speed], None, [(beta, 1.0)], 1e3)
    time, speed, met = _integrated(oscillator, time, [beta, speed], beta, [(beta, -1.0)], longest)
    return None if met is None else (time, -speed, lower)


def integrated_impact(oscillator, t, v):
    """One application of P of the impacting model by an ODE integrator."""
    free, beta, kept = oscillator._replace(stiffness=1.0), oscillator.half_backlash, oscillator.restitution
    time, speed, lower = _integrated(free, t, [beta, -v], None, [(beta, 1.0), (-beta, -1.0)], 1e3)
    if lower:
        time, speed, _ = _integrated(free, time, [-beta, -kept * speed], None, [(beta, 1.0)], 1e3)
    return time, kept * speed, lower


def integrated_loose_departure(oscillator, t, v, longest=1e3):
    """One application of P of a loose gear of finite stiffness; None where contact has not ended.

    Steps resolve the highest order of the forcing, and in contact the ringing: a piece takes several of them.
    """
    beta, lower = oscillator.half_backlash, 0
    free = 0.02 / max([1.0, *(harmonic[0] for harmonic in oscillator.harmonics)])
    held = min(free, 0.1 / math.sqrt(2.0 * oscillator.stiffness))
    walls = [(beta, 1.0), (-beta, -1.0)]
    time, speed, met = _integrated(oscillator, t, [beta, -v], None, walls, 1e3, free)
    while met == 1:
        lower += 1
        time, speed, _ = _integrated(oscillator, time, [-beta, speed], -beta, [(-beta, 1.0)], 1e3, held)
        time, speed, met = _integrated(oscillator, time, [-beta, speed], None, walls, 1e3, free)
    time, speed, met = _integrated(oscillator, time, [beta, speed], beta, [(beta, -1.0)], longest, held)
    return None if met is None else (time, -speed, lower)


def integrated_loose_impact(oscillator, t, v):
    """One application of P of a loose gear by an ODE integrator whose steps resolve its highest order."""
    free, beta, kept = oscillator._replace(stiffness=1.0), oscillator.half_backlash, oscillator.restitution
    step = 0.02 / max([1.0, *(harmonic[0] for harmonic in oscillator.harmonics)])
    walls, lower = [(beta, 1.0), (-beta, -1.0)], 0
    time, speed, met = _integrated(free, t, [beta, -v], None, walls, 1e3, step)
    while met == 1:
        lower += 1
        time, speed, met = _integrated(free, time, [-beta, -kept * speed], None, walls, 1e3, step)
    return time, kept * speed, lower
