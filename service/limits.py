"""Requests that are too large are refused before anything is done that takes time in proportion to them."""

from rattle_kernels import expected_applications
from service.errors import LimitExceeded
from service.models import BasinRequest, SweepRequest
from service.settings import Settings


def check_size(request: BasinRequest, settings: Settings) -> None:
    """Refuse a request that exceeds a limit.

    Raises
    ------
    LimitExceeded
        Naming the limit, by its setting.
    """
    cells, basins = request.places, request.basins if isinstance(request, SweepRequest) else 1
    iterations = request.k
    # Where damping is weak, no cell takes all of them.
    each = expected_applications(request.least_damping, min(iterations, settings.max_iterations))
    applications = round(cells * each)
    for what, size, limit in (
        ("cells or points", cells, "max_cells"),
        ("iterations", iterations, "max_iterations"),
        ("cells times iterations", applications, "max_applications"),
        ("basins", basins, "max_basins"),
        ("cells times iterations of all basins", basins * applications, "max_sweep_applications"),
    ):
        most = getattr(settings, limit)
        if size > most:
            raise LimitExceeded(f"{size} {what} are more than the limit of {most} (RATTLE_{limit.upper()})")
