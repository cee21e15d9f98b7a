"""What a verification has found."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

_MOST_KEPT = 40


class Failure(NamedTuple):
    """One thing that was not proven again.

    Parameters
    ----------
    contradicted : bool
        Whether it was refuted; else it was neither proven nor refuted.
    place : str
        Which it is, and where.
    why : str
    """

    contradicted: bool
    place: str
    why: str


@dataclass
class Part:
    """One part of the theorem.

    Parameters
    ----------
    name : str
    of : int
        How many things there are to prove, of which a sample may be tried.
    tried, contradicted, undecided : int
    failures : list of Failure
        The first of them.
    earlier : int
        How many of those tried were tried by earlier runs of the same code on the same store.
    """

    name: str
    of: int = 0
    tried: int = 0
    contradicted: int = 0
    undecided: int = 0
    failures: list[Failure] = field(default_factory=list)
    earlier: int = 0

    @property
    def proven(self) -> int:
        """How many of those tried were proven again."""
        return self.tried - self.contradicted - self.undecided

    @property
    def holds(self) -> bool:
        """Whether all that were tried were."""
        return self.proven == self.tried

    def add(self, tried: int, failures: Iterable[Failure] = ()) -> None:
        """Count things that were tried, of which some failed."""
        self.tried += tried
        for failure in failures:
            self.contradicted += failure.contradicted
            self.undecided += not failure.contradicted
            if len(self.failures) < _MOST_KEPT:
                self.failures.append(failure)


def contradicted(place: str, why: str) -> Failure:
    """A thing that was refuted."""
    return Failure(True, place, why)


def undecided(place: str, why: str = "neither proven nor refuted") -> Failure:
    """A thing that was neither proven nor refuted."""
    return Failure(False, place, why)


@dataclass(frozen=True)
class Verification:
    """What has been proven again.

    Parameters
    ----------
    store : str
    parts : tuple of Part
        Of the theorem, in its order.
    """

    store: str
    parts: tuple[Part, ...]

    @property
    def holds(self) -> bool:
        """Whether all that was tried was proven again."""
        return all(part.holds for part in self.parts)
