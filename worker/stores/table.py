"""A stored table as one declaration: from objects to the columns of a store, and back.

All arrays are by columns. A row may have one value in a column, several in further dimensions, or a whole run of values
along a dimension that all rows share (a contiguous ragged array).
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
    get : str, callable or None
        An object's value: the attribute of this name, or what the callable returns. None if objects do not have it.
    meaning : str
    attributes : dict
        Of the stored array.
    dims : dict of str to int
        Further dimensions with their lengths. A length of 0 means that rows differ; they are padded with NaN.
    along : str
        Dimension of runs of values, in place of the table's own.
    fill : Any
        By default a value that is not legal, or NaN for a padded column.
    """

    name: str
    dtype: Any
    get: str | Callable[[Any], Any] | None
    meaning: str
    attributes: dict[str, Any] = field(default_factory=dict)
    dims: dict[str, int] = field(default_factory=dict)
    along: str = ""
    fill: Any = None

    def variable(self, dimension: str) -> Variable:
        """Layout of the column in the store."""
        padded = 0 in self.dims.values()
        default = "" if self.dtype is str else np.nan if padded else np.inf if self.dtype is np.float64 else MISSING
        fill = default if self.fill is None else self.fill
        dims = (self.along or dimension, *self.dims)
        return Variable(self.name, dims, self.dtype, fill, self.meaning, self.attributes)

    def of(self, each: Any) -> np.ndarray:
        """Values of one object."""
        assert self.get is not None
        value = attrgetter(self.get)(each) if isinstance(self.get, str) else self.get(each)
        array = np.asarray(value, object if self.dtype is str else self.dtype)
        return array if self.along else array[None]

    def join(self, parts: Sequence[np.ndarray]) -> np.ndarray:
        """Values of several objects or parts, one after another."""
        if not parts:
            return np.empty((0, *self.dims.values()), object if self.dtype is str else self.dtype)
        shape = np.max([part.shape[1:] for part in parts], axis=0).astype(int).tolist()
        if 0 in self.dims.values():
            widths = [[(0, 0), *((0, a - b) for a, b in zip(shape, part.shape[1:], strict=True))] for part in parts]
            parts = [np.pad(part, width, constant_values=np.nan) for part, width in zip(parts, widths, strict=True)]
        return np.concatenate(parts)


@dataclass(frozen=True)
class Table:
    """A table of objects.

    Parameters
    ----------
    dimension : str
        Along which the objects are.
    columns : tuple of Column
    prefix : str
        With which the names of columns begin; `rows` leaves it out.
    length : str
        Column that says how many of a padded column's values a row has.
    """

    dimension: str
    columns: tuple[Column, ...]
    prefix: str = ""
    length: str = ""

    @cached_property
    def variables(self) -> tuple[Variable, ...]:
        """Layout of the table in a store."""
        return tuple(column.variable(self.dimension) for column in self.columns)

    def of(self, objects: Iterable[Any]) -> Columns:
        """Columns of some objects."""
        listed = list(objects)
        return {
            column.name: column.join([column.of(each) for each in listed])
            for column in self.columns if column.get is not None
        }  # fmt: skip

    def join(self, parts: Sequence[Columns]) -> Columns:
        """Columns of several tables, one after another. A column that they lack is empty."""
        return {
            column.name: column.join([part[column.name] for part in parts if column.name in part])
            for column in self.columns
        }

    def rows(self, columns: Mapping[str, Any]) -> list[SimpleNamespace]:
        """Rows of such columns, of a part, a store or an xarray dataset, with columns as attributes.

        Single values are Python's, padding is left out, and runs are slices of their arrays.
        """
        arrays = {column.name: np.asarray(columns[column.name]) for column in self.columns if column.name in columns}
        runs = {
            column.attributes["sample_dimension"]: slices(arrays[column.name])
            for column in self.columns if "sample_dimension" in column.attributes
        }  # fmt: skip
        own = [column for column in self.columns if column.name in arrays and column.along in ("", *runs)]
        count = len(next(arrays[column.name] for column in own if not column.along))
        return [
            SimpleNamespace(
                **{
                    column.name.removeprefix(self.prefix): arrays[column.name][runs[column.along][row]]
                    if column.along
                    else self._value(arrays, column, row)
                    for column in own
                }
            )
            for row in range(count)
        ]

    def _value(self, arrays: Columns, column: Column, row: int) -> Any:
        value = arrays[column.name][row]
        if not column.dims:
            return value.item() if isinstance(value, np.generic) else value
        return value[: int(arrays[self.length][row])] if self.length and 0 in column.dims.values() else value


def slices(sizes: np.ndarray) -> list[slice]:
    """Where the runs of a contiguous ragged array lie."""
    stops = np.cumsum(sizes).tolist()
    return [slice(stop - int(size), stop) for stop, size in zip(stops, sizes.tolist(), strict=True)]
