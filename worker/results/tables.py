"""What a result lists, as tables: one for each dimension, and one for each array."""

import json
from enum import StrEnum
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from worker.errors import InvalidJob
from worker.gear_pair import IN_SI
from worker.kinds import KINDS, kind_of
from worker.motion_words import ends_in_words
from worker.results.measures import measure_loudness
from worker.results.motion_names import add_motion_names
from worker.results.opening import job_of, machine_in
from worker.stores.layout import ENDS
from worker.stores.solution_table import ends_in

_OF_A_TRAJECTORY = "time"
_LEADING = ("name", "share", "kind")
"""Columns that come first; errors come last. A wide table is printed without its middle."""


class TableFormat(StrEnum):
    """Format of a table's file."""

    CSV = "csv"
    JSON = "json"

    @property
    def media_type(self) -> str:
        """As in the header Content-Type."""
        return {"csv": "text/csv; charset=utf-8", "json": "application/json"}[self]

    @classmethod
    def of_file(cls, path: str | Path) -> "TableFormat":
        """Format that a file's name asks for.

        Raises
        ------
        InvalidJob
            If its name ends otherwise.
        """
        suffix = Path(path).suffix.removeprefix(".").lower()
        if suffix not in list(cls):
            raise InvalidJob(f"the name of a table ends in .csv or .json, not as {str(path)!r} does")
        return cls(suffix)


class Units(StrEnum):
    """Units of a table of a machine's result."""

    BOTH = "both"
    MODEL = "model"
    SI = "si"

    @classmethod
    def of(cls, given: str) -> "Units":
        """Units that an argument asks for.

        Raises
        ------
        InvalidJob
            If there are none of this name.
        """
        if given not in list(cls):
            raise InvalidJob(f"units of a table are {', '.join(cls)}, not {given!r}", ("units",))
        return cls(given)


def write_table(table: pd.DataFrame, table_format: TableFormat) -> str:
    """A table as text; JSON has one object for each row."""
    if table_format == TableFormat.CSV:
        return str(table.to_csv(index=False))
    return str(table.to_json(orient="records", double_precision=15, indent=1)) + "\n"


def tables_in(dataset: xr.Dataset) -> tuple[str, ...]:
    """Names of the tables of a result: its dimensions that have columns, then its arrays of several dimensions."""
    dimensions = [str(name) for name in dataset.dims if _columns_along(dataset, str(name))]
    arrays = [str(name) for name, array in dataset.data_vars.items() if array.ndim > 1 and "vertex" not in array.dims]
    return (*dimensions, *arrays)


def table_of(dataset: xr.Dataset, name: str | None = None, units: str = "both") -> pd.DataFrame:
    """A table of a result.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of `worker.results.opening.open_store`.
    name : str, optional
        A dimension, for all that is listed along it; or an array, for one row for each of its values. By default the
        attractors, the shares of a sweep, the departures of a diagram, the orbits, the orders, or the samples of Phi.
    units : {"both", "model", "si"}
        Of a machine: columns in SI units beside those of the model, or in place of them.

    Returns
    -------
    pandas.DataFrame
        Codes are written as words. Motions and basins come with their loudness, which is computed here.

    Raises
    ------
    InvalidJob
        If there is no such table; it names those that there are. Or if the result has no SI units.
    """
    machine, asked = machine_in(dataset), Units.of(units)
    if machine is None and asked is Units.SI:
        raise InvalidJob("this result has no SI units: its request names no machine", ("units",))
    table = _table_of(dataset, name)
    if machine is None:
        return table
    both = machine.with_columns(table)
    own = {of_model: of_machine for of_model, (of_machine, _) in IN_SI.items() if of_machine in both.columns}
    if asked is Units.BOTH:
        return both
    return both.drop(columns=[name for name in (own if asked is Units.SI else own.values()) if name in both.columns])


