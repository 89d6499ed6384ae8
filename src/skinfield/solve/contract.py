"""Contract of every solver, as tests to inherit."""

import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

import numpy as np
import pytest

from skinfield.elastic import BaseStress, BondedLayer, Layer, ObservationModel
from skinfield.errors import Floats
from skinfield.skin import Grid, Patch
from skinfield.solve import Operator, Solution, Solver

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
    name : str
        Of the solver that answers; by default its own.
    """

    solver: Solver
    force_ratio: tuple[float, float]
    place_error: float
    left_out_change: float = 0.01
    nodes: int = 23
    quantity: BaseStress = BaseStress()
    name: str = ""

    @pytest.fixture(scope="class", name="operator")
    @classmethod
    def _operator(cls) -> Operator:
        return cls.solver.prepare(broad_press_model(cls.nodes, cls.quantity))

    @pytest.fixture(name="readings")
    def _readings(self) -> tuple[Floats, float]:
        return broad_press_readings(self.quantity)

    def test_force_stays_in_its_bracket(
        self, operator: Operator, readings: tuple[Floats, float]
    ) -> None:
        """The known loss of the solver, no more and no less."""
        pressure = solved(operator, readings[0]).pressure
        ratio = pressure.sum() * operator.model.grid.cell_area / readings[1]
        assert self.force_ratio[0] <= ratio <= self.force_ratio[1]

    def test_place_is_found(self, operator: Operator, readings: tuple[Floats, float]) -> None:
        """The centre of the pressure's square (robust to ringing) lies where the press is."""
        weight = np.maximum(solved(operator, readings[0]).pressure, 0.0) ** 2
        centre = weight @ operator.model.grid.plane / weight.sum()
        assert np.linalg.norm(centre - (1e-3, -2e-3)) <= self.place_error

    def test_no_reading_gives_no_pressure(self, operator: Operator) -> None:
        """Zero in, zero out, and every entry of the solution written."""
        data = operator.data()
        data.solution.pressure[:] = np.nan
        assert not operator.solve(np.zeros(len(operator.model.taxels)), data).pressure.any()

    def test_pressure_std_is_positive_and_grows_with_the_noise(
        self, operator: Operator, readings: tuple[Floats, float]
    ) -> None:
        """The stated deviation is finite, not negative, and not blind to the noise."""
        quiet = operator.pressure_std(solved(operator, readings[0]))
        assert quiet.shape == (len(operator.model.grid),)
        assert np.isfinite(quiet).all()
        assert (quiet >= 0).all()
        assert quiet.max() > 0

    def test_a_taxel_that_is_left_out_changes_little_elsewhere(
        self, operator: Operator, readings: tuple[Floats, float]
    ) -> None:
        """Without the corner taxel, whatever it reads, the press in the middle stays."""
        keep, data = np.arange(len(operator.model.taxels)) > 0, operator.data()
        whole = operator.solve(readings[0], data).pressure.copy()
        part = operator.without(keep).solve(np.where(keep, readings[0], np.nan), data)
        assert np.abs(whole - part.pressure).max() < self.left_out_change * whole.max()
        assert np.isfinite(part.residual[keep]).all()

    def test_the_rest_of_a_solution_has_its_shapes(
        self, operator: Operator, readings: tuple[Floats, float]
    ) -> None:
        """Residual, displacement and contacts, for which others may stand in."""
        solution, nodes = solved(operator, readings[0]), len(operator.model.grid)
        assert np.isfinite(solution.residual).all()
        moved, contacts = operator.displacement(solution), operator.contacts(solution)
        assert moved is None or moved.shape == (nodes, 3)
        assert contacts is None or len(contacts) > 0
        assert operator.noise.std.shape == (nodes,)

    def test_only_what_is_copied_lasts(
        self, operator: Operator, readings: tuple[Floats, float]
    ) -> None:
        """Each reading is bits into the same solution; after a reset as if it were first."""
        data = operator.data()
        first = operator.solve(readings[0], data)
        copy = first.keep()
        assert operator.solve(0.5 * readings[0], data) is first is data.solution
        assert not np.array_equal(first.pressure, copy.pressure)
        data.reset()
        operator.solve(readings[0], data)
        assert np.array_equal(first.pressure, copy.pressure)
        assert np.array_equal(first.residual, copy.residual)

    def test_threads_give_the_same_bits(
        self, operator: Operator, readings: tuple[Floats, float]
    ) -> None:
        """Two threads with memory of their own answer as one does after the other."""
        chains = [[scale * readings[0] for scale in scales] for scales in ((1, 1.1, 0.6), (0.5, 2))]

        def bits(chain: list[Floats]) -> list[bytes]:
            data = operator.data()
            return [operator.solve(each, data).pressure.tobytes() for each in chain]

        with ThreadPoolExecutor(2) as threads:
            found = list(threads.map(bits, chains))
        assert found == [bits(chain) for chain in chains]

    def test_no_array_is_allocated(
        self, operator: Operator, readings: tuple[Floats, float]
    ) -> None:
        """From the second reading on, with a deadline too."""
        data = operator.data()
        rows = [readings[0], 0.9 * readings[0]]
        for lap in range(40):  # until the interpreter's own stores are full
            if lap == 39:
                tracemalloc.start()
            for row in rows:
                operator.solve(row, data)
                operator.solve(row, data, 1)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert peak < data.solution.pressure.nbytes

    def test_a_deadline_that_is_over_leaves_an_answer(
        self, operator: Operator, readings: tuple[Floats, float]
    ) -> None:
        """It is late, and says so."""
        solution = operator.solve(readings[0], operator.data(), 1)
        assert np.isfinite(solution.pressure).all()
        assert not solution.in_time
        assert solution.solver == (self.name or type(self.solver).__name__)


def solved(operator: Operator, readings: Floats) -> Solution:
    """Solution of one reading, from nothing."""
    return operator.solve(readings, operator.data())
