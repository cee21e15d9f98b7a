"""A stored table as one declaration: from objects to the columns of a store, and back.

A row has one value in a column, several in further dimensions, or a run of values along a dimension that all rows share
(a contiguous ragged array).
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from operator import attrgetter
from types import SimpleNamespace
from typing import Any

import numpy as np

from worker.stores.layout import MISSING, Columns, Variable


@dataclass(frozen=True)
class Column:
    """One column of a table.

    Parameters
    ----------
    name : str
    dtype : type
    meaning : str
    get : str, callable or None
        Where an object's value comes from: an attribute (by default named as the column without the table's prefix) or
        a callable. None if objects do not have it.
    attributes : dict
        Attributes of the stored array.
    dims : dict of str to int
        Further dimensions with their lengths. A length of 0 means that rows differ; they are padded with NaN.
    along : str
        Dimension of runs of values, in place of the table's own.
    fill : Any
        By default a value that is not legal, or NaN for a padded column.
    """

    name: str
    dtype: Any
    meaning: str
    get: str | Callable[[Any], Any] | None = ""
    attributes: dict[str, Any] = field(default_factory=dict)
    dims: dict[str, int] = field(default_factory=dict)
    along: str = ""
    fill: Any = None

    @property
    def padded(self) -> bool:
        """Whether rows differ in length."""
        return 0 in self.dims.values()

    def variable(self, dimension: str) -> Variable:
        """Layout of the column in the store."""
        default: Any = "" if self.dtype is str else MISSING
        if self.dtype is np.float64:
            default = np.nan if self.padded else np.inf
        fill = default if self.fill is None else self.fill
        return Variable(
            self.name, (self.along or dimension, *self.dims), self.dtype, fill, self.meaning, self.attributes
        )

    def join(self, parts: Sequence[np.ndarray]) -> np.ndarray:
        """Values of several parts, one after another."""
        if not parts:
            return np.empty((0, *self.dims.values()), object if self.dtype is str else self.dtype)
        if self.padded:
            shape = np.max([part.shape[1:] for part in parts], axis=0)
            widths = [[(0, 0), *((0, more) for more in shape - part.shape[1:])] for part in parts]
            parts = [np.pad(part, width, constant_values=np.nan) for part, width in zip(parts, widths, strict=True)]
        return np.concatenate(parts)


@dataclass(frozen=True)
class Table:
    """A table of objects.

    Parameters
    ----------
    dimension : str
        Dimension with one entry for each object.
    columns : tuple of Column
    prefix : str
        Prefix of column names, left out in the attributes of objects and rows.
    length : str
        Column with the number of values that each row has in a padded column.
    """

    dimension: str
    columns: tuple[Column, ...]
    prefix: str = ""
    length: str = ""

    @cached_property
    def variables(self) -> tuple[Variable, ...]:
        """Layout of the table in a store."""
        return tuple(column.variable(self.dimension) for column in self.columns)

    def _part(self, column: Column, each: Any) -> np.ndarray:
        get = column.get or column.name.removeprefix(self.prefix)
        value = get(each) if callable(get) else attrgetter(get)(each)
        array = np.asarray(value, object if column.dtype is str else column.dtype)
        return array if column.along else array[None]

    def of(self, objects: Iterable[Any]) -> Columns:
        """Columns of some objects."""
        own, listed = [column for column in self.columns if column.get is not None], list(objects)
        return {column.name: column.join([self._part(column, each) for each in listed]) for column in own}

    def join(self, parts: Sequence[Columns]) -> Columns:
        """Columns of several tables, one after another. A column that they lack is empty."""
        return {
            column.name: column.join([part[column.name] for part in parts if column.name in part])
            for column in self.columns
        }

    def rows(self, columns: Mapping[str, Any]) -> list[SimpleNamespace]:
        """Rows of the columns of a part, a store or an xarray dataset, with the columns as attributes.

        Single values are Python's, padding is left out, and runs are slices of their arrays.
        """
        arrays = {column.name: np.asarray(columns[column.name]) for column in self.columns if column.name in columns}
        parts: dict[str, Sequence[Any]] = {}
        for column in self.columns:
            array, name = arrays.get(column.name), column.name.removeprefix(self.prefix)
            if array is None or column.along not in ("", *self._runs):
                continue
            if column.along:
                parts[name] = [array[run] for run in slices(arrays[self._runs[column.along]])]
            elif column.padded and self.length:
                parts[name] = [values[:count] for values, count in zip(array, arrays[self.length], strict=True)]
            else:
                parts[name] = list(array) if column.dims else array.tolist()
        return [SimpleNamespace(**dict(zip(parts, row, strict=True))) for row in zip(*parts.values(), strict=True)]

    @cached_property
    def _runs(self) -> dict[str, str]:
        """Column with the lengths of the runs along each dimension."""
        sized = [column for column in self.columns if "sample_dimension" in column.attributes]
        return {column.attributes["sample_dimension"]: column.name for column in sized}


def slices(sizes: np.ndarray) -> list[slice]:
    """Slices of the runs of a contiguous ragged array."""
    stops = np.cumsum(sizes).tolist()
    return [slice(stop - int(size), stop) for stop, size in zip(stops, sizes.tolist(), strict=True)]
