"""A sheet of many taxels against dense solutions on the same cells."""

import tracemalloc
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pytest

import skinfield as sf
from skinfield.elastic import ObservationModel
from skinfield.errors import Floats

LAYER = sf.Layer(2e-3, 150e3, 0.5)
PAD = 4e-3
DISTANCE = 5.8e-3


def jittered(side: int, rng: np.random.Generator) -> Floats:
    """Taxels at random about a square lattice, in random order."""
    index = np.stack(np.meshgrid(np.arange(side), np.arange(side)), -1).reshape(-1, 2)
    return rng.permutation((index + rng.uniform(-0.3, 0.3, index.shape)) * DISTANCE)


PLACES = jittered(15, np.random.default_rng(3))


@dataclass(frozen=True)
class Dense:
    """The same taxels as a patch, on the sheet's own cells."""

    model: ObservationModel
    matrix: Floats
    readings: Floats

    @property
    def pressure(self) -> Floats:
        return self.matrix @ self.readings


def dense_of(sheet: sf.Sheet, solver: object, places: Floats = PLACES) -> Dense:
    grid = sheet.grid
    model = ObservationModel.of(
        sheet.patch, LAYER, grid, sheet.mechanics, sheet.quantity, sheet.noise_std
    )
    pressed = np.zeros(len(grid))
    for centre, width in ((places.mean(axis=0), 6e-3), (places.min(axis=0), 9e-3)):
        square = np.square(grid.plane - centre).sum(axis=1)
        pressed += 2e4 * np.exp(-square / width**2)
    exact = model.matrix @ pressed
    noise = np.random.default_rng(4).normal(size=len(exact)) * np.abs(exact).max() / 50
    return Dense(model, solver.prepare(model).matrix, exact + noise)


@lru_cache
def fine_pair() -> tuple[sf.Sheet, Dense]:
    """A sheet in double precision, cut late."""
    sheet = sf.Sheet(PLACES, LAYER, tolerance=1e-8, cut=1e-4, precision=np.float64)
    return sheet, dense_of(sheet, sf.GaussianField())


@lru_cache
def usual_pair() -> tuple[sf.Sheet, Dense]:
    """A sheet as it comes."""
    sheet = sf.Sheet(PLACES, LAYER)
    return sheet, dense_of(sheet, sf.GaussianField())


def off(found: Floats, reference: Floats) -> float:
    return float(np.linalg.norm(found.ravel() - reference.ravel()) / np.linalg.norm(reference))


@pytest.mark.parametrize(
    ("solver", "mechanics", "quantity"),
    [
        (sf.Tikhonov(), sf.BondedLayer(), sf.BaseStress()),
        (sf.GaussianField(snr=20.0), sf.HalfSpace(), sf.BaseStress()),
        (sf.GaussianField(length_scale=2.5e-3), sf.BondedLayer(), sf.Gap()),
        (sf.GaussianField(), sf.BondedLayer(), sf.Capacitance(order=1)),
    ],
    ids=["white", "half-space", "gap", "capacitance"],
)
def test_pressure_is_that_of_the_dense_solver(
    solver: object, mechanics: object, quantity: object
) -> None:
    sheet = sf.Sheet(PLACES, LAYER, mechanics=mechanics, quantity=quantity, solver=solver)
    dense = dense_of(sheet, solver)
    error = off(sheet(dense.readings).pressure, dense.pressure)
    assert 1e-6 < error < 8e-3, "more than the cut of 1e-3 and the tolerance can explain"


def test_a_late_cut_brings_it_nearer() -> None:
    usual, fine = usual_pair(), fine_pair()
    coarse = off(usual[0](usual[1].readings).pressure, usual[1].pressure)
    near = off(fine[0](fine[1].readings).pressure, fine[1].pressure)
    assert 1e-3 < coarse < 5e-3
    assert near < 5e-4


