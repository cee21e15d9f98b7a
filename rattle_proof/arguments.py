"""A proof as it is asked for by the arguments of a verb, and by options of the shell."""

from collections.abc import Sequence
from typing import Any

from worker.additions import TextOption
from worker.errors import InvalidJob
from worker.jobs.swept_parameter import is_parameter


def with_middles(values: dict[str, Any]) -> dict[str, Any]:
    """Parameters that are a pair where a proof is asked for are tolerances: the oscillator is in their middle."""
    pairs = {
        name: tuple(value) for name, value in values.items() if is_parameter(name) and isinstance(value, list | tuple)
    }
    if values.get("prove") is not True or any(len(pair) != 2 for pair in pairs.values()):
        return values
    middles = {name: 0.5 * (low + high) for name, (low, high) in pairs.items()}
    tolerances = pairs | (values.get("tolerances") or {})
    return values | middles | ({"tolerances": tolerances} if tolerances else {})


def prove_of(values: dict[str, Any]) -> Any:
    """The field of a request; its arguments are taken out."""
    beside = {name: values.pop(name) for name in ("levels", "tolerances") if name in values}
    proof = values.pop("prove", False)
    if proof is False:
        for name in beside:
            raise InvalidJob(f"{name} belongs to a proof: give prove=True (--prove)", (name,))
        return None
    return beside if proof is True else proof


def _tolerance(text: str) -> tuple[str, tuple[float, float]]:
    name, _, ends = text.partition("=")
    try:
        least, greatest = map(float, ends.split(":"))
    except ValueError as error:
        raise InvalidJob(f"--tolerance {text}: write between which values, damping=0.59:0.61") from error
    return name.replace("-", "_"), (least, greatest)


def _tolerances(texts: Sequence[str]) -> dict[str, Any]:
    return {"tolerances": dict(map(_tolerance, texts))}


TOLERANCES = TextOption(
    "tolerance", "damping=0.59:0.61, of a proof: it holds for every machine within; several", _tolerances
)
