"""JSON objects that the API describes as requests for jobs, and that are checked elsewhere.

A body is checked in threads of `service.answers.request_checks`: by `service.answers.limits.job_from`, which knows the
limits of the settings, or by `parsed`. The request of a job was
checked when it was submitted; it is sent as it was stored.
"""

from functools import reduce
from operator import or_
from typing import Annotated, Any, TypeVar

from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, GetPydanticSchema, TypeAdapter, ValidationError
from pydantic_core import core_schema

from worker.jobs.job import Job
from worker.kinds import KINDS

_Model = TypeVar("_Model", bound=BaseModel)


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


def parsed(model: type[_Model], body: dict[str, Any]) -> _Model:
    """A body that the API describes as a model, as that model.

    Parameters
    ----------
    model : type
    body : dict

    Returns
    -------
    BaseModel

    Raises
    ------
    RequestValidationError
        As if FastAPI had checked it.
    """
    try:
        return model.model_validate(body)
    except ValidationError as error:
        faults = error.errors(include_url=False)
        raise RequestValidationError([fault | {"loc": ("body", *fault["loc"])} for fault in faults]) from error


def request_of_any_kind() -> Any:
    """Type of the request of a job of any kind."""
    classes: list[type[Job]] = [kind.job_class for kind in KINDS.values()]
    return described_as(reduce(or_, classes))
