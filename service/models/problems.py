"""Errors over HTTP."""

from pydantic import BaseModel, Field


class FieldError(BaseModel):
    """One field at fault."""

    location: list[str | int] = Field(examples=[["body", "oscillator", "damping"]])
    message: str


class Problem(BaseModel):
    """An error, as RFC 9457 has it (application/problem+json)."""

    type: str = Field(examples=["/problems/invalid-request"])
    title: str
    status: int
    detail: str
    instance: str
    errors: list[FieldError] = []
