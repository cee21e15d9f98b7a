"""What results of analyses have in common over HTTP."""

from typing import Any

from pydantic import BaseModel, Field


class AnalysisView(BaseModel):
    """What all results of analyses have, complete or not."""

    complete: bool
    request: dict[str, Any]
    pieces_done: int = Field(description="Pieces that are done and not yet assembled; 0 when complete")
    seconds: dict[str, float] = Field(description="Time of the kernels in each stage, summed over pieces")
    zarr: str
