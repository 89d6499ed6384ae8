"""What the resolutions of one patch share, and what each has for itself."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from skinfield.errors import Floats, InputError, check_count
from skinfield.fields import ModelError, PressureNoise, PressurePosterior
from skinfield.inverse import (
    ContactOperator,
    FieldOperator,
    GaussianField,
    InverseOperator,
    NonNegative,
    Solver,
)
from skinfield.layout import Grid, Patch
from skinfield.mechanics import Layer, Mechanics
from skinfield.observation import Deformation, ObservationModel, Quantity
from skinfield.pipeline.ladder_restriction import RestrictedPosterior, Restriction

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
    matrix : (K, L) array, Pa per unit of the reading
        The linear answer: that of the finest rung, averaged over this one's cells.
    noise : PressureNoise
        Of the linear answer.
    posterior : PressurePosterior, RestrictedPosterior or None
        Of a Bayesian solver, averaged alike.
    model_error : ModelError
    model : ObservationModel or None
        On this grid, where the solver is iterative.
    operator : FieldOperator or None
        Of an iterative solver, prepared on this grid.
    """

    nodes: int
    grid: Grid
    deformation: Deformation
    matrix: Floats
    noise: PressureNoise
    posterior: PressurePosterior | RestrictedPosterior | None
    model_error: ModelError
    model: ObservationModel | None = None
    operator: FieldOperator | None = None

    @cached_property
    def pressure_std(self) -> Floats:
        """One standard deviation of the linear answer, (K,) Pa."""
        return self.noise.std if self.posterior is None else self.posterior.std


@dataclass(frozen=True, eq=False)
class Rungs:
    """All resolutions of one patch, from coarse to fine, with what they share.

    Attributes
    ----------
    steps : tuple of Rung
    explained : (L, L) array
        From linearised readings to what the linear answer predicts of them, on any rung.
    noise_std : (L,) array, unit of the reading
    start : InverseOperator
        The linear answer on the finest rung.
    model : ObservationModel
        On the finest rung.
    linear : bool
        Whether the linear answer is the solver's own.
    bayesian : bool
        Whether the linear answer is a posterior mean.
    """

    steps: tuple[Rung, ...]
    explained: Floats
    noise_std: Floats
    start: InverseOperator
    model: ObservationModel
    linear: bool
    bayesian: bool

    @cached_property
    def weights(self) -> Floats:
        r"""Inverse covariance of the readings that prior and noise let expect, (L, L).

        With A Q Aᵀ + Σ = S the answer is p = Q Aᵀ S⁻¹ y, so it predicts A p = (1 - Σ S⁻¹) y, and

        .. math:: S^{-1} = \\Sigma^{-1} (1 - A M), \\qquad p = M y.
        """
        unexplained = np.eye(len(self.explained)) - self.explained
        weights = unexplained / np.square(self.noise_std)[:, None]
        return np.asarray(0.5 * (weights + weights.T))

    @cached_property
    def unresolved(self) -> tuple[float, ...]:
        """Part of the finest linear answer's squared norm that each rung averages away."""
        finest = self.steps[-1]
        kept = [_power(step.matrix * self.noise_std, step.grid) for step in self.steps]
        whole = _power(finest.matrix * self.noise_std, finest.grid)
        return tuple(max(1.0 - each / whole, 0.0) if whole else 0.0 for each in kept)


def _power(matrix: Floats, grid: Grid) -> float:
    return float(np.square(matrix).sum()) * grid.cell_area


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
        For rungs out of order, or a solver that finds contacts by itself.
    """
    check_sides(sides)
    grids = [Grid.square(patch, nodes) for nodes in sides]
    finest = ObservationModel.of(patch, layer, grids[-1], mechanics, quantity, noise_std)
    top = _prepared(solver, finest)
    linear = isinstance(top, InverseOperator)
    start = top if isinstance(top, InverseOperator) else linear_start(solver).prepare(finest)
    steps = []
    for nodes, grid in zip(sides, grids, strict=True):
        step = linear_rung(nodes, Deformation(grid, layer, mechanics), start, finest)
        if not linear:
            model = finest
            if grid is not grids[-1]:
                model = ObservationModel.of(patch, layer, grid, mechanics, quantity, noise_std)
            step = replace(step, model=model, operator=_iterative(solver, model, finest, top))
        steps.append(step)
    return Rungs(
        steps=tuple(steps),
        explained=finest.matrix @ start.matrix,
        noise_std=finest.noise_std,
        start=start,
        model=finest,
        linear=linear,
        bayesian=start.posterior is not None,
    )


def _iterative(
    solver: Solver,
    model: ObservationModel,
    finest: ObservationModel,
    top: InverseOperator | FieldOperator,
) -> FieldOperator:
    operator = top if model is finest else _prepared(solver, model)
    assert not isinstance(operator, InverseOperator)  # a solver is linear on all grids or none
    return operator


def check_sides(sides: Sequence[int]) -> None:
    """Raise InputError unless the rungs rise."""
    for nodes in sides:
        check_count("rungs", nodes, 2, FINEST, "nodes along a side of each grid")
    if not sides or any(a >= b for a, b in pairwise(sides)):
        raise InputError(
            f"rungs is {tuple(sides)!r}, expected one or more, from coarse to fine: (10, 20, 40)"
        )


def linear_start(solver: Solver) -> GaussianField:
    """The linear solver of the same prior: an iterative one's answer before its first step."""
    if isinstance(solver, NonNegative):
        return GaussianField(snr=solver.snr, length_scale=solver.length_scale)
    return GaussianField()


def _prepared(solver: Solver, model: ObservationModel) -> InverseOperator | FieldOperator:
    operator = solver.prepare(model)
    if isinstance(operator, ContactOperator):
        raise InputError(
            f"solver is {type(solver).__name__}(), which finds contacts by itself and has no "
            "resolution to choose, expected a solver of fields: NonNegative() or GaussianField(); "
            "for contacts use a Reconstructor with a deadline"
        )
    return operator


def linear_rung(
    nodes: int, deformation: Deformation, finest: InverseOperator, model: ObservationModel
) -> Rung:
    """Derive a resolution's linear answer from the finest one's, prepared for a model."""
    grid, posterior, matrix = deformation.grid, finest.posterior, finest.matrix
    error: PressurePosterior | RestrictedPosterior | None = posterior
    if grid.shape != model.grid.shape:
        restriction, every = Restriction.between(model.grid, grid), np.arange(len(grid))
        matrix = np.ascontiguousarray(restriction(matrix.T).T)
        error = None if posterior is None else RestrictedPosterior(posterior, restriction, every)
    noise = PressureNoise(matrix * model.noise_std)
    return Rung(nodes, grid, deformation, matrix, noise, error, finest.model_error)
