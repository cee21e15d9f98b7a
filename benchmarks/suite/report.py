"""What a run of the suite writes down, and what it reads of others' runs: one JSON."""

import json
from collections.abc import Set
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, Field, ValidationError, computed_field

from benchmarks.suite.workloads import WORKLOADS

FORMAT = "gear-rattle benchmarks 1"


class UnusableRun(ValueError):
    """A file that is no run of the suite, or one of other inputs."""


class Measured(BaseModel):
    """What a method took."""

    cores: int = Field(ge=1, description="cores that it keeps busy")
    every: int = Field(ge=1, description="it took one in so many of the inputs, along each axis")
    units: int = Field(ge=1, description="units of work in a repetition")
    seconds: list[float] = Field(min_length=1, description="wall time of each repetition, nothing compiled in it")
    error: float = Field(ge=0.0, description="of its answer, against the known one")
    allowed: float = Field(ge=0.0, description="largest error of an answer that agrees")
    times_plain: float | None = Field(None, description="rate as a multiple of the plain method's in this run")

    @computed_field  # type: ignore[prop-decorator]
    @property
    def agrees(self) -> bool:
        """Whether the answer is right; the rate of a wrong one says nothing."""
        return self.error <= self.allowed

    @computed_field  # type: ignore[prop-decorator]
    @property
    def best(self) -> float:
        """Seconds of the fastest repetition."""
        return min(self.seconds)

    @computed_field  # type: ignore[prop-decorator]
    @property
    def units_per_second(self) -> float:
        """Of the fastest repetition."""
        return self.units / self.best


class Missing(BaseModel):
    """A method that did not run, and why."""

    not_installed: list[str] = Field(min_length=1, description="packages that it needs")


class Failed(BaseModel):
    """A method that began and ended with an error."""

    failed: str


class Results(BaseModel):
    """A workload, and what each method took."""

    definition: str
    unit: str
    sha256: str
    methods: dict[str, Measured | Missing | Failed]


class Run(BaseModel):
    """A run of the suite on one processor."""

    format: Literal["gear-rattle benchmarks 1"]
    date: str
    processor: str
    cores: int = Field(ge=1, description="cores that the run could use")
    python: str
    versions: dict[str, str] = Field(description="of the packages that the methods need")
    commit: str | None = Field(None, description="of the suite, with -dirty if something was not committed")
    workloads: dict[str, Results]

    @property
    def machine(self) -> str:
        """Processor, cores and date, as pictures and tables name a run."""
        return f"{self.processor}, {self.cores} core{'s' if self.cores > 1 else ''}, {self.date}"

    def measured(self, workload: str, method: str) -> Measured | None:
        """What a method took, None if it did not run or its answer is wrong."""
        found = self.workloads[workload].methods.get(method) if workload in self.workloads else None
        return found if isinstance(found, Measured) and found.agrees else None


def read_run(path: Path) -> Run:
    """Read a run.

    Raises
    ------
    UnusableRun
        Says what is wrong with the file.
    """
    try:
        return Run.model_validate(json.loads(path.read_text()))
    except OSError as error:
        raise UnusableRun(f"{path} cannot be read: {error.strerror}") from error
    except ValueError as error:
        if not isinstance(error, ValidationError):
            raise UnusableRun(f"{path} is not JSON: {error}") from error
        first = error.errors()[0]
        raise UnusableRun(
            f"{path} is no run of the suite: {'.'.join(map(str, first['loc'])) or 'all of it'}: {first['msg']}"
        ) from error


def check_same_inputs(workloads: Set[str], run: Run) -> None:
    """Refuse a run of other inputs: rates of different work do not compare.

    Parameters
    ----------
    workloads : set of str
        Names of those that count.
    run : Run

    Raises
    ------
    UnusableRun
        Names the workload.
    """
    for name in workloads & run.workloads.keys():
        if run.workloads[name].sha256 != WORKLOADS[name].sha256:
            raise UnusableRun(f"its inputs of {name!r} are not the suite's: their SHA-256 differ")
