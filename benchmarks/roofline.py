"""What bounds the loops of the lanes: ``python -m benchmarks.roofline``.

The long run is compiled anew, and its machine code read: every innermost loop of a flight and a contact, and the
straight pieces that LLVM has made of shorter ones. llvm-mca runs each on its models of processors. Printed are, for
eight flights, the instructions, the most-used port and its share of them, the cycles that ports and decoder allow, the
cycles that llvm-mca sees with a window of the processor's size, and the cycles of eight flights alone: the latency of
their chain. At the end stand the cycles that a flight takes here, by a clock that a chain of dependent FMA tells.

LLVM 19 and 22 have no model of Zen 5: for ``znver5`` they take that of Zen 4, whose pipes are half as wide. What Zen 5
does with 512 bits Zen 4 does with 256, so there the registers are renamed to halves.
"""

import json
import math
import re
import shutil
import subprocess
import time
from collections import Counter
from collections.abc import Iterator
from typing import Any, NamedTuple

import numba
import numpy as np

from benchmarks.suite.workloads import WORKLOADS
from rattle_kernels import Oscillator
from rattle_kernels.lanes import long_run
from rattle_kernels.lanes.lane_fields import LANES
from rattle_kernels.lanes.run import run_lanes
from rattle_kernels.numerics.jit import kernel

_MODELS = "znver5", "znver4", "sapphirerapids"
_TOOLS = "llvm-mca-22", "llvm-mca-21", "llvm-mca-20", "llvm-mca-19"
_COLUMNS = "loop", "instructions", "busiest port", "ports", "in a loop", "alone"
_HALVES = (r"vextracti64x4 (.*)%ymm", r"vextracti128 \1%xmm"), (r"%zmm", "%ymm"), (r"{1to8}", "{1to4}")
_ITERATIONS = 100
_PER_ROW = 8  # flights in whole AVX-512 registers
_LEAST_PACKED = 20
_FMA_CYCLES = 4.0  # latency of a multiply-add on Zen 4, Zen 5 and Intel's processors since Skylake
_LINKS = 1_000_000
_POINTS, _APPLICATIONS, _ROUNDS = 1000, 1000, 25


class Piece(NamedTuple):
    """Straight machine code that the lanes pass again and again."""

    function: str
    line: int
    flights: float
    code: list[str]


class Estimate(NamedTuple):
    """Cycles of one pass of a piece on a model: by ports, in a loop and alone; its busiest port, and how long it is."""

    by_ports: float
    in_loop: float
    alone: float
    port: str
    busy: float


def _machine_code() -> str:
    """Assembly of the long run; what the disk cache has cannot be read."""
    t, v = np.array([0.2]), np.array([3.0])
    run_lanes(Oscillator(), t, v, 100, shortcuts=False)
    cached = long_run._fly_leg
    options = {name: value for name, value in cached.targetoptions.items() if name != "nopython"}
    fresh = numba.njit(**options, pipeline_class=cached._compiler.pipeline_class)(cached.py_func)
    fresh.compile(cached.signatures[0])
    return str(fresh.inspect_asm(cached.signatures[0]))


def _function_of(label: str) -> str:
    """Name of a function of the lanes by its label, empty for others."""
    found = re.search(r"^_ZN14rattle_kernels5lanes\w*?\d(fly|stay|_fly_leg)B", label)
    return found[1] if found else ""


def _flights_of(code: list[str]) -> float:
    """Flights in one pass of a loop, by the step of its counter and what it is multiplied by in addresses."""
    steps = re.findall(r"addq\s+\$(\d+), (%\w+)", "\n".join(code))
    step, register = next(((int(s), r) for s, r in reversed(steps)), (0, ""))
    scales = [int(s or 1) for s in re.findall(rf"\(%\w+,{register}(?:,(\d))?\)", "\n".join(code))] if step else []
    return step * min(scales) / 8 if scales else 0.0


def _is_packed(code: list[str]) -> bool:
    return sum("zmm" in line for line in code) >= _LEAST_PACKED


def _is_look_up(code: list[str]) -> bool:
    """Whether a loop only moves pairs of nodes."""
    return any("xmm" in line for line in code) and not any(re.match(r"v(add|sub|mul|div|cvt)\w*sd", x) for x in code)


