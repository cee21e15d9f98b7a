"""How far one application of P is from the reference: what stands beside every rate."""

from tests.rattle_kernels.reference import entries, oscillator_of, phase_error, speed_error

# What is further off is not the map, and its rate says nothing.
_WORTH_TIMING = 1e-9


def largest_error(apply, table="map_impacting.json", category="paper"):
    """Largest error of phase and speed over one category of a reference table.

    ``apply(oscillator, t, v)`` answers with the next departure's phase and speed.
    """
    errors = [0.0]
    for entry in entries(table):
        if entry["category"] == category and entry.get("outcome", "map") == "map":
            t, v = apply(oscillator_of(entry), float(entry["t0"]), float(entry["v0"]))
            errors += [phase_error(float(t) % 1.0, entry["t1"]), speed_error(float(v), entry["v1"])]
    return max(errors)


def record(benchmark, applications, apply=None, **table):
    """Put the rate beside the time, and the accuracy beside the rate."""
    benchmark.extra_info["applications"] = applications
    benchmark.extra_info["million_per_second"] = applications / benchmark.stats.stats.min / 1e6
    if apply is not None:
        benchmark.extra_info["largest_error"] = largest_error(apply, **table)
        assert benchmark.extra_info["largest_error"] < _WORTH_TIMING
