"""What every job can say of itself, whatever it computes: all that a record of it needs."""

from typing import Any, Protocol


class Job(Protocol):
    """A job of any kind."""

    @property
    def kind(self) -> str:
        """Name of its kind."""

    @property
    def digest(self) -> str:
        """Hash of what it asks for: equal digests, equal bytes."""

    @property
    def places(self) -> int:
        """Cells, or points of samples, that it computes."""

    def demand_quiet(self) -> None:
        """Refuse it where it has no quiet solution (Eq. 3): raises `OutsideDomain`."""

    def request(self) -> dict[str, Any]:
        """Request that asks for it, as JSON."""
