"""What a result says of its proof: in datasets, summaries and outlines, and in an exported file."""

import json
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import xarray as xr
from pydantic import Field

from rattle_proof.layout import PROOF, PROVEN
from worker.additions import Fields
from worker.errors import InvalidJob

SOLUTION_FIELDS: Fields = {
    "share_proven": (
        float | None,
        Field(
            None, exclude_if=lambda share: share is None,
            description="Part of the plane that is proven to end in it; left out where no proof has ended",
        ),
    ),
    "share_at_most": (
        float | None,
        Field(
            None, exclude_if=lambda share: share is None,
            description="Part of the plane that is not proven to end otherwise; left out where no proof has ended",
        ),
    ),
}  # fmt: skip
OUTLINE_FIELDS: Fields = {
    "proof": (
        bool,
        Field(
            False, exclude_if=lambda there: not there,
            description="Whether a proof was asked for, so that tiles say what is proven; left out where not",
        ),
    ),
    "share_bounds": (
        list[tuple[float, float]],
        Field(
            [], exclude_if=lambda bounds: not bounds,
            description="Between which bounds the share of each solution is proven to lie; left out until it is",
        ),
    ),
}  # fmt: skip


def shares_of(certificate: dict[str, Any] | None) -> list[tuple[float, float]]:
    """Between which bounds the share of the plane lies that ends in each motion; none until the proof has ended.

    What is proven of a motion is its share at least. It is at most what is not proven of any other; that of what falls
    quiet is at most what is not proven to rattle, too.

    Parameters
    ----------
    certificate : dict or None

    Returns
    -------
    list of (float, float)
        By the numbers of the motions.
    """
    shares = [] if certificate is None else certificate.get("shares", [])
    if certificate is None or not shares:
        return []
    most = [1.0 - sum(other for m, other in enumerate(shares) if m != n) for n in range(len(shares))]
    if certificate["quiet"] is not None:
        quiet = certificate["quiet"]["motion"]
        most[quiet] = min(most[quiet], 1.0 - certificate.get("never_quiet", 0.0))
    return list(zip(shares, most, strict=True))


def with_proof(dataset: xr.Dataset, open_group: Callable[[str], xr.Dataset]) -> xr.Dataset:
    """The dataset with the certificate of its proof as an attribute, and the proven share of each motion."""
    if PROVEN.name not in dataset.data_vars:
        return dataset
    try:
        certificate = open_group(PROOF).attrs.get("certificate")
    except FileNotFoundError:
        certificate = None
    if certificate is None:
        return dataset
    shares = shares_of(certificate) or [(np.nan, np.nan)] * dataset.sizes["attractor"]
    least, most = np.array(shares).reshape(-1, 2).T
    return dataset.assign(
        share_proven=("attractor", least, {"long_name": "share of the plane proven to end in it"}),
        share_at_most=("attractor", most, {"long_name": "share of the plane not proven to end otherwise"}),
    ).assign_attrs(certificate=certificate)


def bounds_in_words(least: float, most: float) -> str:
    """Between which bounds a share is proven to lie."""
    return f"proven: {100.0 * least:.2f} % to {100.0 * most:.2f} %"


def certificate_in(dataset: xr.Dataset) -> dict[str, Any] | None:
    """The certificate of an opened basin; None where nothing is proven."""
    return json.loads(dataset.attrs["certificate"]) if "certificate" in dataset.attrs else None


def certificate(dataset: xr.Dataset) -> dict[str, Any]:
    """What a basin is proven from: constants of its targets, counts, and the proven share of each motion.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a basin. ``dataset.rattle.certificate`` is the same.

    Returns
    -------
    dict

    Raises
    ------
    InvalidJob
        If no proof was asked for, or it has not begun.

    Examples
    --------
    >>> import rattle
    >>> basin = rattle.basin(cells=8, prove=True, levels=0, progress=False)
    >>> basin.rattle.certificate["quiet"]["level"] > 0.09
    True
    """
    found = certificate_in(dataset)
    if found is None:
        raise InvalidJob("nothing is proven of this basin: compute it with prove=True", ("prove",))
    return found


def crate_files(dataset: xr.Dataset) -> Iterator[tuple[str, bytes, str, str]]:
    """The certificate as a file of an exported result."""
    if told := dataset.attrs.get("certificate"):
        text = json.dumps(json.loads(told), indent=1)
        yield "certificate.json", text.encode(), "application/json", "Certificate of the proof"
