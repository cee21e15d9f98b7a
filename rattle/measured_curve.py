"""A measured transmission error, from a CSV file or from arrays."""

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from rattle_kernels import TransmissionError
    from worker.errors import InvalidJob

COLUMNS = ("angle", "error")


def transmission_error(
    curve: "str | Path | ArrayLike",
    error: "ArrayLike | None" = None,
    *,
    unit: str = "turns",
    explained: float = 0.99,
    scale: float = 1.0,
    columns: tuple[str, str] = COLUMNS,
) -> "TransmissionError":
    """Make a forcing of a measured transmission error.

    Parameters
    ----------
    curve : str, path or array_like
        A CSV file, or the angles. The angle is that of the gear whose rotation is the forcing period. It increases,
        over one revolution or more, equally spaced or not.
    error : array_like, optional
        Beside angles: the error at each. Its mean is removed.
    unit : {"turns", "degrees", "radians"}
        Of the angle.
    explained : float
        The kept orders are the fewest that explain this part of the variance. Accelerations weigh an order by its
        square, so a small high order may matter: look at ``left_out``.
    scale : float
        The model is nondimensional: errors are multiplied by this to be in the units of its half backlash.
    columns : (str, str)
        Names of the file's columns. A file whose first line is numbers has the angle first and the error second. Lines
        that begin with # are comments.

    Returns
    -------
    TransmissionError
        Its ``forcing`` goes into any verb. t = 0 is where its first order is largest, ``shift`` turns into the curve.

    Raises
    ------
    ValueError
        Naming what is wrong, of a file with the line.

    Examples
    --------
    >>> import numpy as np
    >>> import rattle
    >>> angle = np.arange(0.0, 360.0, 2.0)
    >>> turned = np.deg2rad(angle)
    >>> micrometres = 10.0 * np.cos(turned) + 2.0 * np.sin(2.0 * turned)
    >>> error = rattle.transmission_error(angle, micrometres, unit="degrees", scale=0.01)
    >>> error.forcing
    {'eccentricity': 0.1, 'harmonics': (Harmonic(order=2.0, amplitude=0.02, phase=0.75),)}
    >>> least, phase = error.least_acceleration(damping=0.6)
    >>> round(least, 2), round(phase, 3)  # positive, so Eq. (8) holds
    (1.17, 0.102)
    """
    from rattle_kernels import UnusableCurve  # loads Numba
    from rattle_kernels import transmission_error as of_samples

    options: dict[str, Any] = {"unit": unit, "explained": explained, "scale": scale}
    if not isinstance(curve, str | Path):
        if error is None:
            raise _fault("give angles and errors, or the path of a CSV file")
        return of_samples(curve, error, **options)
    if error is not None:
        raise _fault(f"{curve} is a file, which has its errors")
    angles, errors, lines = _read(Path(curve), columns)
    try:
        return of_samples(angles, errors, **options)
    except UnusableCurve as fault:
        line = "" if fault.sample is None else f", line {lines[fault.sample]}"
        raise _fault(f"{curve}{line}: {fault}") from fault


def _read(path: Path, columns: tuple[str, str]) -> tuple[list[float], list[float], list[int]]:
    """Angles and errors of a file, and the line of each."""
    angles, errors, lines, places = [], [], [], None
    for line, cells in _rows(path):
        if places is None:
            places = (0, 1) if _is_number(cells[0]) else _places_of(columns, cells, f"{path}, line {line}")
            if not _is_number(cells[0]):
                continue
        try:
            angle, error = (float(cells[place]) for place in places)
        except (IndexError, ValueError):
            told = ",".join(cells)
            raise _fault(f"{path}, line {line}: an angle and an error are expected, not {told!r}") from None
        angles.append(angle)
        errors.append(error)
        lines.append(line)
    if not lines:
        raise _fault(f"{path}, line 1: there are no samples")
    return angles, errors, lines


def _rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Rows of a file with the numbers of their lines; empty lines and comments are left out."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = csv.reader(file)
            for row in rows:
                cells = [cell.strip() for cell in row]
                if any(cells) and not cells[0].startswith("#"):
                    yield rows.line_num, cells
    except OSError as error:
        raise _fault(f"{path} cannot be read: {error.strerror}") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise _fault(f"{path} is no CSV file: {error}") from error


def _places_of(columns: tuple[str, str], head: list[str], where: str) -> tuple[int, int]:
    for name in columns:
        if name not in head:
            raise _fault(f"{where}: there is no column {name!r}; there are {', '.join(map(repr, head))}")
    return head.index(columns[0]), head.index(columns[1])


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _fault(message: str) -> "InvalidJob":
    from worker.errors import InvalidJob

    return InvalidJob(message, ("transmission_error",))
