"""Speed, as a ratio to plain methods of the same run."""

from rattle.processor import use_whole_registers

# Before Numba is loaded, as in the processes that users run.
use_whole_registers()