def pieces(assembly: str) -> Iterator[Piece]:
    """Loops of the lanes, and straight pieces between them, in order.

    Parameters
    ----------
    assembly : str
        AT&T syntax, as `inspect_asm` gives it.

    Yields
    ------
    Piece
    """
    function, label, code = "", "", list[str]()
    for number, line in enumerate(assembly.splitlines(), 1):
        named, placed = re.match(r"([A-Za-z_]\S*):", line), re.match(r"(\.LBB\w+):", line)
        instruction = re.match(r"\s+([a-z]\w*)\b(.*)", line)
        ends = named or placed or (instruction and instruction[1].startswith(("j", "call", "ret")))
        if instruction and not ends:
            code.append(re.sub(r"\s+", " ", line.strip()))
        if not ends:
            continue
        loops = bool(instruction and label and instruction[2].strip() == label)
        if function and loops and (_is_packed(code) or (function != "_fly_leg" and _is_look_up(code))):
            flights = _flights_of(code)
            if flights > 0.0:
                yield Piece(function, number - len(code), flights, code)
        elif function in ("fly", "stay") and _is_packed(code):
            yield Piece(function, number - len(code), LANES, code)
        function = _function_of(named[1]) if named else function
        label = placed[1] if placed else "" if named else label if not instruction else ""
        code = []


def _analysed(tool: str, model: str, code: list[str], iterations: int) -> Any:
    text = "\n".join(line for line in code if "movabsq" not in line)  # addresses of constants
    if model == "znver5":
        for whole, half in _HALVES:
            text = re.sub(whole, half, text)
    command = [tool, f"-mcpu={model}", f"-iterations={iterations}", "--json", "-"]
    answer = subprocess.run(command, input=text, capture_output=True, text=True, check=True)
    return json.loads(answer.stdout)


def estimate(tool: str, model: str, code: list[str]) -> Estimate:
    """Cycles of one pass of a piece.

    Parameters
    ----------
    tool : str
        llvm-mca.
    model : str
        A processor that it knows.
    code : list of str
        Instructions.

    Returns
    -------
    Estimate
    """
    many, one = _analysed(tool, model, code, _ITERATIONS), _analysed(tool, model, code, 1)
    region, names = many["CodeRegions"][0], many["TargetInfo"]["Resources"]
    busy: Counter[str] = Counter()
    for each in region["ResourcePressureView"]["ResourcePressureInfo"]:
        if each["InstructionIndex"] == len(region["Instructions"]):
            busy[names[each["ResourceIndex"]]] += each["ResourceUsage"]
    port, cycles = busy.most_common(1)[0]
    summary, alone = region["SummaryView"], one["CodeRegions"][0]["SummaryView"]
    in_loop = summary["TotalCycles"] / _ITERATIONS
    return Estimate(summary["BlockRThroughput"], in_loop, alone["TotalCycles"], port, cycles)


@kernel
def _chain(links, x):
    for _ in range(links):
        x = x * 0.5 + 1.0
    return x


def _measured() -> tuple[float, float]:
    """GHz of this processor's clock, and nanoseconds of a flight of the impacting model."""
    inputs = WORKLOADS["applications"].inputs
    t, v = inputs.t[:_POINTS], inputs.v[:_POINTS]
    impacts, run = run_lanes(Oscillator(), t, v, _APPLICATIONS, shortcuts=False)
    flights = run.applications + int(impacts.lower_impacts.sum())
    _chain(1, 1.0)
    chain = lanes = math.inf
    for _ in range(_ROUNDS):
        begun = time.process_time()
        _chain(_LINKS, 1.0)
        between = time.process_time()
        run_lanes(Oscillator(), t, v, _APPLICATIONS, shortcuts=False)
        chain, lanes = min(chain, between - begun), min(lanes, time.process_time() - between)
    return _FMA_CYCLES * _LINKS / chain * 1e-9, lanes / flights * 1e9


def main() -> None:
    """Estimate, measure and print."""
    tool = next(filter(shutil.which, _TOOLS), None)
    if tool is None:
        print("llvm-mca is not there: install Debian's llvm-22, or another from 19 on, for the estimates")
    else:
        found = list(pieces(_machine_code()))
        for model in _MODELS:
            print(f"\n{model}\n| {' | '.join(_COLUMNS)} |\n{'|---' * len(_COLUMNS)}|")
            total: dict[str, np.ndarray] = {}
            for piece in found:
                per_row, it = _PER_ROW / piece.flights, estimate(tool, model, piece.code)
                numbers = np.array([len(piece.code), it.by_ports, it.in_loop]) * per_row
                total[piece.function] = total.get(piece.function, np.zeros(3)) + numbers
                count, by_ports, in_loop = numbers
                busy = f"{it.port} {it.busy * per_row:.0f}"
                loop = f"{piece.function}, line {piece.line}, {piece.flights:g} flights"
                print(f"| {loop} | {count:.0f} | {busy} | {by_ports:.0f} | {in_loop:.0f} | {it.alone:.0f} |")
            for function, numbers in total.items():
                print(f"| {function} | {numbers[0]:.0f} | | {numbers[1]:.0f} | {numbers[2]:.0f} | |")
    clock, flight = _measured()
    print(f"\nmeasured: {clock:.2f} GHz, {flight:.2f} ns a flight, {_PER_ROW * flight * clock:.0f} cycles for eight")


if __name__ == "__main__":
    main()
