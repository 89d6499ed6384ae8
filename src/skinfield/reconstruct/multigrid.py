"""Multigrid levels: one patch prepared at several resolutions."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import Deformation, Layer, Mechanics, ObservationModel, Quantity, on_surface
from skinfield.errors import Floats, InputError, check_count
from skinfield.estimate import PressureError
from skinfield.skin import Grid, Patch
from skinfield.solve import GaussianField, LinearOperator, NonNegative, Operator, Solver
from skinfield.solve.tiles import SIDE


@dataclass(frozen=True, eq=False)
class Restriction:
    r"""Pressure on coarse cells as the average of what lies on fine cells below.

    .. math:: p_c = \sum_f \frac{|c \cap f|}{|c|} \, p_f

    Coarse cells that hold all fine ones conserve the force: the sum of pressure times cell area.
    The area of an intersection is a product of two lengths, so two small matrices do it.

    Attributes
    ----------
    down : (coarse rows, fine rows) array
    across : (coarse columns, fine columns) array
        Parts of a coarse cell's side that each fine cell covers.
    """

    down: Floats
    across: Floats

    @classmethod
    def between(cls, fine: Grid, coarse: Grid) -> "Restriction":
        """Of two grids in one plane."""
        parts = [
            _parts(fine.origin[axis], fine.pitch, count, coarse.origin[axis], coarse.pitch, wanted)
            for axis, count, wanted in zip(
                (1, 0), fine.shape, coarse.shape, strict=True
            )  # rows lie along y
        ]
        return cls(*parts)

    def __call__(self, fields: Floats) -> Floats:
        """Fields (..., K fine) on the coarse cells, (..., K coarse)."""
        pictures = fields.reshape(*fields.shape[:-1], self.down.shape[1], self.across.shape[1])
        coarse = self.down @ pictures @ self.across.T
        return np.asarray(coarse.reshape(*fields.shape[:-1], -1))

    def transposed(self, weights: Floats) -> Floats:
        """Weights (..., K coarse) of a sum, as those of fine cells, (..., K fine)."""
        pictures = weights.reshape(*weights.shape[:-1], len(self.down), len(self.across))
        fine = self.down.T @ pictures @ self.across
        return np.asarray(fine.reshape(*weights.shape[:-1], -1))


@dataclass(frozen=True, eq=False)
class RestrictedPosterior:
    """Covariance of coarse cells, exactly: that of the sums of fine cells that they are.

    Attributes
    ----------
    fine : PressureError
    restriction : Restriction
    """

    fine: PressureError
    restriction: Restriction

    @cached_property
    def std(self) -> Floats:
        """Standard deviation of each coarse cell, (K,) Pa."""
        count, one = len(self.restriction.down) * len(self.restriction.across), np.ones((1, 1))
        each = np.arange(count)[:, None]
        variance = [self.covariance_of_sums(cell, one)[0, 0] for cell in each]
        return np.sqrt(np.maximum(variance, 0.0))

    @cached_property
    def felt(self) -> int:
        """Number of cells of which anything is left open."""
        return int(np.count_nonzero(self.std))

    def covariance_of_sums(self, cells: NDArray[np.int64], weights: Floats) -> Floats:
        """Covariance (M, M) of M weighted sums over some cells; weights (M, cells), times Pa."""
        restriction = self.restriction
        count = len(restriction.down) * len(restriction.across)
        sums = [np.bincount(cells, weight, count) for weight in weights]  # cells may come again
        coarse = np.asarray(sums, dtype=np.float64)
        fine = restriction.transposed(coarse)
        used = np.flatnonzero(fine.any(axis=0))
        return self.fine.covariance_of_sums(used, fine[:, used])


def _parts(fine: float, step: float, count: int, coarse: float, side: float, wanted: int) -> Floats:
    """Parts of coarse cells of one axis that fine cells cover, (wanted, count)."""
    low = fine + (np.arange(count) - 0.5) * step
    start = coarse + (np.arange(wanted) - 0.5) * side
    last = np.minimum(low + step, (start + side)[:, None])
    return np.asarray(np.maximum(last - np.maximum(low, start[:, None]), 0.0) / side)


FINEST = 400  # nodes a side: beyond, one matrix of 72 taxels holds 46 MB


@dataclass(frozen=True, eq=False)
class Rung:
    """One resolution of a patch.

    Attributes
    ----------
    nodes : int
        Along each side of the grid.
    grid : Grid
    deformation : Deformation
    start : LinearOperator
        The linear answer: that of the finest rung, averaged over this one's cells.
    operator : Operator
        That answers on this grid: `start` where the solver is linear.
    """

    nodes: int
    grid: Grid
    deformation: Deformation
    start: LinearOperator
    operator: Operator

    @cached_property
    def matrix(self) -> Floats:
        """Readings of a pressure on this grid, (L, K), unit of the reading per Pa."""
        model = self.operator.model
        physics = model.physics
        if model.grid.shape == self.grid.shape or physics is None:
            return model.matrix
        places = self.grid, model.taxels, physics.pad_diameter
        return physics.quantity.matrix(physics.mechanics, physics.layer, *places)


@dataclass(frozen=True, eq=False)
class Rungs:
    """All resolutions of one patch, from coarse to fine.

    Attributes
    ----------
    steps : tuple of Rung
    """

    steps: tuple[Rung, ...]

    @property
    def start(self) -> LinearOperator:
        """The linear answer on the finest rung."""
        return self.steps[-1].start

    @cached_property
    def offset_weights(self) -> Floats:
        """Of readings (L,) in the mean of the offset that the linear answer takes them to share.

        That is the mean of what the pressure leaves over, weighed by the noise, and drawn to 0.
        """
        known, explained = self.start.gaussian, self.start.explained
        if known is None:
            return np.zeros(len(explained))
        odds = np.square(known.offset)
        weights = odds / (1.0 + odds.sum())
        return np.asarray(weights - weights @ explained)

    @property
    def linear(self) -> bool:
        """Whether the linear answer is the solver's own."""
        return self.steps[-1].operator is self.start


