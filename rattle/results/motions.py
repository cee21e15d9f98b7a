"""What the cells of a basin end in: the motions, their colours, and the basins of a sweep one by one."""

from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from rattle.results.described import Described
from rattle_kernels import NOT_CONVERGED, PERMANENT_CONTACT, SINK, Attractor
from worker.views import reading

_RESERVED_IMAGES = {"sink": SINK, "permanent_contact": PERMANENT_CONTACT, "undecided": NOT_CONVERGED}


class Motions(Described):
    """The part of the accessor that speaks of motions and cells."""

    @property
    def attractors(self) -> xr.Dataset:
        """What motions end in, with the shares: the part of the dataset on the dimension ``attractor``.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> basin.rattle.attractors.name.values.tolist()
        ['permanent contact', 'P(1,1,0)', 'chaotic']
        """
        self._demand("attractors", "basin", "sweep")
        names = [name for name, array in self._dataset.variables.items() if "attractor" in array.dims]
        attractors: xr.Dataset = self._dataset[names].load()
        return attractors

    def catalogue(self) -> tuple[Attractor, ...]:
        """The motions of a basin as ``rattle_kernels`` has them, for its functions; ``solution`` indexes them.

        Returns
        -------
        tuple of Attractor
            Of a basin of a sweep, all motions of the sweep; those that this basin lacks have no points.

        Raises
        ------
        InvalidJob
            If this is no basin.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> basin.rattle.catalogue()[1].name
        'P(1,1,0)'
        """
        self._demand("catalogue", "basin")
        return reading.attractors_of(self._dataset)

    @property
    def colours(self) -> list[tuple[float, float, float]]:
        """Colour of each motion in the project's pictures (red, green, blue), the same in all basins of a sweep.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> basin.rattle.colours[0]
        (0.0784313725490196, 0.12156862745098039, 0.25098039215686274)
        """
        self._demand("colours", "basin", "sweep")
        from worker.pictures.colours import colours_of

        one = self._dataset if self.kind == "basin" else self.basins()[0]
        return colours_of(reading.attractors_of(one))

    @property
    def levels(self) -> dict[int, tuple[int, int]]:
        """Cells of each level, along velocity and time. ``rattle.open(location, level=n)`` opens level n.

        Level 0 is the basin itself. Only basins of more than 4,000 cells a side have others.

        Examples
        --------
        >>> rattle.basin(cells=40, progress=False).rattle.levels
        {0: (40, 40)}
        """
        self._demand("levels", "basin", "sweep")
        from worker.views.at_level import levels_in

        return {level.number: level.tiling.grid.shape for level in levels_in(self._dataset)}

    @cached_property
    def shown(self) -> xr.Dataset:
        """The cells of a basin as pictures show them, in memory: at most 1000 each way.

        Beyond, every n-th stands for its neighbours, since labels have no mean. Shares remain those of all cells.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> basin.rattle.shown.solution.shape
        (40, 40)
        """
        self._demand("shown", "basin")
        return reading.thinned(self._dataset).load()

    def cell_names(self) -> xr.DataArray:
        """Name of the motion that each cell ends in, or each point of a sample.

        Returns
        -------
        xarray.DataArray of str
            Empty where a cell is not computed yet.

        Raises
        ------
        InvalidJob
            If this is neither a basin nor a sweep.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> basin.rattle.cell_names().sel(time=0.5, velocity=0.2, method="nearest").item()
        'permanent contact'
        """
        self._demand("cell_names", "basin", "sweep")
        names = np.array([*self._dataset.name.values.tolist(), ""]) if "name" in self._dataset else np.array([""])
        solution = self._dataset.solution
        numbered = np.where(solution >= 0, solution, len(names) - 1)
        return solution.copy(data=names[numbered]).assign_attrs(long_name="motion that it ends in").rename("cell_names")

    def image_counts(self) -> dict[str, int]:
        """How many cells have no cell as their image under ``P^k``: sink, permanent contact, undecided.

        Returns
        -------
        dict of str to int
            Of the cells that are computed so far. Points of a sample have no sink.

        Raises
        ------
        InvalidJob
            If this is neither a basin nor a sweep.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> sorted(basin.rattle.image_counts())
        ['permanent_contact', 'sink', 'undecided']
        """
        self._demand("image_counts", "basin", "sweep")
        if "image_cell" in self._dataset:
            images, reserved = self._dataset.image_cell.values, _RESERVED_IMAGES
        else:
            images = self._dataset.landing.values
            reserved = {name: code for name, code in _RESERVED_IMAGES.items() if name != "sink"}
        return {name: int((images == code).sum()) for name, code in reserved.items()}

    def basin(self, **values: float) -> xr.Dataset:
        """One basin of a sweep, as if it had been opened alone; numbers and colours stay those of the sweep.

        Parameters
        ----------
        **values : float
            Of every swept parameter.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        InvalidJob
            If a parameter is missing or not swept, or a value is not among those swept.

        Examples
        --------
        >>> sweep = rattle.sweep(damping=[0.55, 0.6, 0.7], cells=16, iterations=101, progress=False)
        >>> sweep.rattle.basin(damping=0.6).rattle.oscillator.damping
        0.6
        """
        self._demand("basin", "sweep")
        return reading.basin_of(self._dataset, **values)

    def basins(self) -> tuple[xr.Dataset, ...]:
        """All basins of a sweep, each as `basin` returns it.

        Returns
        -------
        tuple of xarray.Dataset
            In the order of the values; of two parameters the last one runs fastest.

        Raises
        ------
        InvalidJob
            If this is no sweep.

        Examples
        --------
        >>> sweep = rattle.sweep(damping=[0.55, 0.6, 0.7], cells=16, iterations=101, progress=False)
        >>> [float(basin.damping) for basin in sweep.rattle.basins()]
        [0.55, 0.6, 0.7]
        """
        self._demand("basins", "sweep")
        job: Any = self.job
        return tuple(reading.basin_of(self._dataset, **job.values_of(number)) for number in range(job.basins))
