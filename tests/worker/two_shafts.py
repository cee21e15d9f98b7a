"""The two shafts of a gear pair in SI units, integrated by SciPy: no scaling, no model, nothing of this package."""

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

TIGHT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-15}


class Shafts(NamedTuple):
    """Numbers in SI; radii of driving and driven gear, and a driving inertia that may be infinite."""

    speed: float  # of the driven shaft
    driving: float
    driven: float
    drag: float  # torque on the driven shaft
    radii: tuple[float, float]
    backlash: float
    stiffness: float
    ratio: float  # damping ratio of the contact
    restitution: float
    error: tuple[tuple[int, float, float], ...]
    turns: int

    @property
    def period(self):
        """Of the transmission error, s."""
        return 2 * math.pi * self.turns / self.speed

    @property
    def mobility(self):
        """One over the mass that is seen along the line of action."""
        return self.radii[0] ** 2 / self.driving + self.radii[1] ** 2 / self.driven

    def gap(self, time):
        """Transmission error, and its rate."""
        value = rate = 0.0
        for order, amplitude, phase in self.error:
            angular = 2 * math.pi * order / self.period
            angle = angular * time + 2 * math.pi * phase
            value += amplitude * math.cos(angle)
            rate -= amplitude * angular * math.sin(angle)
        return value, rate

    def opening(self, time, state):
        """Where the teeth are within the backlash, from -backlash/2 to backlash/2, and how fast."""
        value, rate = self.gap(time)
        first, second = self.radii
        return first * state[0] - second * state[1] + value, first * state[2] - second * state[3] + rate

    def force(self, time, state, wall):
        """Between the teeth, in contact with a wall, 1 or -1; 0 between them."""
        if wall == 0:
            return 0.0
        place, rate = self.opening(time, state)
        damper = 2 * self.ratio * math.sqrt(self.stiffness / self.mobility)
        return self.stiffness * (place - wall * self.backlash / 2) + damper * rate

    def rates(self, time, state, wall):
        """Both laws of motion."""
        first, second = self.radii
        rate = self.drag / (self.driven * self.speed)  # c2/I2, and c1/I1
        fast = self.speed * second / first  # of the driving shaft
        push = self.force(time, state, wall)
        # The driving torque holds both drags in steady motion; over I1, which may be infinite.
        torque = rate * fast + first / second * self.drag / self.driving
        return [
            state[2],
            state[3],
            torque - rate * state[2] - first * push / self.driving,
            second * push / self.driven - rate * state[3],
        ]

    def next_departure(self, time, speed):
        """From a departure from the upper wall at a time with a speed, m/s, to the next one."""
        first, second = self.radii
        value, rate = self.gap(time)
        # The driven shaft turns at its mean speed.
        state = np.array([(self.backlash / 2 - value) / first, 0.0, 0.0, self.speed])
        state[2] = (second * self.speed - speed - rate) / first
        wall = 0
        while True:
            events = [self._reaches(1), self._reaches(-1)] if wall == 0 else [self._leaves(wall)]
            ends = time + 5 * self.period
            path = solve_ivp(
                self.rates, (time, ends), state, args=(wall,), events=events, max_step=self.period / 50, **TIGHT
            )
            which = next(number for number, times in enumerate(path.t_events) if len(times))
            time, state = path.t_events[which][0], path.y_events[which][0].copy()
            if wall:
                if wall == 1:
                    return time, -self.opening(time, state)[1]
                wall = 0
                continue
            wall = (1, -1)[which]
            if math.isinf(self.stiffness):
                impulse = (1 + self.restitution) * self.opening(time, state)[1] / self.mobility
                state[2] -= first * impulse / self.driving
                state[3] += second * impulse / self.driven
                if wall == 1:
                    return time, -self.opening(time, state)[1]
                wall = 0

    def _reaches(self, wall):
        def event(time, state, _):
            return wall * self.opening(time, state)[0] - self.backlash / 2

        event.terminal, event.direction = True, 1
        return event

    def _leaves(self, wall):
        def event(time, state, _):
            return wall * self.opening(time, state)[0] - self.backlash / 2

        event.terminal, event.direction = True, -1
        return event


def shafts_of(pair, radii_ratio=1.0):
    """The same machine for the integrator: what the ratio of inertias stands for is taken apart again."""
    radii = pair.base_radius * radii_ratio, pair.base_radius
    driving = math.inf if pair.inertia_ratio == 0 else radii_ratio**2 * pair.inertia / pair.inertia_ratio
    error = tuple((order, each.amplitude, each.phase) for order, each in pair.transmission_error.items())
    stiff = math.inf if pair.mesh_stiffness is None else pair.mesh_stiffness
    return Shafts(
        pair.speed, driving, pair.inertia, pair.drag_torque, radii, pair.backlash, stiff,
        pair.contact_damping or 0.0, 1.0 if pair.restitution is None else pair.restitution, error, pair.turns,
    )  # fmt: skip
