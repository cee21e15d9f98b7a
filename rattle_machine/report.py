"""A report as a file: the job is computed here, and its page is written down."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import rattle
from rattle_machine.analysis import page_in
from rattle_machine.job import ReportJob
from rattle_machine.proven import can_prove
from rattle_machine.pulses import Distribution, Pressing, measured_sizes
from worker.gear_pair import GearPair

if TYPE_CHECKING:
    from rattle_machine.tolerances import Tolerance
    from worker.gear_pair import Quantity


def report(
    machine: "GearPair | str | Path",
    path: str | Path,
    *,
    rate: "Quantity | None" = None,
    size: "Quantity | Path | Sequence[float] | np.ndarray | None" = None,
    distribution: Distribution | None = None,
    pressing: Pressing = "bounces",
    numbers: "Mapping[str, Tolerance] | None" = None,
    machines: int = 1024,
    departures: int = 2000,
    cells: int = 300,
    speeds: int = 16,
    limit: float = 0.99,
    prove: bool | None = None,
    seed: int = 0,
    title: str | None = None,
    progress: bool = True,
) -> Path:
    """Write what a machine does on one page that prints.

    What is computed for it is kept in `rattle.cache`.

    Parameters
    ----------
    machine : GearPair, str or path
        A machine in its own units, or a TOML file of it.
    path : str or path
        HTML file to write.
    rate, size, distribution, pressing
        Torque pulses that disturb the machine, as ``rattle.pulses`` takes them: both rate and size, or neither.
    numbers : mapping, optional
        Tolerances, as ``rattle.tolerances`` takes them.
    machines, limit
        Of the production, as ``rattle.tolerances`` takes them.
    prove : bool, optional
        Of the production, as ``rattle.tolerances`` takes it. By default if the package ``rattle_proof`` is installed.
    departures : int
        That are followed at each speed, and of pulses; of each machine of a production a half of them.
    cells : int
        Of the basin, each way.
    speeds : int
        At which the machine is looked at.
    seed : int
        Of all random numbers.
    title : str, optional
        By default the name of the TOML file.
    progress : bool
        Whether progress is shown on a terminal and in a notebook.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InvalidJob
        If an argument is wrong, or inertia torque reaches drag torque (Gamma of 1 or more) in a machine with a mesh
        stiffness, or in one that pulses are to hit. It is a ValueError.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> import rattle
    >>> pair = rattle.GearPair(speed=100.0, inertia=0.01, drag_torque=9.5493, base_radius=0.1, backlash=0.12,
    ...                        transmission_error=0.01)
    >>> rattle.report(pair, "report.html", cells=24, speeds=3, departures=64, progress=False).name
    'report.html'
    """
    name = title or (Path(machine).stem if isinstance(machine, str | Path) else None)
    measured = measured_sizes(size)
    given = {
        "rate": rate, "size": size if measured is None else measured.tolist(), "distribution": distribution,
        "numbers": dict(numbers) if numbers else None, "title": name,
        "certain": bool(numbers) and can_prove() if prove is None else prove,
    }  # fmt: skip
    job = ReportJob(
        machine=GearPair.of(machine), pressing=pressing, machines=machines, departures=departures, cells=cells,
        speeds=speeds, limit=limit, seed=seed, **{each: value for each, value in given.items() if value is not None},
    )  # fmt: skip
    found = rattle.compute(job, progress=progress)
    target = Path(path)
    target.write_bytes(page_in(found))
    return target
