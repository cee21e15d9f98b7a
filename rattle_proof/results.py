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
    )
}  # fmt: skip
OUTLINE_FIELDS: Fields = {
    "proof": (
        bool,
        Field(
            False, exclude_if=lambda there: not there,
            description="Whether a proof was asked for, so that tiles say what is proven; left out where not",
        ),
    )
}  # fmt: skip


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
    shares = certificate.get("shares", [np.nan] * dataset.sizes["attractor"])
    proven = xr.DataArray(shares, dims=["attractor"], attrs={"long_name": "share of the plane proven to end in it"})
    return dataset.assign(share_proven=proven).assign_attrs(certificate=certificate)


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
    if "certificate" not in dataset.attrs:
        raise InvalidJob("nothing is proven of this basin: compute it with prove=True", ("prove",))
    found: dict[str, Any] = json.loads(dataset.attrs["certificate"])
    return found


def crate_files(dataset: xr.Dataset) -> Iterator[tuple[str, bytes, str, str]]:
    """The certificate as a file of an exported result."""
    if told := dataset.attrs.get("certificate"):
        text = json.dumps(json.loads(told), indent=1)
        yield "certificate.json", text.encode(), "application/json", "Certificate of the proof"
