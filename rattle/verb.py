"""What a verb says of itself: its signature and its documentation, made from its arguments."""

import inspect
from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any, NamedTuple, TypeVar, get_args

from rattle.argument import Argument
from rattle.arguments import arguments_of
from worker.kinds import KINDS

_Call = TypeVar("_Call", bound=Callable[..., Any])
_DOCUMENTATION = """{summary}

Times count forcing periods; everything else is nondimensional.

Parameters
----------
{listed}

Returns
-------
xarray.Dataset
    {returns}
    Its accessor ``.rattle`` draws and measures it.

Raises
------
TypeError
    If an argument is unknown or missing.
ValueError
    If a value is wrong; the message says what would be right.

Examples
--------
>>> import rattle
{example}
"""


class Verb(NamedTuple):
    """A verb: its name, the kind of job that it computes, what it does, what comes back, and an example."""

    name: str
    kind: str
    summary: str
    returns: str
    example: str

    @property
    def arguments(self) -> list[Argument]:
        """Arguments that describe the job."""
        return arguments_of(KINDS[self.kind].job_class)


VERBS = (
    Verb(
        "basin", "basin", "Compute a basin of attraction: which motion each departure ends in.",
        "Cells over ``velocity`` and ``time``: ``solution``, Hsu's ``group``, ``period`` and ``step``, landing points; "
        "and the motions along ``attractor``, each with its ``share``.",
        ">>> basin = rattle.basin(damping=0.6, eccentricity=0.1, half_backlash=0.6, cells=20, progress=False)\n"
        ">>> basin.rattle.to_table()['name'].tolist()\n['permanent contact', 'P(1,1,0)', 'chaotic']",
    ),
    Verb(
        "sweep", "sweep",
        "Compute basins over one or two parameters. A list or an array is swept, or (start, stop, count).",
        "As of a basin, with a leading dimension for each swept parameter in the order of the arguments; births and "
        "deaths of motions along ``change``.",
        ">>> sweep = rattle.sweep(damping=[0.6, 0.7], eccentricity=0.1, half_backlash=0.6, cells=16, progress=False)\n"
        ">>> sweep.share.sel(damping=0.7).values[0].round(2).item()\n1.0",
    ),
    Verb(
        "bifurcation", "bifurcation",
        "Compute a bifurcation diagram over the parameter that has several values.",
        "Last departures ``time`` and ``velocity`` at each value, of each seed.",
        ">>> diagram = rattle.bifurcation(damping=(0.5, 0.6, 5), seeds=[(0.7641, 4.0002)], progress=False)\n"
        ">>> diagram.impact_period.values.ravel().tolist()[0]\n3",
    ),
    Verb(
        "orbits", "orbits",
        "Find periodic orbits, stable or not; follow them in a parameter and locate special points.",
        "Orbits along ``orbit``; branches and special points, if they are followed.",
        ">>> found = rattle.orbits(damping=0.6, longest=1, cells=8, progress=False)\n"
        ">>> 'P(1,1,0)' in found.name.values\nTrue",
    ),
    Verb(
        "manifolds", "manifold", "Grow stable and unstable manifolds of saddles of the impacting model.",
        "Saddles along ``orbit``, branches along ``branch``, their curves piece by piece.",
        ">>> grown = rattle.manifolds(damping=0.6, saddles=[(0.6017, 3.7699)], arclength=2, progress=False)\n"
        ">>> grown.name.values.tolist()\n['P(1,1,0)']",
    ),
    Verb(
        "grazing_curve", "grazing_curve", "Compute the grazing curve of the impacting model and its pre-images.",
        "Orders along ``order``, their curves piece by piece.",
        ">>> curves = rattle.grazing_curve(damping=0.6, order=1, progress=False)\n"
        ">>> curves.sizes['order']\n2",
    ),
)  # fmt: skip
"""The verbs that compute jobs."""


def described(call: _Call, name: str, summary: str, arguments: Sequence[Argument], returns: str, example: str) -> _Call:
    """Give a function the name, the signature and the documentation of a verb.

    Parameters
    ----------
    call : callable
        Takes keyword arguments.
    name, summary : str
    arguments : sequence of Argument
    returns : str
        What the dataset holds.
    example : str
        Lines of a doctest.

    Returns
    -------
    callable
        The same function.
    """
    own: Any = call
    own.__name__ = own.__qualname__ = name
    own.__signature__ = inspect.Signature([_parameter(each) for each in arguments])
    listed = "\n".join(f"{each.name} : {_type_of(each)}\n    {each.text}" for each in arguments)
    own.__doc__ = _DOCUMENTATION.format(summary=summary, listed=listed, returns=returns, example=example)
    return call


def _parameter(argument: Argument) -> inspect.Parameter:
    default = inspect.Parameter.empty if argument.default is ... else argument.default
    return inspect.Parameter(argument.name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=argument.kind)


def _type_of(argument: Argument) -> str:
    """Type as documentation says it."""
    kinds = [kind for kind in get_args(argument.kind) or (argument.kind,) if kind is not type(None)]
    if len(kinds) == 1 and isinstance(kinds[0], type) and issubclass(kinds[0], Enum):
        written = "{" + ", ".join(f'"{each.value}"' for each in kinds[0]) + "}"
    elif getattr(argument.kind, "__origin__", None) in (tuple, list, dict):
        written = str(argument.kind)
    else:
        written = " or ".join(getattr(kind, "__name__", str(kind)) for kind in kinds)
    return written if argument.default is ... else f"{written}, default {argument.default!s}"
