"""Contract of every solver, as tests to inherit."""

from functools import lru_cache

import numpy as np
import pytest

from skinfield.elastic import BaseStress, BondedLayer, Layer, ObservationModel
from skinfield.errors import Floats
from skinfield.skin import Grid, Patch
from skinfield.solve import ContactOperator, Solver

NOISE = 20.0  # Pa


def square_patch(side: int = 9, pitch: float = 4e-3) -> Patch:
    """Regular array of `side` x `side` taxels about the origin."""
    axis = (np.arange(side) - (side - 1) / 2) * pitch
    return Patch(np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2), pad_diameter=3e-3)


def broad_press(grid: Grid, centre: tuple[float, float] = (1e-3, -2e-3)) -> Floats:
    """Paraboloid of pressure 12 mm wide, 10 kPa high, (K,) Pa: broad enough to be resolved."""
    square = np.sum((grid.plane - centre) ** 2, axis=1)
    return np.asarray(1e4 * np.maximum(0.0, 1 - square / 6e-3**2))


@lru_cache(maxsize=8)
def broad_press_model(nodes: int, quantity: BaseStress) -> ObservationModel:
    """Model to invert: stress under a 2 mm layer."""
    patch = square_patch()
    grid = Grid.square(patch, nodes=nodes)
    return ObservationModel.of(patch, Layer(), grid, BondedLayer(), quantity, NOISE)


@lru_cache(maxsize=8)
def broad_press_readings(quantity: BaseStress) -> tuple[Floats, float]:
    """Readings and force of a broad press, from a grid of their own that is finer."""
    patch = square_patch()
    fine = Grid.window(patch, (-0.012, -0.012), (0.012, 0.012), pitch=0.8e-3)
    truth = broad_press(fine)
    matrix = quantity.matrix(BondedLayer(), Layer(), fine, patch.plane, patch.pad_diameter)
    return matrix @ truth, float(truth.sum() * fine.cell_area)


class SolverContract:
    """Subclass it with a solver and the brackets it keeps; an unexplained gain fails, too.

    Attributes
    ----------
    solver : Solver
    force_ratio : (lowest, highest)
        Of the estimated to the true force of a broad press.
    place_error : float, m
        The largest error of the centre of pressure of a broad press.
    left_out_change : float
        How much of the peak any cell may change when a far taxel is left out.
    nodes : int
        Of the grid, a side.
    quantity : BaseStress
        Over the pads, or at points for a solver that cannot undo the pads.
    """

    solver: Solver
    force_ratio: tuple[float, float]
    place_error: float
    left_out_change: float = 0.01
    nodes: int = 23
    quantity: BaseStress = BaseStress()

    @pytest.fixture(name="model")
    def _model(self) -> ObservationModel:
        return broad_press_model(self.nodes, self.quantity)

    @pytest.fixture(name="readings")
    def _readings(self) -> tuple[Floats, float]:
        return broad_press_readings(self.quantity)

    def solve(self, model: ObservationModel, readings: Floats) -> Floats:
        """Pressure (K,) of readings, through `apply` or `fit`."""
        operator = self.solver.prepare(model)
        if isinstance(operator, ContactOperator):
            return operator.fit(readings).pressure
        out = np.full(len(model.grid), np.nan)
        operator.apply(readings, out)
        return out

    def test_force_stays_in_its_bracket(
        self, model: ObservationModel, readings: tuple[Floats, float]
    ) -> None:
        """The known loss of the solver, no more and no less."""
        pressure = self.solve(model, readings[0])
        ratio = pressure.sum() * model.grid.cell_area / readings[1]
        assert self.force_ratio[0] <= ratio <= self.force_ratio[1]

    def test_place_is_found(self, model: ObservationModel, readings: tuple[Floats, float]) -> None:
        """The centre of the pressure's square (robust to ringing) lies where the press is."""
        weight = np.maximum(self.solve(model, readings[0]), 0.0) ** 2
        centre = weight @ model.grid.plane / weight.sum()
        assert np.linalg.norm(centre - (1e-3, -2e-3)) <= self.place_error

    def test_no_reading_gives_no_pressure(self, model: ObservationModel) -> None:
        """Zero in, zero out, and every entry of `out` written."""
        assert not self.solve(model, np.zeros(len(model.taxels))).any()

    def test_pressure_std_is_positive_and_grows_with_the_noise(
        self, model: ObservationModel
    ) -> None:
        """The stated deviation is finite, not negative, and not blind to the noise."""
        operator = self.solver.prepare(model)
        if isinstance(operator, ContactOperator):
            quiet = operator.fit(broad_press_readings(self.quantity)[0]).pressure_std
        else:
            quiet = operator.pressure_std
        assert quiet.shape == (len(model.grid),)
        assert np.isfinite(quiet).all()
        assert (quiet >= 0).all()
        assert quiet.max() > 0

    def test_a_taxel_that_is_left_out_changes_little_elsewhere(
        self, model: ObservationModel, readings: tuple[Floats, float]
    ) -> None:
        """Without the corner taxel the press in the middle stays."""
        keep = np.arange(len(model.taxels)) > 0
        whole = self.solve(model, readings[0])
        part = self.solve(model.subset(keep), readings[0][keep])
        assert np.abs(whole - part).max() < self.left_out_change * whole.max()