def prepare_rungs(
    patch: Patch,
    layer: Layer,
    sides: Sequence[int],
    mechanics: Mechanics,
    quantity: Quantity,
    solver: Solver,
    noise_std: Any,
) -> Rungs:
    """Prepare the finest grid, and derive the others from it.

    Raises
    ------
    InputError
        For rungs out of order.
    """
    check_sides(sides)
    grids = [on_surface(Grid.square(patch, nodes), layer, mechanics) for nodes in sides]
    physics = mechanics, quantity, noise_std
    finest = ObservationModel.of(patch, layer, grids[-1], *physics)
    top = solver.prepare(finest)
    if top.linear is not None:
        start = top.linear
    elif isinstance(solver, NonNegative):  # an iterative one starts from its prior without bounds
        start = solver.unconstrained().prepare(finest)
    else:
        start = GaussianField().prepare(finest)
    steps = []
    for nodes, grid in zip(sides, grids, strict=True):
        mean = averaged(start, grid)
        operator: Operator = mean
        if top.linear is None:
            operator = top
            if grid is not grids[-1]:
                model = ObservationModel.of(patch, layer, grid, *physics)
                on = getattr(top, "on", None)  # what finds contacts needs no grid to find them
                operator = solver.prepare(model) if on is None else on(model)
        steps.append(Rung(nodes, grid, Deformation(grid, layer, mechanics), mean, operator))
    return Rungs(tuple(steps))


def check_sides(sides: Sequence[int]) -> None:
    """Raise InputError unless the rungs rise."""
    for nodes in sides:
        check_count("rungs", nodes, SIDE, FINEST, "nodes along a side of each grid")
    if not sides or any(a >= b for a, b in pairwise(sides)):
        raise InputError(
            f"rungs is {tuple(sides)!r}, expected one or more, from coarse to fine: (10, 20, 40)"
        )


def averaged(finest: LinearOperator, grid: Grid) -> LinearOperator:
    """Linear operator of the averages over the cells of a coarser grid."""
    if grid.shape == finest.model.grid.shape:
        return finest
    restriction, fine = Restriction.between(finest.model.grid, grid), finest.posterior
    matrix = np.ascontiguousarray(restriction(finest.matrix.T).T)
    error = None if fine is None else RestrictedPosterior(fine, restriction)
    return replace(finest, matrix=matrix, std=None, posterior=error, gaussian=None, source=finest)
