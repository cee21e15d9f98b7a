"""Sine, cosine and phi2 as polynomials, exact to rounding, without a library call or a branch.

Angles are counted in half turns: their reduction is exact, and what is left is at most a quarter turn. The polynomials
are written out, because a loop over coefficients hides them from the vectoriser.
"""

import math

from rattle_kernels.numerics.jit import inlined_in_lanes

# Chebyshev fits on r^2 in [0, 1/4] of sin(pi r)/r (error 7e-19) and cos(pi r) (4e-18), and on [0, 1] of phi2 (9e-19).
_S = (
    3.141592653589793, -5.167712780049969, 2.5501640398773007, -0.5992645293189447, 0.0821458865731029,
    -0.007370430505916944, 0.0004662998161898394, -2.1903497074626018e-05, 7.697826768224191e-07,
)  # fmt: skip
_C = (
    1.0, -4.934802200544676, 4.058712126416497, -1.335262768843447, 0.23533063012953284,
    -0.025806888737002202, 0.0019295562724817132, -0.00010456655338748738, 4.149564353942586e-06,
)  # fmt: skip
_P = (
    0.5, -0.1666666666666664, 0.04166666666665401, -0.008333333333096557, 0.0013888888865978557, -0.0001984126853148021,
    2.4801539739718985e-05, -2.7556179049708925e-06, 2.753900275371731e-07, -2.4856214837612005e-08,
    1.952715306431462e-09, -1.0509453754979482e-10,
)  # fmt: skip


@inlined_in_lanes
def sine_rest_of_half_turns(r):
    """sin(pi r) - pi r for |r| <= 1/2."""
    z = r * r
    even = _S[8]
    even = even * z + _S[7]
    even = even * z + _S[6]
    even = even * z + _S[5]
    even = even * z + _S[4]
    even = even * z + _S[3]
    even = even * z + _S[2]
    even = even * z + _S[1]
    return r * z * even


@inlined_in_lanes
def sine_of_half_turns(r):
    """sin(pi r) for |r| <= 1/2."""
    return math.pi * r + sine_rest_of_half_turns(r)


@inlined_in_lanes
def versine_of_half_turns(r):
    """1 - cos(pi r) for |r| <= 1/2."""
    z = r * r
    even = _C[8]
    even = even * z + _C[7]
    even = even * z + _C[6]
    even = even * z + _C[5]
    even = even * z + _C[4]
    even = even * z + _C[3]
    even = even * z + _C[2]
    even = even * z + _C[1]
    return -z * even


@inlined_in_lanes
def cosine_of_half_turns(r):
    """cos(pi r) for |r| <= 1/2."""
    return 1.0 - versine_of_half_turns(r)


@inlined_in_lanes
def second_phi_of_part(x):
    """phi2(x) for 0 <= x <= 1."""
    total = _P[11]
    total = total * x + _P[10]
    total = total * x + _P[9]
    total = total * x + _P[8]
    total = total * x + _P[7]
    total = total * x + _P[6]
    total = total * x + _P[5]
    total = total * x + _P[4]
    total = total * x + _P[3]
    total = total * x + _P[2]
    total = total * x + _P[1]
    return total * x + _P[0]
