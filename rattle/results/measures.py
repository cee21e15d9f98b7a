"""What a result measures: integrity, loudness, least disturbances, what is proven, boundaries that curves cover."""

import json
from typing import Any

import xarray as xr

from rattle.results.motions import Motions
from worker.errors import InvalidJob


class Measures(Motions):
    """The part of the accessor that measures basins."""

    def measures(self, tolerance: float = 1e-6) -> xr.Dataset:
        """Measures of each basin: integrity, entropies, uncertainty exponent, least disturbance.

        Parameters
        ----------
        tolerance : float
            Width of the bracket to which each least disturbance is narrowed.

        Returns
        -------
        xarray.Dataset
            As ``worker.views.measures.measure_basins`` describes it.

        Raises
        ------
        InvalidJob
            If it is of a sample, or has too few cells.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> 0.0 < basin.rattle.measures().basin_entropy.item() < 1.0
        True
        """
        self._demand("measures", "basin", "sweep")
        from worker.views.measures import measure_basins

        return measure_basins(self._dataset, tolerance)

    def loudness(self) -> xr.Dataset:
        """How loud each motion is, and what is to be expected over the window: impacts, their speed and power.

        Returns
        -------
        xarray.Dataset
            As ``worker.views.loudness.measure_loudness`` describes it.

        Raises
        ------
        InvalidJob
            If this is neither a basin nor a sweep.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> basin.rattle.loudness().impacts_per_period.values[:2].tolist()
        [0.0, 1.0]
        """
        self._demand("loudness", "basin", "sweep")
        from worker.views.loudness import measure_loudness

        return measure_loudness(self._dataset)

    def least_disturbance(self, tolerance: float = 1e-6) -> xr.DataArray:
        """Smallest speed at each phase that leads from quiet to rattle.

        Parameters
        ----------
        tolerance : float
            Width of the bracket to which it is narrowed.

        Returns
        -------
        xarray.DataArray
            Over ``time``.

        Raises
        ------
        InvalidJob, ValueError
            If the window does not begin at speed 0, or there are no cells.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> bool((basin.rattle.least_disturbance() > basin.rattle.proven_quiet()).all())
        True
        """
        self._demand("least_disturbance", "basin")
        from rattle_kernels import least_disturbance

        job: Any = self.job
        found = least_disturbance(job.oscillator, self.catalogue(), self._dataset.solution, job.grid, tolerance)
        attributes = {"units": "1", "long_name": "smallest speed that leads from quiet to rattle"}
        return xr.DataArray(found.velocity, {"time": self._dataset.time}, ["time"], "least_disturbance", attributes)

    def proven_quiet(self) -> xr.DataArray:
        """Speed at each phase below which every departure falls quiet, by proof: ever lower bounces capture it.

        Returns
        -------
        xarray.DataArray
            Over ``time``; 0 where nothing is proven.

        Raises
        ------
        InvalidJob
            If this is no basin.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> bool((basin.rattle.proven_quiet() > 0.0).all())
        True
        """
        self._demand("proven_quiet", "basin")
        from rattle_kernels import capture_velocity

        speeds = capture_velocity(self.oscillator, self._dataset.time.values)
        attributes = {"units": "1", "long_name": "speed below which quiet is proven"}
        return xr.DataArray(speeds, {"time": self._dataset.time}, ["time"], "proven_quiet", attributes)

    @property
    def certificate(self) -> dict[str, Any]:
        """What a basin is proven from: constants of its targets, counts, and the proven share of each motion.

        Raises
        ------
        InvalidJob
            If no proof was asked for, or it has not begun.

        Examples
        --------
        >>> basin = rattle.basin(cells=8, prove=True, levels=0, progress=False)
        >>> basin.rattle.certificate["quiet"]["level"] > 0.09
        True
        """
        self._demand("certificate", "basin")
        if "certificate" not in self._dataset.attrs:
            raise InvalidJob("nothing is proven of this basin: compute it with prove=True", ("prove",))
        certificate: dict[str, Any] = json.loads(self._dataset.attrs["certificate"])
        return certificate

    def boundary_share(self, curves: xr.Dataset) -> dict[str, float]:
        """Share of the cells on boundaries of basins that lie within one cell of curves.

        Parameters
        ----------
        curves : xarray.Dataset
            Of `rattle.manifolds` or `rattle.grazing_curve`.

        Returns
        -------
        dict of str to float
            By the name of each curve, and of all together.

        Raises
        ------
        InvalidJob
            If this is no basin.

        Examples
        --------
        >>> basin, curves = rattle.basin(cells=40, progress=False), rattle.grazing_curve(order=1, progress=False)
        >>> list(basin.rattle.boundary_share(curves))
        ['grazing curve', 'pre-image 1', 'all together']
        """
        self._demand("boundary_share", "basin")
        from rattle.results.curves import curves_of
        from rattle_kernels import boundary_share

        job: Any = self.job
        pieces = {each.label: each.pieces for each in curves_of(curves, curves.rattle.kind)}
        pieces["all together"] = tuple(piece for own in pieces.values() for piece in own)
        solution = self._dataset.solution.values
        return {name: float(boundary_share(solution, job.grid, own)) for name, own in pieces.items()}
