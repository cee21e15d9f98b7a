"""Make the known answers anew: ``python -m benchmarks.suite.exact`` (a minute; needs python-flint and heyoka).

None comes from the kernels that the suite measures, which guess at most where a root is. Images are exact to rounding,
in balls of 256 bits. Of departures whose image moves more than a thousand times as far as they do, nothing is known:
after 100 applications chaos leaves no digits. Ends come of the Taylor integrator with impacts, and of the paper's
recipe with contacts.
"""

import json
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat

import numpy as np

from benchmarks.suite.methods import ends_by_recipe
from benchmarks.suite.peers import ends_by_heyoka
from benchmarks.suite.workloads import ANSWERS, APPLICATIONS, OSCILLATOR, RATTLES, WORKLOADS
from rattle_kernels import next_impacts
from tests.rattle_proof.enclosures.exact_flights import ExactMap

_STEP = 1e-9
_MOST_AMPLIFIED = 1e3


def exact_image(t: float, v: float, applications: int) -> tuple[float, float]:
    """Image of a departure after so many applications, to the last digit: phase and speed; a time after one alone."""
    exact = ExactMap(OSCILLATOR)
    for _ in range(applications):
        # Balls of 256 bits are tiny; their middles keep more digits than the answer has.
        image = exact.image(t, v)
        t, v = image.t.mid(), image.v.mid()
        if applications > 1:
            t -= int(float(t))
    return float(t), float(v)


def _amplified(t: np.ndarray, v: np.ndarray) -> np.ndarray:
    """How far the images move as a multiple of how far departures do, about."""
    here = next_impacts(OSCILLATOR, t, v, APPLICATIONS)
    most = np.zeros(t.size)
    for near in (
        next_impacts(OSCILLATOR, t + _STEP, v, APPLICATIONS), next_impacts(OSCILLATOR, t, v + _STEP, APPLICATIONS),
    ):  # fmt: skip
        moved_t = np.abs((near.t - here.t + 0.5) % 1.0 - 0.5)
        most = np.maximum(most, np.maximum(moved_t, np.abs(near.v - here.v) / here.v) / _STEP)
    return most


def _hex(numbers: tuple[float, ...]) -> list[str]:
    return [number.hex() for number in numbers]


def _rows(ends: np.ndarray) -> list[str]:
    return ["".join("x" if end == RATTLES else np.base_repr(end, 36).lower() for end in row) for row in ends]


def written(answers: dict[str, list]) -> str:
    """JSON of answers, an item a line."""
    parts = (f'"{name}": [\n' + ",\n".join(map(json.dumps, rows)) + "\n]" for name, rows in answers.items())
    return "{\n" + ",\n".join(parts) + "\n}\n"


def main() -> None:
    """Compute them, and write them down."""
    answers: dict[str, list] = {}
    departures = WORKLOADS["applications"].part(WORKLOADS["applications"].known)
    followed = _amplified(*departures) < _MOST_AMPLIFIED
    (edges,) = WORKLOADS["boxes"].part(WORKLOADS["boxes"].known)
    centres = 0.5 * (edges[:, 0] + edges[:, 1]), 0.5 * (edges[:, 2] + edges[:, 3])
    with ProcessPoolExecutor() as processes:
        far = processes.map(exact_image, *(array[followed].tolist() for array in departures), repeat(APPLICATIONS))
        near = processes.map(exact_image, *(array.tolist() for array in centres), repeat(1))
        answers["boxes"] = [_hex(image) for image in near]
        answers["applications"] = [_hex(next(far)) if known else [None, None] for known in followed]
    panel = WORKLOADS["basin"].part(WORKLOADS["basin"].known)
    answers["basin"] = _rows(ends_by_heyoka(panel))
    answers["stiff basin"] = _rows(ends_by_recipe(panel))
    ANSWERS.write_text(written(answers))


if __name__ == "__main__":
    main()
