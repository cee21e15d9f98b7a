"""A small basin store with its proof, written as the stores' layout says: straight from the kernels."""

import numpy as np

from rattle_proof.enclosures.cells import prove_cells
from rattle_proof.enclosures.growth import empty_trails, follow_boxes, grow_all, never_quiet
from rattle_proof.enclosures.lattice import UNPROVEN, refined
from rattle_proof.enclosures.machine import machine_of
from rattle_proof.enclosures.targets import NOTHING_KNOWN, RATTLES, prove_targets
from worker.stores import layout
from worker.stores.basin_store import BasinStore
from worker.stores.new_store import consolidate, create_array
from worker.stores.opening import open_group

_CHUNK = 1024


def prove_store(location, columns=1024, lattices=1, levels=0, tolerances=None):
    """Prove a complete store of one basin, and write what is proven into it."""
    store = BasinStore(location)
    oscillator, grid = store.job.oscillator, store.job.grid
    (solution,) = store.read_whole((layout.SOLUTION,))
    table = store.solutions.read()
    attractors = store.solutions.read_catalogue(0, table, range(len(table.motions)))
    machine = machine_of(oscillator, tolerances)
    certificate = prove_targets(machine, oscillator, attractors, fastest=grid.velocity_stop, columns=columns)
    targets, rounds = grown(machine, oscillator, certificate.targets, lattices)
    cells = prove_cells(
        machine, oscillator, targets, grid, (0, grid.velocity_cells), (0, grid.time_cells), solution,
        len(attractors), levels,
    )  # fmt: skip
    tile = store.tiling.tile_rows, store.tiling.tile_columns
    variables = layout.PROVEN, layout.NEVER_QUIET, layout.UNPROVEN_REASON
    for variable, values in zip(variables, cells, strict=True):
        create_array(store._group, store.job, variable, grid.shape, tile)[...] = values
    _write(location, certificate, machine, targets, rounds, [each.name for each in attractors], attractors)
    consolidate(location)
    return cells


def grown(machine, oscillator, targets, lattices):
    """The lattice grown, so often refined; and the rounds."""
    rounds = np.zeros_like(targets.lattice.ends)
    for n in range(lattices):
        lattice = targets.lattice
        if n:
            lattice, rounds = refined(lattice), rounds.repeat(2, 0).repeat(2, 1)
            targets = targets._replace(lattice=lattice)
        boxes = np.argwhere(lattice.ends == UNPROVEN).astype(np.int32)
        ends, trails = np.zeros(len(boxes), np.uint16), empty_trails(len(boxes))
        follow_boxes(machine, oscillator, targets, boxes, ends, trails)
        rattles = ends == RATTLES
        ends[rattles] = UNPROVEN
        # They come to boxes of rounds before.
        rounds[tuple(boxes[ends != UNPROVEN].T)] = rounds.max() + 1
        lattice.ends[tuple(boxes.T)] = ends
        grow_all(lattice.ends, rounds, boxes, trails)
    rattling = never_quiet(lattice.ends, targets.quiet, boxes[~rattles], trails[~rattles])
    return targets._replace(never_quiet=lattice._replace(ends=rattling)), rounds


def _write(location, certificate, machine, targets, rounds, names, attractors):
    lattice, rattling = targets.lattice, targets.rattling
    quiet = [n for n, each in enumerate(attractors) if each.name == "permanent contact"]
    told = {
        "machine": {
            name: list(getattr(machine, name)) for name in ("damping", "half_backlash", "restitution")
        } | {"harmonics": machine.harmonics.tolist()},
        "motions": names,
        "quiet": {"motion": quiet[0], "level": certificate.level} if quiet else None,
        "discs": [
            {"motion": n, "impacts": d.impacts, "t": d.t, "v": d.v, "frame": d.frame.tolist(), "radius": d.radius}
            for n, d in certificate.discs.items()
        ],
        "rattling": None if rattling is NOTHING_KNOWN else {
            "motion": certificate.rattling, "height": rattling.height, "first": rattling.first,
            "columns": rattling.ends.shape[1],
        },
        "lattice": {
            "height": lattice.height, "first": lattice.first, "columns": lattice.ends.shape[1],
            "rows": lattice.ends.shape[0],
        },
        "impacts": {"trail": 4, "cell": 12},
    }  # fmt: skip
    group = open_group(location, "r+").create_group("proof", attributes={"certificate": told})
    arrays = {"ends": lattice.ends, "rounds": rounds, "never_quiet": targets.never_quiet.ends.astype(np.uint8)}
    if rattling is not NOTHING_KNOWN:
        arrays["rattling"] = (rattling.ends != UNPROVEN).astype(np.uint8)
    for name, values in arrays.items():
        group.create_array(name, shape=values.shape, dtype=values.dtype, chunks=(_CHUNK, _CHUNK))[...] = values
