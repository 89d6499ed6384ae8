r"""The resolution matrix of a linear solver: what it makes of a load on one node.

With a solver's inverse G and the observation A, the estimate of a pressure p without noise is
:math:`G A\,p`. A column of :math:`R = G A` is the point spread of a node: the estimate of a load
on it alone. A row is its cross-talk: which loads leak into its estimate (Backus and Gilbert 1968;
Menke, Geophysical Data Analysis, chapter 4; Hauk, Stenroos and Treder 2022 for the measures).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, InputError, check_shape
from skinfield.inverse import InverseOperator, Solver
from skinfield.layout import Grid
from skinfield.observation import ObservationModel

BLOCK = 256  # nodes whose distances to all others are held at once


@dataclass(frozen=True, eq=False)
class SpreadMetrics:
    """How far from a point each point spread, or each row of cross-talk, is.

    Distances are taken in the patch's plane, weights are absolute values. Infinite where a
    function is zero: nothing comes of that node.

    Attributes
    ----------
    grid : Grid
    peak_error : (K,) array, m
        From the node to the largest value.
    centre_error : (K,) array, m
        From the node to the centre of gravity.
    dispersion : (K,) array, m
        Root of the mean squared distance from the node, weighted by the squared values
        (Molins et al. 2008, equation 12).
    relative_amplitude : (K,) array
        Largest value, as a part of the largest of all nodes.
    recovered : (K,) array
        Sum of the values. Of a point spread: the force that is estimated for 1 N.
    """

    grid: Grid
    peak_error: Floats
    centre_error: Floats
    dispersion: Floats
    relative_amplitude: Floats
    recovered: Floats


@dataclass(frozen=True, eq=False)
class ResolutionMatrix:
    """Resolution of a linear solver on a grid.

    Attributes
    ----------
    grid : Grid
    matrix : (K, K) array, dimensionless
        Estimate on node i, in Pa, per Pa on node j; so also N per N.
    """

    grid: Grid
    matrix: Floats

    def __post_init__(self) -> None:
        count = len(self.grid)
        check_shape("matrix", self.matrix, (count, count), "estimated by pressed nodes")

    def point_spread(self, node: int) -> Floats:
        """What a unit load on a node looks like: (K,), Pa per Pa."""
        return np.asarray(self.matrix[:, self._node(node)])

    def cross_talk(self, node: int) -> Floats:
        """Which unit loads leak into a node's estimate: (K,), Pa per Pa."""
        return np.asarray(self.matrix[self._node(node)])

    def spread_metrics(self) -> SpreadMetrics:
        """Of all point spreads."""
        return _metrics(self.grid, self.matrix.T)

    def cross_talk_metrics(self) -> SpreadMetrics:
        """Of all rows of cross-talk."""
        return _metrics(self.grid, self.matrix)

    def _node(self, node: int) -> int:
        if not 0 <= node < len(self.grid):
            raise InputError(f"node is {node!r}, expected 0 to {len(self.grid) - 1}")
        return node


def resolution_matrix(model: ObservationModel, solver: Solver) -> ResolutionMatrix:
    """Resolution of a solver on a model's grid.

    Parameters
    ----------
    model : ObservationModel
    solver : Solver
        A linear one.

    Raises
    ------
    InputError
        When the solver is not linear: it has no resolution matrix.
    """
    inverse = solver.prepare(model)
    if not isinstance(inverse, InverseOperator):
        raise InputError(
            f"solver is {solver!r}, expected a linear one such as GaussianField or Tikhonov: what "
            "others make of a load depends on all loads, and no matrix says it"
        )
    return ResolutionMatrix(model.grid, inverse.matrix @ model.matrix)


def _metrics(grid: Grid, functions: Floats) -> SpreadMetrics:
    """Of functions (K, K), one row per node."""
    columns = zip(*_blocks(grid.plane, functions), strict=True)
    peak_error, centre_error, dispersion, amplitude, recovered = map(np.concatenate, columns)
    largest = float(amplitude.max())
    relative = amplitude / largest if largest > 0.0 else amplitude
    return SpreadMetrics(grid, peak_error, centre_error, dispersion, relative, recovered)


def _blocks(plane: Floats, functions: Floats) -> Iterator[tuple[Floats, ...]]:
    for first in range(0, len(plane), BLOCK):
        nodes = slice(first, first + BLOCK)
        weight = np.abs(functions[nodes])
        live = weight.max(axis=1) > 0.0
        total = np.where(live, weight.sum(axis=1), 1.0)
        square = np.where(live, (weight**2).sum(axis=1), 1.0)
        away = np.square(plane[nodes, None] - plane[None]).sum(axis=2)
        peak = plane[weight.argmax(axis=1)] - plane[nodes]
        centre = weight @ plane / total[:, None] - plane[nodes]
        spread = np.sqrt(np.einsum("nk,nk->n", away, weight**2) / square)
        distances = (np.linalg.norm(peak, axis=1), np.linalg.norm(centre, axis=1), spread)
        errors = (np.where(live, distance, np.inf) for distance in distances)
        yield (*errors, weight.max(axis=1), functions[nodes].sum(axis=1))
