"""JSON objects that the API describes as requests for jobs, and that are checked elsewhere.

A body is checked in threads of `service.answers.request_checks`: by `service.answers.limits.job_from`, which knows the
limits of the settings, or by `parsed`. The request of a job was
checked when it was submitted; it is sent as it was stored.
"""

from functools import reduce
from operator import or_
from typing import Annotated, Any, TypeVar

from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, GetJsonSchemaHandler, GetPydanticSchema, TypeAdapter, ValidationError
from pydantic_core import core_schema

from service.models.machines import in_model
from worker.gear_pair import MACHINE
from worker.jobs.job import Job
from worker.kinds import KINDS

_Model = TypeVar("_Model", bound=BaseModel)
_WITH_A_MACHINE = {
    "type": "object",
    "title": "WithMachine",
    "description": "The same with a machine in its own units in place of `oscillator`",
    "required": [MACHINE],
    "properties": {MACHINE: {"type": "object", "description": "As the body of `POST /v1/machines`"}},
    "not": {"required": ["oscillator"]},
}


def described_as(model: Any, *, machine: bool = False) -> Any:
    """Type of an unchecked JSON object that the API describes as a model.

    Parameters
    ----------
    model : type or union of types
    machine : bool
        Whether the object may have a machine in place of its oscillator (`service.models.machines.in_model`).

    Returns
    -------
    type
    """
    described = TypeAdapter(model).core_schema
    # pydantic's own `SkipValidation` describes unchecked values in the same way.

    def describe(_schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        schema = handler(described)
        return {"anyOf": [schema, _WITH_A_MACHINE]} if machine else schema

    metadata = {"pydantic_js_annotation_functions": [describe]}
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
    InvalidJob
        If a machine is at fault.
    """
    try:
        return model.model_validate(in_model(body, model))
    except ValidationError as error:
        faults = error.errors(include_url=False)
        raise RequestValidationError([fault | {"loc": ("body", *fault["loc"])} for fault in faults]) from error


def request_of_any_kind() -> Any:
    """Type of the request of a job of any kind."""
    classes: list[type[Job]] = [kind.job_class for kind in KINDS.values()]
    return described_as(reduce(or_, classes))
