"""The certificate of a proof, as JSON: its constants and counts; and the targets that it says.

Numbers are written with all their digits, so what is read back is what was proven.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from rattle_kernels import Attractor, AttractorKind
from rattle_proof.enclosures.cells import IMPACTS as OF_A_CELL
from rattle_proof.enclosures.growth import IMPACTS as OF_A_TRAIL
from rattle_proof.enclosures.lattice import UNPROVEN, Lattice
from rattle_proof.enclosures.machine import Machine, parts_of
from rattle_proof.enclosures.orbit_disc import OrbitDisc, disc_rows
from rattle_proof.enclosures.targets import NO_QUIET, NOTHING_KNOWN, RATTLES, Certificate, Targets
from rattle_proof.enclosures.windows import IMPACTS as OF_A_WINDOW
from rattle_proof.enclosures.windows import Windows

_PLACE = "height", "first", "columns", "left"


def certificate_of(
    machine: Machine, attractors: Sequence[Attractor], proven: Certificate, levels: int, cuts: int
) -> dict[str, Any]:
    """What is proven of targets, with the lattice as it is when its boxes have been cut so often.

    Parameters
    ----------
    machine : Machine
    attractors : sequence of Attractor
        By the numbers of the solutions.
    proven : Certificate
    levels : int
        How often cells are cut.
    cuts : int
        How often boxes of the lattice are cut.

    Returns
    -------
    dict
    """
    quiet = [n for n, each in enumerate(attractors) if each.kind == AttractorKind.PERMANENT_CONTACT]
    lattice, rattling = proven.targets.lattice, proven.targets.rattling
    rows, columns = lattice.ends.shape
    parts = parts_of(machine)
    return {
        "machine": _ranges(machine),
        "parts": [_ranges(part) for part in parts] if len(parts) > 1 else [],
        "motions": [each.name for each in attractors],
        "quiet": {"motion": quiet[0], "level": proven.level} if quiet else None,
        "discs": [_disc(motion, disc) for motion, disc in proven.discs.items()],
        "windows": [_window(*map(float, each)) for each in proven.targets.windows.places],
        "rattling": None if rattling is NOTHING_KNOWN else {"motion": proven.rattling, **_place(rattling)},
        "lattice": {
            "height": lattice.height / 2**cuts,
            "first": lattice.first * 2**cuts,
            "columns": columns * 2**cuts,
            "rows": rows * 2**cuts,
        },
        "impacts": {"window": OF_A_WINDOW, "trail": OF_A_TRAIL, "cell": OF_A_CELL},
        "levels": levels,
    }


def _ranges(machine: Machine) -> dict[str, Any]:
    return {
        "damping": list(machine.damping),
        "half_backlash": list(machine.half_backlash),
        "restitution": list(machine.restitution),
        "harmonics": machine.harmonics.tolist(),
    }


def _disc(motion: int, disc: OrbitDisc) -> dict[str, Any]:
    return {"motion": motion, **disc._asdict(), "frame": disc.frame.tolist()}


def _window(height: float, first: float, columns: float, left: float) -> dict[str, Any]:
    return {"height": height, "first": int(first), "columns": int(columns), "left": int(left)}


def _place(lattice: Lattice) -> dict[str, Any]:
    return {"height": lattice.height, "first": lattice.first, "columns": lattice.ends.shape[1]}


def places_of(certificate: dict[str, Any]) -> np.ndarray:
    """Where the windows of a certificate lie, as `Windows` has it; stores of earlier versions have none.

    Parameters
    ----------
    certificate : dict

    Returns
    -------
    ndarray, shape (windows, 4)
    """
    told = certificate.get("windows", [])
    return np.array([[each[name] for name in _PLACE] for each in told], float).reshape(-1, len(_PLACE))


def most_impacts(impacts: dict[str, int], rounds: int) -> int:
    """After how many impacts at most departures of proven cells lie in the core, whose boxes have so many rounds.

    Parameters
    ----------
    impacts : dict of str to int
        Of a certificate: how long cells and boxes are followed at most.
    rounds : int

    Returns
    -------
    int
    """
    return impacts["cell"] + impacts["trail"] * rounds


def targets_of(
    certificate: dict[str, Any], ends: np.ndarray, rattles: np.ndarray, windows: Windows, never_quiet: np.ndarray
) -> Targets:
    """Targets that a certificate says, with a lattice of any number of cuts.

    Parameters
    ----------
    certificate : dict
    ends : ndarray of uint16, shape (rows, columns)
        Of one lattice, or of all parts' above each other.
    rattles : ndarray of uint8, shape (rows, columns)
        Boxes of the set that rattles for ever.
    windows : Windows
    never_quiet : ndarray of uint16, shape (rows, columns)
        1 in boxes of the lattice of which nothing falls quiet, as far as that is known.

    Returns
    -------
    Targets
    """
    cut = certificate["lattice"]["columns"] // ends.shape[1]
    lattice = Lattice(certificate["lattice"]["height"] * cut, certificate["lattice"]["first"] // cut, ends)
    discs = {
        each["motion"]: OrbitDisc(each["impacts"], each["t"], each["v"], np.array(each["frame"]), each["radius"])
        for each in certificate["discs"]
    }
    rattling, place = NOTHING_KNOWN, certificate["rattling"]
    if place is not None:
        end = RATTLES if place["motion"] is None else 1 + place["motion"]
        known = np.where(rattles, end, UNPROVEN).astype(np.uint16)
        rattling = Lattice(place["height"], place["first"], known)
    quiet = NO_QUIET if certificate["quiet"] is None else 1 + certificate["quiet"]["motion"]
    return Targets(lattice, rattling, disc_rows(discs), windows, quiet, lattice._replace(ends=never_quiet))
