"""What a dataset of this project can do: ``dataset.rattle`` draws it, measures it, and lists what it holds."""

from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

from rattle.results.measures import Measures
from rattle.results.plots import Plots
from worker.views.tables import table_of

if TYPE_CHECKING:
    import pandas as pd


@xr.register_dataset_accessor("rattle")
class Result(Measures, Plots):
    """A result of this project, as a dataset: of a basin, a sweep, an analysis or a trajectory.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of `rattle.open` or of a verb.

    Examples
    --------
    >>> import rattle
    >>> basin = rattle.basin(cells=40, progress=False)
    >>> basin.rattle.kind, basin.rattle.complete
    ('basin', True)
    """

    def to_table(self, name: str | None = None) -> "pd.DataFrame":
        """What the result lists, as a table.

        Parameters
        ----------
        name : str, optional
            Which table, where there are several; a wrong one lists them. By default the first.

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        InvalidJob
            If there is no table of that name.

        Examples
        --------
        >>> sweep = rattle.sweep(damping=[0.55, 0.6, 0.7], cells=16, iterations=101, progress=False)
        >>> sweep.rattle.to_table("change")[["change_kind", "change_from", "change_to"]].values.tolist()[0]
        ['death', 0.55, 0.6]
        """
        return table_of(self._dataset, name)

    def to_csv(self, path: str | Path, name: str | None = None) -> None:
        """Write a table as CSV.

        Parameters
        ----------
        path : str or path
        name : str, optional
            As for `to_table`.

        Raises
        ------
        InvalidJob
            If there is no table of that name.
        OSError
            If the file cannot be written.

        Examples
        --------
        >>> rattle.basin(cells=40, progress=False).rattle.to_csv("motions.csv")
        >>> from pathlib import Path
        >>> Path("motions.csv").read_text()[:16]
        'name,share,kind,'
        """
        self.to_table(name).to_csv(path, index=False)
