"""Arguments that name an oscillator of either model."""

from pathlib import Path
from typing import Any

from rattle.argument import Argument, Group, Values, is_swept, of_part
from rattle.measured_curve import transmission_error
from rattle_kernels import TransmissionError
from worker.errors import InvalidJob
from worker.jobs.oscillator_request import (
    BOTH_FORCINGS,
    PIECEWISE_LINEAR,
    ImpactingOscillator,
    PiecewiseLinearOscillator,
)
from worker.jobs.swept_parameter import is_of_harmonic

_HARMONICS = (
    "(order, amplitude, phase) of each harmonic of the forcing beside the first; phases count periods of the harmonic. "
    "Several values of amplitude_2 or phase_2 sweep those of order 2"
)
_MEASURED = (
    "A measured curve in place of eccentricity and harmonics: what `rattle.transmission_error` returns, or a CSV file "
    "of angle (in turns) and error"
)
_FOREIGN = {
    False: ("piecewise linear model", "give a stiffness"),
    True: ("impacting model", "leave out the stiffness, or give contact_damping"),
}


def oscillator_group(impacting_only: bool = False, sweeps: bool = False) -> Group:
    """Arguments that name an oscillator.

    Parameters
    ----------
    impacting_only : bool
        Whether only the impacting model can be computed.
    sweeps : bool
        Whether a parameter may have several values.

    Returns
    -------
    Group
    """
    impacting, stiff = ImpactingOscillator, PiecewiseLinearOscillator
    arguments = [of_part(impacting, name) for name in ("damping", "eccentricity", "half_backlash")]
    of_impacts = [of_part(impacting, "restitution")]
    of_contacts = [of_part(stiff, name) for name in ("contact_damping", "permanent_contact", "allow_no_quiet_solution")]
    if not impacting_only:
        arguments.append(Argument("stiffness", float | None, None, "kappa; without it, the impacting model"))
    arguments.append(Argument("harmonics", list[tuple[float, ...]] | None, None, _HARMONICS))
    arguments.append(Argument("transmission_error", TransmissionError | str | Path | None, None, _MEASURED))
    arguments += of_impacts if impacting_only else of_impacts + of_contacts
    names = [each.name for each in arguments if each.name not in ("harmonics", "transmission_error")]

    def read(given: Values) -> dict[str, Any]:
        given = _measured_as_harmonics(given)
        own = {name: given[name] for name in names if given.get(name) is not None}
        request = {name: value for name, value in own.items() if not is_swept(value)}
        harmonics = _harmonics(given)
        if len(request) < len(own) and not sweeps:
            several = next(name for name in own if name not in request)
            others = "a sweep takes several values, and a proof (prove=True) a tolerance"
            raise InvalidJob(f"{several} has one value here; {others}", (several,))
        foreign, belongs = _FOREIGN["stiffness" in own]
        for argument in of_impacts if "stiffness" in own else of_contacts:
            if own.get(argument.name, argument.default) != argument.default:
                raise InvalidJob(f"{argument.name} belongs to the {foreign}: {belongs}", (argument.name,))
            request.pop(argument.name, None)
        return request | harmonics | ({"model": PIECEWISE_LINEAR} if "stiffness" in own else {})

    return Group(tuple(arguments), read)


def _measured_as_harmonics(given: Values) -> Values:
    """The same arguments with eccentricity and harmonics of a measured curve; an eccentricity that is swept stays."""
    measured = given.get("transmission_error")
    if measured is None:
        return given
    eccentricity = given.get("eccentricity")
    if given.get("harmonics") is not None or not (eccentricity is None or is_swept(eccentricity)):
        raise InvalidJob(BOTH_FORCINGS, ("transmission_error",))
    if not isinstance(measured, TransmissionError):
        measured = transmission_error(measured)
    swept = {} if eccentricity is None else {"eccentricity": eccentricity}
    return {**given, **measured.forcing, **swept}


def _harmonics(given: Values) -> dict[str, Any]:
    """Harmonics of a request; one number of theirs that is not swept is refused, as it is one of theirs already."""
    for name, value in given.items():
        if is_of_harmonic(name) and not is_swept(value):
            raise InvalidJob(f"{name} has one value: write it into harmonics; several values are swept", (name,))
    harmonics = given.get("harmonics")
    if harmonics is None:
        return {}
    if not isinstance(harmonics, list | tuple):
        raise InvalidJob(f"harmonics are a list of (order, amplitude, phase), not {harmonics!r}", ("harmonics",))
    written = []
    for each in harmonics:
        parts = each if isinstance(each, list | tuple) else [each]
        if not 2 <= len(parts) <= 3:
            raise InvalidJob(f"a harmonic is (order, amplitude, phase), not {each!r}", ("harmonics",))
        order = int(parts[0]) if isinstance(parts[0], float) and parts[0].is_integer() else parts[0]
        written.append(dict(zip(("order", "amplitude", "phase"), (order, *parts[1:]), strict=False)))
    return {"harmonics": written}
