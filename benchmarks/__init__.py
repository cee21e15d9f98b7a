"""Speed, as a ratio to plain methods of the same run."""

from cpuinfo import get_cpu_info
from llvmlite.binding import get_host_cpu_name


def processor() -> str:
    """Name of this processor, with the generation that LLVM knows: virtual machines name many of them alike."""
    return f"{get_cpu_info()['brand_raw']} ({get_host_cpu_name()})"
