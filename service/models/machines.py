"""A machine in its own units, in place of the oscillator of a request; and what the service says of one."""

from typing import Any

from pydantic import BaseModel, Field, TypeAdapter

from rattle_kernels import settled_iterations
from worker.errors import InvalidFields, InvalidJob
from worker.gear_pair import MACHINE, GearPair
from worker.jobs.oscillator_request import ImpactingOscillator, OscillatorRequest, PiecewiseLinearOscillator
from worker.precision_limits import fastest_of
from worker.results.summary import FiniteOrNone

_OSCILLATOR: TypeAdapter[Any] = TypeAdapter(OscillatorRequest)


class ScalesView(BaseModel):
    """One unit of the model in SI units."""

    time: float = Field(description="A forcing period, s")
    length: float = Field(description="Of displacements, the half backlash and the eccentricity, m")
    speed: float = Field(description="Of velocities, along the line of action, m/s")
    mass: float = Field(description="Of the pair, seen along the line of action, kg")
    energy: float = Field(description="Of v^2/2, J")
    power: float = Field(description="Of impact power, W")
    impulse: float = Field(description="Torque pulse on the driven shaft that changes the velocity by 1, N m s")


class MachineView(BaseModel):
    """A machine in the model, and back."""

    machine: dict[str, Any] = Field(description="Its numbers in SI units")
    oscillator: ImpactingOscillator | PiecewiseLinearOscillator = Field(description="In the model, as requests have it")
    velocity_stop: float = Field(description="Velocity up to which a window reaches by default")
    iterations: int = Field(description="k of a settled picture")
    scales: ScalesView
    gamma: float = Field(
        description="Inertia torque over drag torque; from 1 on impacts part the teeth in every turn (Eq. 8)"
    )
    threshold_speed: FiniteOrNone = Field(description="Speed at which gamma reaches 1, rad/s; null if it never does")
    can_be_quiet: bool = Field(description="Whether some motion keeps the teeth together (Eq. 8, or 3)")

    @classmethod
    def from_pair(cls, pair: GearPair) -> "MachineView":
        """View of a machine."""
        return cls(
            machine=pair.as_request, oscillator=_oscillator_of(pair),
            velocity_stop=fastest_of(pair.oscillator), iterations=settled_iterations(pair.oscillator.damping),
            scales=ScalesView(**pair.scales._asdict()), gamma=pair.gamma,
            threshold_speed=pair.threshold_speed, can_be_quiet=pair.can_be_quiet,
        )  # fmt: skip


def machine_from(value: Any, *path: str) -> GearPair:
    """Machine that JSON describes.

    Parameters
    ----------
    value : object
    *path : str
        Where it stands in the request.

    Returns
    -------
    GearPair

    Raises
    ------
    InvalidJob
        Naming the field at fault.
    """
    if not isinstance(value, dict):
        raise InvalidJob("a machine is an object, as POST /v1/machines takes it", path)
    try:
        return GearPair(**value)
    except InvalidFields as error:
        raise InvalidFields([((*path, *place), message) for place, message in error.faults]) from None
    except InvalidJob as error:
        raise InvalidJob(str(error), (*path, *error.place)) from None


def in_model(body: dict[str, Any], model: type[BaseModel]) -> dict[str, Any]:
    """A request with the oscillator of its machine, and with a window that follows it if none is given.

    Parameters
    ----------
    body : dict
        Request as JSON.
    model : type
        Of the request.

    Returns
    -------
    dict
        The body itself if it has no machine, or has its oscillator already. The machine stays in it if the model has a
        field for it, its numbers in SI.

    Raises
    ------
    InvalidJob
        If the machine is none.
    """
    if body.get(MACHINE) is None:
        return body
    fields = {field.alias or name for name, field in model.model_fields.items()}
    if "oscillator" in body:
        if MACHINE not in fields:
            raise InvalidJob("give the machine or the oscillator, not both: one follows from the other", (MACHINE,))
        return body
    pair = machine_from(body[MACHINE], MACHINE)
    request = {name: value for name, value in body.items() if name != MACHINE}
    if MACHINE in fields:
        request[MACHINE] = pair.as_request
    for window in fields & {"grid", "region"}:
        inside = request.get(window, {})
        if isinstance(inside, dict) and "velocity" not in inside:
            request[window] = inside | {"velocity": {"start": 0.0, "stop": fastest_of(pair.oscillator)}}
        elif window == "grid" and isinstance(inside, dict) and isinstance(inside["velocity"], dict):
            request[window] = inside | {"velocity": {"stop": fastest_of(pair.oscillator)} | inside["velocity"]}
    return request | {"oscillator": _oscillator_of(pair).model_dump(mode="json")}


def _oscillator_of(pair: GearPair) -> Any:
    return _OSCILLATOR.validate_python(pair.oscillator).settled({}, quiet=pair.can_be_quiet)
