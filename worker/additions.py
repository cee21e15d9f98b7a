"""What packages add to basins: more that a request may ask of the cells, beside their labels.

An addition has a field of its own in the requests of basins, arrays of its own in their stores, and work of its own
once the labels are written. Whatever needs to be known of every addition is asked of its `Addition`: requests, stores,
checks, pictures, routes and commands ask for all that are installed, and name none ::

    [project.entry-points."rattle.additions"]
    impact_counts = "impact_counts.addition:ADDITION"

The module that is named there loads neither Numba nor Dask, since every command loads it; the methods load what they
need. Workers need the package as well.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from pydantic import BaseModel

GROUP = "rattle.additions"
"""Group of the entry points by which packages add to basins."""
Fields = dict[str, tuple[Any, Any]]
"""Fields of a pydantic model by name: the type of each, and what `pydantic.Field` makes."""


class Cost(NamedTuple):
    """What is needed at most: seconds of one core, and bytes of a store before compression."""

    seconds: float
    bytes: int


class TextOption(NamedTuple):
    """An option of the shell that is written as text, several times: its name, its help, and how texts are read."""

    option: str
    help: str
    read: Callable[[Sequence[str]], dict[str, Any]]


class Mask(ABC):
    """A layer over the cells of a basin, drawn from one of the addition's arrays: an overlay of pictures."""

    @property
    @abstractmethod
    def variable(self) -> Any:
        """Array that is drawn, a `worker.stores.layout.Variable`."""

    @abstractmethod
    def demand(self, there: bool) -> None:
        """Refuse to draw what was not asked for, as an `InvalidJob`."""

    @abstractmethod
    def share(self, values: Iterable[Any]) -> float | None:
        """Share of a basin that is marked, from the array part by part; None for parts that are not there yet."""

    @abstractmethod
    def draw(self, axes: Any, values: Any, extent: tuple[float, float, float, float], share: float | None) -> None:
        """Draw a part of the array over cells, and keep the share for a legend."""

    @abstractmethod
    def legend(self, axes: Any) -> list[Any]:
        """Entries of the legend of axes on which it is drawn."""


class Addition(ABC):
    """What a package adds to basins. Stores are of type `worker.stores.basin_store.BasinStore`."""

    name: str
    """Field of a request that asks for it; what it holds is None where it is not asked for."""
    stages: tuple[str, ...]
    """What it does at the moment, as progress tells it: values of `worker.progress.Stage`."""
    overlay: str
    """Name of its mask among the overlays of pictures."""

    def asked_of(self, job: Any) -> bool:
        """Whether a job asks for it."""
        return getattr(job, self.name, None) is not None

    @abstractmethod
    def field(self) -> tuple[Any, Any]:
        """Type of its field in a request, and what `pydantic.Field` makes."""

    @abstractmethod
    def check(self, job: Any, large: bool) -> Any:
        """What a job asks, in canonical form; `large` if its cells have levels. Raises InvalidJob, OutsideDomain."""

    @abstractmethod
    def cost(self, job: Any) -> Cost:
        """What it needs for a job that asks for it."""

    @abstractmethod
    def arrays(self) -> tuple[Any, ...]:
        """Its arrays with a value for each cell, written tile by tile: each a `worker.stores.layout.Variable`."""

    @abstractmethod
    def run(self, store: Any, attractors: tuple[Any, ...]) -> Any:
        """Work on a basin whose tiles have their solutions, a `worker.run.Run`."""

    @abstractmethod
    def read_tile(self, store: Any, tile: Any) -> tuple[Any, ...]:
        """Read its arrays of a tile; nothing until all are written, or where it was not asked for."""

    @abstractmethod
    def owns(self, path: str) -> bool:
        """Whether an array or a group of a store is its own."""

    @abstractmethod
    def invalidate(self, store: Any, paths: Sequence[str]) -> None:
        """Forget what rests on its own arrays that are damaged; the store is made unfinished."""

    @abstractmethod
    def opened(self, dataset: Any, open_group: Callable[[str], Any]) -> Any:
        """A store as a dataset, with what its groups say of the basin; FileNotFoundError if there is no such group."""

    @abstractmethod
    def mask(self) -> Mask:
        """Its layer over the cells."""

    @abstractmethod
    def solution_fields(self) -> Fields:
        """Fields of its own in the summary of each solution. They are left out where there is nothing to say."""

    @abstractmethod
    def of_solutions(self, store: Any) -> Iterable[dict[str, Any]]:
        """Values of these fields for each solution, by number; nothing until they are known."""

    @abstractmethod
    def outline_fields(self) -> Fields:
        """Fields of its own in the outline of a basin."""

    @abstractmethod
    def of_outline(self, store: Any) -> dict[str, Any]:
        """Values of these fields."""

    @abstractmethod
    def page(self) -> dict[str, Any]:
        """What the page says of it, as ``Addition`` of ``service/explorer/types.d.ts``."""

    @abstractmethod
    def routes(self) -> Any:
        """Routes of its own, a `fastapi.APIRouter`."""

    of_tiles: str
    """What the description of a route says of its arrays in tiles."""

    on_pairs: str
    """What a parameter that is a pair may mean for it, as a refusal says it."""

    @abstractmethod
    def with_values(self, arguments: dict[str, Any]) -> dict[str, Any]:
        """Arguments of a verb, in which parameters have one value where a pair has a meaning of its own."""

    @abstractmethod
    def from_arguments(self, arguments: dict[str, Any]) -> Any:
        """Its field from the arguments of a verb, which it takes out; None if it is not asked for."""

    @abstractmethod
    def text_options(self) -> dict[str, TextOption]:
        """Options that are written as text, by the argument that they stand for."""

    @abstractmethod
    def least(self) -> dict[str, int]:
        """The least values of arguments, as the shell's help says them."""

    @abstractmethod
    def in_words(self, solution: Mapping[str, Any]) -> str:
        """What the shell's table says of a solution beside its share."""

    @abstractmethod
    def below_shares(self, dataset: Any) -> list[str]:
        """A line below the share of each solution in a picture's legend; nothing where there is none to say."""

    @abstractmethod
    def results(self) -> dict[str, Callable[[Any], Any]]:
        """Attributes of ``dataset.rattle``, by name: each is made of a dataset."""

    @abstractmethod
    def crate_files(self, dataset: Any) -> Iterator[tuple[str, bytes, str, str]]:
        """Files of its own in an exported result: path, content, media type, and what each is."""


def with_fields(model: type["BaseModel"], fields: Fields) -> Any:
    """Model with more fields, after its own and under its own name; the same model where there are none.

    Type checkers are told that it is the model itself: which fields there are is known only where packages are.
    """
    if not fields:
        return model
    from pydantic import create_model

    more: Any = fields
    return create_model(model.__name__, __base__=model, __module__=model.__module__, __doc__=model.__doc__, **more)


@cache
def additions() -> tuple[Addition, ...]:
    """All additions that are installed, by name.

    Raises
    ------
    ImportError
        If one cannot be loaded.
    """
    found = []
    for entry in sorted(entry_points(group=GROUP), key=lambda entry: entry.name):
        addition = entry.load()
        if not isinstance(addition, Addition) or addition.name != entry.name:
            raise ImportError(f"the addition {entry.name} = {entry.value} is no Addition of that name")
        found.append(addition)
    return tuple(found)


def asked_of(job: Any) -> list[Addition]:
    """Additions that a job asks for."""
    return [each for each in additions() if each.asked_of(job)]