def test_gram_is_that_of_the_model() -> None:
    sheet, dense = fine_pair()
    plan, gram = sheet.plan, sheet.plan.gram
    order = plan.placing.order
    taxels = len(sheet)
    full = np.zeros((taxels, taxels))
    row = np.repeat(np.arange(taxels), np.diff(gram.start))
    np.add.at(full, (row, gram.other), gram.value)
    full += full.T + np.eye(taxels)
    spread = dense.matrix @ np.linalg.inv(np.eye(taxels) - dense.model.matrix @ dense.matrix)
    exact = dense.model.matrix @ spread  # A Q A^T / noise², from the solver's own matrix
    exact = (exact + np.eye(taxels))[np.ix_(order, order)]
    scale = 1.0 / np.sqrt(np.diag(exact))
    assert np.abs(full - exact * np.outer(scale, scale)).max() < 3e-4


def test_prediction_is_the_models() -> None:
    sheet, dense = fine_pair()
    field = np.random.default_rng(1).normal(size=len(sheet.grid))
    exact = dense.model.matrix @ field
    assert off(sheet.predict(field), exact) < 1e-3


def test_it_is_linear() -> None:
    sheet, dense = fine_pair()
    other = np.random.default_rng(5).normal(size=len(sheet)) * 400.0
    mixed = sheet(2.0 * dense.readings - 3.0 * other).pressure
    apart = 2.0 * sheet(dense.readings).pressure - 3.0 * sheet(other).pressure
    assert off(mixed, apart) < 1e-6


def test_a_silent_taxel_is_left_out() -> None:
    sheet, dense = fine_pair()
    silent = np.random.default_rng(6).choice(len(sheet), 40, replace=False)
    readings = dense.readings.copy()
    readings[silent] = np.nan
    heard = ~np.isnan(readings)
    white = 1.0 / sheet.noise_std
    spread = dense.matrix @ np.linalg.inv(np.eye(len(sheet)) - dense.model.matrix @ dense.matrix)
    cross = (spread * white**-2)[:, heard]  # Q A^T
    gram = dense.model.matrix[heard] @ cross
    exact = cross @ np.linalg.solve(gram + np.diag(white[heard] ** -2), readings[heard])
    sheet(dense.readings)  # from which it starts
    estimate = sheet(readings)
    assert off(estimate.pressure, exact) < 5e-4
    assert (estimate.valid == heard).all()
    assert np.isnan(estimate.residual[silent]).all()
    assert off(sheet(dense.readings).pressure, dense.pressure) < 5e-4, "they stay silent"


def test_no_taxel_answers() -> None:
    estimate = usual_pair()[0](np.full(len(PLACES), np.nan))
    assert not estimate.pressure.any()
    assert (estimate.iterations, usual_pair()[0].relative_residual) == (0, 0.0)


def test_a_press_beyond_the_corner_is_found_there() -> None:
    sheet, dense = fine_pair()
    corner = PLACES.min(axis=0) - 2e-3
    pressed = 2e4 * np.exp(-np.square(dense.model.grid.plane - corner).sum(axis=1) / 9e-3**2)
    exact = dense.matrix @ (dense.model.matrix @ pressed)
    assert off(sheet(dense.model.matrix @ pressed).pressure, exact) < 5e-4
    assert sheet.origin[0] < PLACES[:, 0].min() - (sheet.plan.stamps.spread.reach - 1) * sheet.pitch


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
def test_the_residual_is_what_it_says(tolerance: float) -> None:
    sheet = sf.Sheet(PLACES, LAYER, tolerance=tolerance, cut=1e-4, precision=np.float64)
    dense = fine_pair()[1]
    estimate = sheet(dense.readings)
    assert sheet.relative_residual <= tolerance
    # Where the noise accounts for what is left, the pressure is off by about as much.
    assert off(estimate.pressure, dense.pressure) < 2 * tolerance + 5e-4


def test_residual_is_reading_less_prediction() -> None:
    sheet, dense = fine_pair()
    estimate = sheet(dense.readings)
    exact = dense.readings - dense.model.matrix @ dense.pressure
    assert off(estimate.residual, exact) < 2e-2  # it is some 1e-2 of the readings


