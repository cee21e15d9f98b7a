"""Whether the kernels of this process multiply and add in one rounding: those that do not give other results.

Asked of machine code that is compiled as every kernel is, not of the processor: it may be another one's code that runs,
where ``NUMBA_CPU_NAME`` says so.
"""

from functools import cache

from rattle_kernels.numerics.jit import kernel

# (1 + h) (1 - h) is 1 - h^2, which no float64 holds: rounded by itself it is 1.
_H = 2.0**-30


@kernel
def _multiply_and_add(a: float, b: float, c: float) -> float:
    return a * b + c


@cache
def fuses_multiply_add() -> bool:
    """Whether kernels are compiled to fused multiply-add (FMA).

    Basins computed with it were the same to the byte on all processors that were tried; those without it are others.

    Returns
    -------
    bool
    """
    return bool(_multiply_and_add(1.0 + _H, 1.0 - _H, -1.0) != 0.0)
