"""The explorer in a notebook, beside `rattle`: the page of the service as one widget, without a service.

Floors, the highest first; each imports from lower ones alone ::

    widget
    in_process
"""

import importlib.util
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

    from rattle_kernels import Oscillator
    from rattle_notebook.widget import Explorer
    from worker.gear_pair import GearPair


def explore(what: "xr.Dataset | Oscillator | GearPair | None" = None) -> "Explorer":
    """The explorer as a widget: sliders, plane, tooth and charts in an output of the notebook.

    Its requests are answered by this process, which opens no port. Jobs run in processes of their own; their results
    are removed when this process ends.

    Parameters
    ----------
    what : xarray.Dataset, Oscillator or GearPair, optional
        A result of this project, which is shown as it was computed if it lies in a folder here; or a machine, in the
        model or in its own units. By default the first example.

    Returns
    -------
    Explorer
        An ``anywidget``, as JupyterLab and marimo show it.

    Raises
    ------
    InvalidJob
        If it cannot be shown.
    ImportError
        If the extra ``notebook`` is not installed.

    Examples
    --------
    >>> import rattle
    >>> widget = rattle.explore(rattle.Oscillator(damping=0.7))
    >>> widget.solution = "P(1,1,0)"
    >>> widget.solution
    'P(1,1,0)'
    """
    for module in ("anywidget", "fastapi"):
        if importlib.util.find_spec(module) is None:
            raise ImportError(f"exploring needs {module}: pip install 'gear-rattle[notebook]'")
    from rattle_notebook.widget import Explorer, opening_of  # loads Numba and the service

    return Explorer(opening_of(what))


__all__ = ["explore"]
