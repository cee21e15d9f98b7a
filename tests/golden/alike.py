"""Answers compared: all that is no real number is the same, and real numbers agree to nine digits."""

import math


def differences(here, golden, place=""):
    """Where two answers differ, in words."""
    if isinstance(here, float) or isinstance(golden, float):
        return [] if _close(here, golden) else [f"{place}: {here} is not {golden}"]
    if isinstance(here, dict) and isinstance(golden, dict):
        pairs = ((name, here.get(name), golden.get(name)) for name in sorted(here.keys() | golden.keys()))
        return _each(pairs, place)
    if isinstance(here, list) and isinstance(golden, list) and len(here) == len(golden):
        return _each(zip(range(len(here)), here, golden, strict=True), place)
    return [] if here == golden else [f"{place}: {here!r} is not {golden!r}"]


def _each(pairs, place):
    return [told for name, here, golden in pairs for told in differences(here, golden, f"{place}.{name}")]


def _close(here, golden):
    numbers = isinstance(here, int | float) and isinstance(golden, int | float)
    return numbers and math.isclose(here, golden, rel_tol=1e-9, abs_tol=1e-11)
