"""JSON objects that the API describes as requests for jobs, and that are checked elsewhere.

A body is checked by `service.answers.limits.job_from`, which knows the limits of the settings. The request of a job was
checked when it was submitted; it is sent as it was stored.
"""

from functools import reduce
from operator import or_
from typing import Annotated, Any

from pydantic import GetPydanticSchema, TypeAdapter
from pydantic_core import core_schema

from worker.jobs.job import Job
from worker.kinds import KINDS


def described_as(model: Any) -> Any:
    """Type of an unchecked JSON object that the API describes as a model.

    Parameters
    ----------
    model : type or union of types

    Returns
    -------
    type
    """
    described = TypeAdapter(model).core_schema
    # pydantic's own `SkipValidation` describes unchecked values in the same way.
    metadata = {"pydantic_js_annotation_functions": [lambda _schema, handler: handler(described)]}
    schema = core_schema.dict_schema(core_schema.str_schema(), core_schema.any_schema(), metadata=metadata)
    return Annotated[dict[str, Any], GetPydanticSchema(lambda _source, _handler: schema)]


def request_of_any_kind() -> Any:
    """Type of the request of a job of any kind."""
    classes: list[type[Job]] = [kind.job_class for kind in KINDS.values()]
    return described_as(reduce(or_, classes))
