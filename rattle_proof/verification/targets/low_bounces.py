"""Low bounces lose their action v^3/a(t): over all departures t and durations tau of a box, down to tau = 0.

Let A(x) = a(t + tau x). As long as -beta is kept clear of, exactly

    v/tau = U = int A q dx,    v'/tau = W = int A (1 - q) dx,    q(x) = E(tau (1 - x))/E(tau),

where v is the speed of departure and v' that of arrival. Without damping q = 1 - x: call those U_0 and W_0. E is
concave, so q = 1 - x + delta tau g(x) with g >= 0, and

    U = U_0 + delta tau I,    W = W_0 - delta tau I,    I = int A g dx > 0,
    int g x^k dx = k! (phi_2/(k + 2)! - phi_(k+3))/phi_1  at delta tau.

The action falls if W^3 A(0) < U^3 A(1) (r <= 1). Now ``W_0^3 A(0) - U_0^3 A(1) = tau M(tau)``; and undamped flights are
the same backwards in time, so in M the powers 0 and 1 of tau cancel: ``M = tau^2 N``. What is to be shown is thus

    tau^2 N(tau) < delta I (A(0) (W^2 + W W_0 + W_0^2) + A(1) (U^2 + U U_0 + U_0^2)),

in which every term on the right is positive and nothing cancels. N comes from Taylor's series of a at t, with the last
derivative anywhere in the bounce:

    U_0 = sum a_k tau^k/(k! (k+1)(k+2)),
    (W_0 - U_0)/tau = J = int A'(x) x (1 - x) dx/tau = sum a_(k+1) tau^k/(k! (k+2)(k+3)),
    (A(1) - A(0))/tau = H = sum a_(k+1) tau^k/(k+1)!,
    M = a (3 U_0^2 J + 3 tau U_0 J^2 + tau^2 J^3) - U_0^3 H.

With a restitution below 1 the inequality ``r^3 W^3 A(0) < U^3 A(1)`` itself may hold more easily; it is tried as well.
"""

from math import factorial
from typing import NamedTuple

from flint import arb, arb_poly

from rattle_proof.verification.machine import Machine

ORDER = 14
"""Derivative of a in which the rest of Taylor's series is taken."""


class LowBounces(NamedTuple):
    """Whether the action falls at all bounces of a box; the speeds and the actions that they leave with."""

    falls: bool
    speed: arb
    action: arb


def low_bounces(machine: Machine, t: arb, tau: arb) -> LowBounces:
    """Bounces of a box.

    Parameters
    ----------
    machine : Machine
        a(t) > 0.
    t, tau : arb
        Times of departure, and durations of 0 or more.

    Returns
    -------
    LowBounces
    """
    tau = tau.lower().nonnegative_part().union(tau.upper().nonnegative_part())
    during = t.lower().union((t + tau).upper())
    bends = machine.derivatives(t, ORDER)
    bends.append(machine.derivatives(during, ORDER + 1)[ORDER])
    u = arb_poly([bends[k] / (factorial(k) * (k + 1) * (k + 2)) for k in range(ORDER + 1)])
    j = arb_poly([bends[k + 1] / (factorial(k) * (k + 2) * (k + 3)) for k in range(ORDER)])
    h = arb_poly([bends[k + 1] / factorial(k + 1) for k in range(ORDER)])
    x = arb_poly([0, 1])
    total = 3 * bends[0] * u * u * j + 3 * bends[0] * x * u * j * j + bends[0] * x * x * j * j * j - u * u * u * h
    grown = arb_poly(total.coeffs()[2:])(tau)
    slowest, swing = u(tau), j(tau)
    fastest = slowest + tau * swing
    after = bends[0] + tau * h(tau)
    lags = _lags(machine.damping * tau)
    lost = sum((bend * tau**k * lag for k, (bend, lag) in enumerate(zip(bends, lags, strict=True))), arb(0))
    u_all = slowest + machine.damping * tau * lost
    w_all = fastest - machine.damping * tau * lost
    speed = tau * u_all
    action = speed**3 / bends[0]
    if not (u_all > 0 and w_all > 0 and after > 0 and slowest > 0 and fastest > 0):
        return LowBounces(False, speed, action)
    shed = bends[0] * (w_all**2 + w_all * fastest + fastest**2) + after * (u_all**2 + u_all * slowest + slowest**2)
    falls = tau * tau * grown < machine.damping * lost * shed
    falls = falls or machine.restitution**3 * w_all**3 * bends[0] < u_all**3 * after
    return LowBounces(bool(falls), speed, action)


def _lags(x: arb) -> list[arb]:
    """The integrals of ``g x^k/k!``."""
    phi = [low.union(high) for low, high in zip(_phis(x.lower()), _phis(x.upper()), strict=True)]
    return [(phi[2] / factorial(k + 2) - phi[k + 3]) / phi[1] for k in range(ORDER + 1)]


def _phis(x: arb) -> list[arb]:
    """``phi_k = int e^(-x (1 - s)) s^(k-1)/(k-1)! ds`` at a number x >= 0: each falls as x grows."""
    last = ORDER + 3
    # Kummer's function: phi_k = 1F1(1; k + 1; -x)/k!.
    found = [(-x).hypgeom_1f1(arb(1), arb(last + 1)) / factorial(last)]
    for k in range(last - 1, -1, -1):
        found.append(1 / arb(factorial(k)) - x * found[-1])
    return found[::-1]