def _table_of(dataset: xr.Dataset, name: str | None) -> pd.DataFrame:
    chosen = _usual(dataset) if name is None else name
    # Names of motions are a column of their own.
    dataset = _with_loudness(dataset, chosen).drop_vars("attractor", errors="ignore")
    if chosen in dataset.dims and _columns_along(dataset, chosen):
        # A store lists its arrays by name.
        columns = sorted(_columns_along(dataset, chosen), key=_place_of)
        return pd.DataFrame({column: _in_words(dataset[column]) for column in columns} | _ends(dataset, chosen))
    if chosen not in dataset.data_vars:
        raise InvalidJob(f"there is no table {chosen!r}; there are {', '.join(tables_in(dataset))}")
    array = dataset[chosen]
    alike = [str(name) for name, other in dataset.data_vars.items() if other.dims == array.dims]
    unnamed = [str(name) for name in array.dims if name not in dataset.coords]
    beside = [column for dimension in unnamed for column in _columns_along(dataset, dimension)]
    table = dataset.reset_coords()[[*alike, *beside]].to_dataframe().reset_index()
    table = table[[*map(str, array.dims), *sorted(table.columns.drop([*map(str, array.dims)]), key=_place_of)]]
    for column in beside:
        table[column] = table[column].map(_words_of(dataset[column]) or (lambda value: value))
    if chosen == ENDS.name:
        table["ends_in"] = dataset["name"].values[table["end"]]
    if chosen == "impact_period":
        table = add_motion_names(dataset, table)
    return table.dropna(subset=[chosen]).reset_index(drop=True)


def _ends(dataset: xr.Dataset, chosen: str) -> dict[str, list[str]]:
    """A column for what the chaotic transients of a basin end in, if it has any."""
    if chosen != "attractor" or ENDS.name not in dataset or dataset[ENDS.name].ndim != 2:
        return {}
    ends, names = [ends_in(row) for row in dataset[ENDS.name].values], dataset["name"].values.tolist()
    return {"ends_in": [ends_in_words(each, names) for each in ends]} if any(ends) else {}


def _with_loudness(dataset: xr.Dataset, chosen: str) -> xr.Dataset:
    """The dataset with the loudness of its motions and basins, unless the table is of something else."""
    if "share" not in dataset:
        return dataset
    listed = {"attractor", *(axis.name for axis in job_of(dataset).axes)}
    along = (chosen,) if chosen in dataset.dims else dataset[chosen].dims if chosen in dataset else ()
    return dataset.assign(measure_loudness(dataset).data_vars) if listed.issuperset(map(str, along)) else dataset


def demand_small_table(dataset: xr.Dataset, name: str | None, most: int, zarr: str) -> None:
    """Refuse a table of more rows than are allowed.

    Parameters
    ----------
    dataset : xarray.Dataset
    name : str, optional
        Of the table, as in `table_of`.
    most : int
    zarr : str
        Where the store itself can be read.

    Raises
    ------
    InvalidJob
    """
    chosen = _usual(dataset) if name is None else name
    rows = dataset.sizes.get(chosen) or (dataset[chosen].size if chosen in dataset.data_vars else 0)
    if rows > most:
        raise InvalidJob(
            f"the table {chosen!r} has {rows} rows, more than the limit of {most}: read the Zarr store at {zarr} "
            "instead, as with xarray.open_zarr"
        )


def _usual(dataset: xr.Dataset) -> str:
    """The table that is meant if none is named; of one basin of a sweep that of its motions."""
    kind = KINDS.get(kind_of(json.loads(dataset.attrs["request"])))
    if kind is None:
        return _OF_A_TRAJECTORY
    return "attractor" if kind.table == "share" and dataset.share.ndim == 1 else kind.table


def _columns_along(dataset: xr.Dataset, dimension: str) -> list[str]:
    return [str(name) for name, array in dataset.variables.items() if array.dims == (dimension,)]


def _place_of(column: str) -> tuple[int, bool]:
    return (_LEADING.index(column) if column in _LEADING else len(_LEADING)), column.endswith("_error")


def _in_words(array: xr.DataArray) -> np.ndarray:
    """Values, with the words of a column of codes."""
    words, values = _words_of(array), array.values
    return np.array([words.get(code, "") for code in values.tolist()]) if words else values


def _words_of(array: xr.DataArray) -> dict[int, str]:
    """Words of the codes of an array; none if it holds no codes."""
    if "flag_meanings" not in array.attrs:
        return {}
    codes = np.atleast_1d(array.attrs["flag_values"]).tolist()
    return dict(zip(codes, str(array.attrs["flag_meanings"]).split(), strict=True))
