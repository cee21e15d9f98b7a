"""A declared table: columns of objects, their rows, and tables joined."""

from types import SimpleNamespace

import numpy as np

from worker.stores.layout import MISSING
from worker.stores.table import Column, Table

TABLE = Table("walk", (
    Column("walk_name", str, "name"),
    Column("walk_steps", np.int32, "steps", "x.size"),
    Column("walk_marks", np.float64, "one for each step", dims={"step": 0}),
    Column("walk_ends", np.float64, "first and last", lambda walk: walk.x[[0, -1]], dims={"end": 2}),
    Column("walk_size", np.int64, "points of a walk", "x.size", {"sample_dimension": "point"}),
    Column("x", np.float64, "positions", along="point"),
    Column("walk_owner", np.int32, "filled in later", None),
), prefix="walk_", length="walk_steps")  # fmt: skip
SHORT = SimpleNamespace(name="short", x=np.array([1.0, 2.0]), marks=[5.0, 6.0])
LONG = SimpleNamespace(name="long", x=np.array([3.0, 4.0, 5.0]), marks=[7.0, 8.0, np.nan])


def test_variables_have_dimensions_and_fill_values():
    named = {variable.name: variable for variable in TABLE.variables}
    assert named["walk_marks"].dims == ("walk", "step") and np.isnan(named["walk_marks"].fill)
    assert named["x"].dims == ("point",) and named["x"].fill == np.inf
    assert named["walk_owner"].fill == MISSING and named["walk_name"].fill == ""


def test_rows_are_what_the_columns_were_made_of():
    columns = TABLE.of([SHORT, LONG])
    assert columns["walk_marks"].shape == (2, 3) and np.isnan(columns["walk_marks"][0, 2])
    assert columns["x"].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0] and "walk_owner" not in columns
    for row, walk in zip(TABLE.rows(columns), (SHORT, LONG), strict=True):
        assert (row.name, row.steps, row.x.tolist()) == (walk.name, walk.x.size, walk.x.tolist())
        np.testing.assert_array_equal(row.marks, walk.marks)


def test_joined_parts_are_the_table_of_all():
    whole, joined = TABLE.of([SHORT, LONG]), TABLE.join([TABLE.of([SHORT]), TABLE.of([LONG])])
    for name, column in whole.items():
        np.testing.assert_array_equal(column, joined[name])
        assert column.dtype == joined[name].dtype


def test_an_empty_table_has_its_shapes_and_types():
    empty = TABLE.join([])
    assert {name: column.shape for name, column in empty.items()} == {
        "walk_name": (0,), "walk_steps": (0,), "walk_marks": (0, 0), "walk_ends": (0, 2), "walk_size": (0,), "x": (0,),
        "walk_owner": (0,),
    }  # fmt: skip
    assert empty["walk_steps"].dtype == np.int32 and TABLE.rows(empty) == []