def test_from_the_reading_before() -> None:
    sheet, dense = usual_pair()
    sheet.reset()
    cold = sheet(dense.readings)
    rng = np.random.default_rng(7)
    warm = [sheet(dense.readings + rng.normal(size=len(sheet))) for _ in range(100)]
    assert max(estimate.iterations for estimate in warm) < cold.iterations
    assert sheet.relative_residual <= sheet.tolerance
    assert off(warm[-1].pressure, dense.pressure) < 2e-2
    again = sheet(-dense.readings)  # farther from the one before than from nothing
    assert off(again.pressure, -dense.pressure) < 5e-3


def test_a_deadline_stops_it() -> None:
    sheet, dense = usual_pair()
    sheet.reset()
    full = sheet(dense.readings, deadline=60.0)
    assert full.deadline_met
    sheet.reset()
    late = sheet(dense.readings, deadline=1e-9)
    assert not late.deadline_met
    assert late.iterations == 0
    assert sheet.relative_residual == pytest.approx(1.0)


def test_a_new_sheet_knows_what_a_reading_takes() -> None:
    sheet = sf.Sheet(PLACES, LAYER)
    readings = usual_pair()[1].readings
    prompt = sheet(readings, deadline=60.0)
    assert prompt.deadline_met
    sheet.reset()
    assert prompt.iterations == sheet(readings).iterations, "it began from nothing"


def test_noise_of_each_taxel_counts() -> None:
    noise = np.where(PLACES[:, 0] > PLACES[:, 0].mean(), 4000.0, 400.0)
    sheet = sf.Sheet(PLACES, LAYER, noise_std=noise, tolerance=1e-5)
    dense = dense_of(sheet, sf.GaussianField())
    assert off(sheet(dense.readings).pressure, dense.pressure) < 5e-3


def test_it_allocates_nothing_per_reading() -> None:
    sheet = sf.Sheet(jittered(60, np.random.default_rng(8)), LAYER)
    readings = np.random.default_rng(9).normal(size=len(sheet)).astype(np.float32) * 100
    out = np.empty(len(sheet.grid), dtype=np.float32)
    sheet.apply(readings, out)
    tracemalloc.start()
    sheet.apply(readings, out)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 7200, "an array of taxels has 14,400 bytes; views and numbers some 4,500"


def test_fields_are_those_of_the_grid() -> None:
    from skinfield.elastic import Deformation

    sheet, dense = usual_pair()
    estimate = sheet(dense.readings)
    whole = Deformation(dense.model.grid, LAYER, sheet.mechanics)
    exact = whole(estimate.pressure.astype(np.float64))
    assert np.abs(estimate.displacement - exact).max() < 1e-4 * np.abs(exact).max()
    assert estimate.indentation == pytest.approx(-estimate.displacement[:, 2])
    assert (estimate.traction[:, 2] == -estimate.pressure).all()
    assert not estimate.traction[:, :2].any()


def test_displacement_does_not_know_of_strips() -> None:
    from skinfield.elastic import Deformation

    sheet = sf.Sheet(np.outer([0.0, 1.0, 2.0, 3.0], [3e-3, 0.3]), LAYER)
    pressure = np.random.default_rng(0).normal(size=len(sheet.grid))
    exact = Deformation(sheet.grid, LAYER, sheet.mechanics)(pressure)
    assert sheet.shape[0] > 600
    assert np.abs(sheet.displacement(pressure) - exact).max() < 1e-4 * np.abs(exact).max()


def test_force_of_a_press() -> None:
    sheet, dense = fine_pair()
    exact = dense.pressure.sum() * sheet.pitch**2
    assert sheet(dense.readings).normal_force == pytest.approx(exact, rel=5e-4)


def test_one_taxel() -> None:
    sheet = sf.Sheet([[0.01, 0.02]], LAYER)
    estimate = sheet([500.0])
    peak = sheet.grid.plane[np.argmax(estimate.pressure)]
    assert np.abs(peak - [0.01, 0.02]).max() <= sheet.pitch


def test_lonely_and_coincident_taxels() -> None:
    places = np.array([[0.0, 0.0], [0.0, 0.0], [40e-3, 0.0]])
    sheet = sf.Sheet(places, LAYER, solver=sf.Tikhonov(), tolerance=1e-6, noise_std=100.0)
    dense = dense_of(sheet, sf.Tikhonov(), places)
    assert off(sheet(dense.readings).pressure, dense.pressure) < 5e-3
