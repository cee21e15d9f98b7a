"""Tests, in folders that mirror those of the packages."""

from rattle.processor import use_whole_registers

# Before Numba is loaded: the kernels of tests are those of the processes that they start.
use_whole_registers()
