"""Compile, or load from the disk cache, every kernel that the service needs: done once before work arrives."""

import numpy as np

from rattle_kernels.attractor_search import find_attractors
from rattle_kernels.cell_grid import CellGrid
from rattle_kernels.cell_groups import find_groups, label_cells
from rattle_kernels.cell_map import map_cells
from rattle_kernels.grazing_curve import grazing_velocity
from rattle_kernels.grazing_preimages import grazing_preimages
from rattle_kernels.image_set import has_members, mark_images, place_images, unite
from rattle_kernels.oscillator import Oscillator
from rattle_kernels.periodic_orbit import find_periodic_orbit
from rattle_kernels.solutions import name_solutions
from rattle_kernels.time_history import time_history


def warm_up() -> None:
    """Run every kernel once on a basin of a few cells."""
    oscillator = Oscillator()
    grid = CellGrid(time_cells=4, velocity_cells=4)
    images = map_cells(oscillator, grid, 1, (0, 4), (0, 4))
    # Seeds that settle on the periodic orbit and on the chaotic attractor: both ways of being named.
    attractors = find_attractors(oscillator, [0.89829, 0.553], [3.76991, 4.703])
    name_solutions(oscillator, attractors, [0.9], [3.77])
    # Twice around P(1,1,0): an orbit of which a part may be the whole.
    find_periodic_orbit(oscillator, 0.89829, 3.76991, 2, 5.0)
    members = unite(grid.cells, [mark_images(grid.cells, images.image_cell)])
    place = np.empty(members.size, np.int32)
    if has_members(members, (0, 4), (0, 4), grid.time_cells):
        place_images(members, (0, 0), grid.time_cells, images.image_cell, place)
    label_cells(find_groups(members, place), np.arange(grid.cells), images.image_cell.ravel())
    warm_up_curves()
    grazing_preimages(oscillator, 1)


def warm_up_curves() -> None:
    """Run the kernels of what is drawn beside a basin: its grazing curve, and a motion over time."""
    grazing_velocity(Oscillator(), 0.0)
    time_history(Oscillator(), 0.0, 0.0, 0.0, periods=1.0)
