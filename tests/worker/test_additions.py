"""What packages add to basins is found by entry points, and models have its fields."""

from importlib.metadata import EntryPoint

import pytest
from pydantic import BaseModel, Field

from worker import additions as module
from worker.additions import Addition, additions, with_fields


class Model(BaseModel):
    """A model."""

    own: int


def test_fields_come_after_those_of_the_model_and_under_its_name():
    more = with_fields(Model, {"added": (float | None, Field(None, description="added"))})
    assert issubclass(more, Model) and list(more.model_fields) == ["own", "added"]
    assert (more.__name__, more.__module__, more.__doc__) == ("Model", __name__, "A model.")
    assert more(own=1).model_dump() == {"own": 1, "added": None}
    assert with_fields(Model, {}) is Model


@pytest.mark.parametrize("entry", ["json:loads", "worker.additions:Addition"])
def test_an_entry_that_is_no_addition_is_refused(monkeypatch, entry):
    monkeypatch.setattr(module, "entry_points", lambda group: [EntryPoint("another", entry, group)])
    with pytest.raises(ImportError, match=f"the addition another = {entry} is no Addition of that name"):
        additions.__wrapped__()


def test_an_addition_of_another_name_is_refused(monkeypatch):
    (known, *_) = additions()
    assert isinstance(known, Addition)
    found = EntryPoint("another", "worker.additions:KNOWN", module.GROUP)
    monkeypatch.setattr(module, "KNOWN", known, raising=False)
    monkeypatch.setattr(module, "entry_points", lambda group: [found])
    with pytest.raises(ImportError, match="is no Addition of that name"):
        additions.__wrapped__()
