"""Machines in their own units: what they are in the model, and one unit of it in SI."""

from functools import partial
from typing import Any

from fastapi import APIRouter

from service.models.machines import MachineView, machine_from
from service.models.requests import described_as
from service.routes.dependencies import ChecksHere, problems
from service.routes.plain_json import PlainJsonRoute
from worker.gear_pair import GearPair

router = APIRouter(prefix="/v1", tags=["submit"], route_class=PlainJsonRoute)
_BODY: Any = described_as(GearPair)


@router.post(
    "/machines",
    summary="Convert a machine",
    responses=problems(
        s400="malformed JSON", s413="body too large", s422="what is wrong with the machine, field by field"
    ),
)
async def convert(body: _BODY, checks: ChecksHere) -> MachineView:
    """Convert a gear pair in SI units, or in units of its own, to the model's oscillator; nothing is recorded.

    Each route that takes an `oscillator` takes the same object as `machine` in its place.
    """
    return await checks.run(partial(_converted, body))


def _converted(body: dict[str, Any]) -> MachineView:
    return MachineView.from_pair(machine_from(body))
