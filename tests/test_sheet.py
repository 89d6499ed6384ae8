"""A sheet of many taxels and its contacts against dense solutions on the same cells; refusals."""

import tracemalloc
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
import pytest

import skinfield as sf
from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, InputError
from skinfield.estimate import PressureNoise
from skinfield.solve.sheet.contacts import TILE, WindowNoise, windows

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


def test_prediction_is_the_models() -> None:
    sheet, dense = fine_pair()
    field = np.random.default_rng(1).normal(size=len(sheet.grid))
    exact = dense.model.matrix @ field
    assert off(sheet.predict(field), exact) < 1e-3


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
    assert np.array_equal(estimate.readings[heard], readings[heard])
    repaired = np.abs(estimate.readings - dense.readings)[silent] / estimate.readings_std[silent]
    assert 0.5 < np.mean(repaired < 1.0) < 1.0
    assert np.isnan(estimate.residual[silent]).all()
    assert off(sheet(dense.readings).pressure, dense.pressure) < 5e-4, "they stay silent"


def test_no_taxel_answers() -> None:
    estimate = usual_pair()[0](np.full(len(PLACES), np.nan))
    assert not estimate.pressure.any()
    assert not estimate.readings.any()
    assert np.isinf(estimate.readings_std).all()
    assert estimate.contacts == ()
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


def test_displacement_does_not_know_of_blocks() -> None:
    from skinfield.elastic import Deformation

    sheet = sf.Sheet(np.outer(np.linspace(0.0, 3.0, 16), [0.25, 0.3]), LAYER)
    pressure = np.random.default_rng(0).normal(size=len(sheet.grid))
    exact = Deformation(sheet.grid, LAYER, sheet.mechanics)(pressure)
    assert min(sheet.shape) > 500
    assert np.abs(sheet.displacement(pressure) - exact).max() < 1e-4 * np.abs(exact).max()


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


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"positions": np.zeros((0, 2))}, "at least one taxel"),
        ({"positions": np.zeros((5, 3))}, r"shape \(5, 3\)"),
        ({"positions": [[0.0, np.nan]]}, "positions"),
        ({"positions": PLACES * 1e3}, "metres"),
        ({"pitch": 0.0}, "pitch"),
        ({"pitch": 1e-300}, "pitch is 1e-300, expected a number from 1e-06 to 1"),
        ({"pitch": 1e300}, "pitch"),
        ({"pad_diameter": np.nan}, "pad_diameter"),
        ({"noise_std": -1.0}, r"noise_std\[0\]"),
        ({"noise_std": 1e-300}, r"noise_std\[0\]"),
        ({"noise_std": np.inf}, r"noise_std\[0\]"),
        ({"noise_std": np.ones(3)}, "one per taxel"),
        ({"solver": sf.PseudoInverse()}, "GaussianField"),
        ({"layer": 2e-3}, "Layer"),
        ({"quantity": sf.Gap}, "object"),
        ({"mechanics": "bonded"}, "BondedLayer"),
        ({"finder": sf.ContactFinder}, "object"),
        ({"cut": 0.5}, "cut"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"most_iterations": 0}, "most_iterations"),
        ({"precision": np.int32}, "precision"),
        ({"pitch": 0.2e-3}, "larger cells"),
        ({"solver": sf.GaussianField(length_scale=12e-3)}, "length_scale"),
        ({"quantity": sf.Gap(pad_averaged=False), "mechanics": sf.HalfSpace()}, "edges"),
    ],
    ids=lambda value: value if isinstance(value, str) else next(iter(value)),
)
def test_what_cannot_be_used_is_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        sf.Sheet(**{"positions": PLACES, "layer": LAYER, **arguments})


def test_wrong_readings_are_refused() -> None:
    sheet = usual_pair()[0]
    with pytest.raises(InputError, match="one per taxel"):
        sheet(np.zeros(3))
    with pytest.raises(InputError, match=r"readings\[7\] is inf"):
        sheet(np.where(np.arange(len(sheet)) == 7, np.inf, 0.0))
    out = np.empty(len(sheet.grid), dtype=np.float32)
    with pytest.raises(InputError, match="float64"):
        sheet.apply(np.zeros(len(sheet)), out)
    with pytest.raises(InputError, match=r"one per cell of sheet\.grid"):
        sheet.apply(np.zeros(len(sheet), dtype=np.float32), out[1:])


@pytest.mark.parametrize("reading", [1e300, -1e300, 1e30])
def test_readings_beyond_single_precision_are_refused(reading: float) -> None:
    sheet, dense = usual_pair()
    before = sheet(dense.readings).pressure
    readings = dense.readings.copy()
    readings[7] = reading
    with pytest.raises(InputError, match=r"readings\[7\] is .*expected at most 1e\+12 times its"):
        sheet(readings)
    out = np.empty(len(sheet.grid), dtype=np.float32)
    single = dense.readings.astype(np.float32)
    for wrong in (np.inf, 3e38):
        single[7] = wrong
        with pytest.raises(InputError, match="deviations of their noise, expected finite ones"):
            sheet.apply(single, out)
    again = sheet(dense.readings).pressure
    assert np.abs(again - before).max() < 1e-2 * before.max(), "it goes on as before"


def test_the_highest_reading_that_is_taken_is_answered() -> None:
    sheet = usual_pair()[0]
    sheet.reset()
    unit = sheet(np.where(np.arange(len(sheet)) == 7, sheet.noise_std, 0.0)).pressure
    sheet.reset()
    most = sheet(np.where(np.arange(len(sheet)) == 7, 1e12 * sheet.noise_std, 0.0)).pressure
    assert np.abs(most - 1e12 * unit).max() < 1e-4 * most.max()
    sheet.reset()


def test_a_capacitance_that_no_pad_has_is_refused() -> None:
    sheet = sf.Sheet(PLACES[:5], LAYER, quantity=sf.Capacitance())
    for reading in (-1.0, -3.0):
        with pytest.raises(InputError, match=r"readings\[2\] is -.*expected above -1"):
            sheet([0.0, 0.0, reading, 0.0, 0.0])
    with pytest.raises(InputError, match="deviations of their noise"):
        sheet([0.0, 0.0, np.nextafter(-1.0, 0.0), 0.0, 0.0])


@pytest.mark.parametrize("deadline", [1e10, 1e300])
def test_a_deadline_beyond_reason_is_none(deadline: float) -> None:
    sheet, dense = usual_pair()
    sheet.reset()
    free = sheet(dense.readings)
    sheet.reset()
    late = sheet(dense.readings, deadline=deadline)
    assert late.deadline_met
    assert late.iterations == free.iterations


def test_taxels_too_dense_for_the_cut_are_told() -> None:
    """Cut late, the matrix is positive definite; cut early, it has eigenvalues below 0."""
    places = np.random.default_rng(0).uniform(-20e-3, 0, (60, 2)) * [1.0, 0.0]
    fine = sf.Sheet(places, LAYER, solver=sf.Tikhonov(snr=30.0), cut=1e-4)
    _ = fine(fine.noise_std).contacts
    coarse = sf.Sheet(places, LAYER, solver=sf.Tikhonov(snr=30.0), cut=2e-2)
    with pytest.raises(InputError, match="positions are so dense"):
        _ = coarse(np.random.default_rng(1).normal(size=60)).contacts


def test_contacts_of_taxels_in_one_place() -> None:
    sheet = sf.Sheet(np.full((150, 2), 3e-3), LAYER, solver=sf.Tikhonov())
    readings = sheet.noise_std * (50.0 + np.random.default_rng(0).normal(size=150))
    (contact,) = sheet(readings).contacts
    assert np.abs(contact.position[:2] - 3e-3).max() < 0.2e-3


def assert_on_the_lattice(sheet: sf.Sheet) -> None:
    rows, columns = sheet.shape
    for stamp in (sheet.plan.stamps.read, sheet.plan.stamps.spread):
        column, row = (sheet.plan.placing.cell - (stamp.reach - 1)).T
        corner = sheet.plan.placing.corner(stamp.reach, columns)
        assert (corner == row * columns + column).all()
        assert min(column.min(), row.min()) >= 0
        assert (column + stamp.width).max() <= columns
        assert (row + 2 * stamp.reach).max() <= rows


def rows_of_taxels() -> Iterator[tuple[Floats, float]]:
    """Places (L, 2) along some directions and far away, and a pitch that divides them."""
    for along, pitch in product(((1.0, 0.0), (0.0, 1.0), (0.6, -0.8)), (1.1e-3, 1.5e-3, 2.7e-3)):
        for far in (0.0, -3 * pitch, 1.0, -1e3, 1e9):
            yield np.outer(np.arange(-9, 10) * 3 * pitch, along) + far, pitch


@pytest.mark.parametrize("length", [0.5e-3, 1.5e-3, 4e-3])
def test_all_stamps_lie_on_the_lattice(length: float) -> None:
    solver, rng = sf.GaussianField(length_scale=length), np.random.default_rng(0)
    cases = list(rows_of_taxels()) if length == 1.5e-3 else []
    for index in range(60):
        places = PLACES[: 1 + index % 7] + rng.uniform(-1.0, 1.0, 2)
        if index % 2:
            places = np.round(places / 1.5e-3) * 1.5e-3  # where rounding decides on the cell
        cases.append((places, 1.5e-3))
    for places, pitch in cases:
        assert_on_the_lattice(sf.Sheet(places, LAYER, pitch=pitch, solver=solver, cut=5e-3))


def test_where_a_sheet_lies_does_not_matter() -> None:
    readings = usual_pair()[1].readings
    expected = usual_pair()[0](readings).pressure
    for shift in ((300, -700), (-67_000, 67_000)):  # cells: half a metre, a hundred
        moved = sf.Sheet(PLACES + np.array(shift) * 1.5e-3, LAYER)
        assert np.abs(moved(readings).pressure - expected).max() < 1e-4 * expected.max()


def test_a_place_that_numbers_cannot_tell_is_refused() -> None:
    for far in (1e14, -1e20, 1e200):
        with pytest.raises(InputError, match="expected metres from an origin on or near the sheet"):
            sf.Sheet(PLACES + far, LAYER)


@pytest.mark.parametrize("fewer", [(2, 0), (0, 2), (0, 0)])
def test_no_stamp_is_written_beside_the_lattice(
    fewer: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Compiled code checks nothing, so it must not be reached."""
    from skinfield.solve.sheet import plan

    around = plan.lattice_of

    def tight(*arguments: Any) -> sf.Grid:
        good = around(*arguments)
        moved = 0.0 if any(fewer) else 0.6  # cells
        shape = good.shape[0] - fewer[0], good.shape[1] - fewer[1]
        return sf.Grid(good.patch, shape, good.pitch, good.origin + moved * good.pitch)

    monkeypatch.setattr(plan, "lattice_of", tight)
    with pytest.raises(InputError, match="rounding moves them by cells"):
        sf.Sheet(PLACES, LAYER)


TOUCHED = np.array([[0.02, 0.02], [0.032, 0.024], [0.065, 0.02], [0.055, 0.06]])


@lru_cache
def solved() -> tuple[sf.Sheet, ObservationModel, Floats, Floats]:
    """A sheet, the dense model of its cells, the dense solver's matrix and readings of touches."""
    places = jittered(14, np.random.default_rng(3))
    noise_std = np.random.default_rng(1).uniform(100.0, 300.0, len(places))
    sheet = sf.Sheet(
        places, LAYER, noise_std=noise_std, cut=3e-4, tolerance=1e-6, precision=np.float64
    )
    dense, pressed = dense_of(sheet, sf.GaussianField(), places), np.zeros(len(sheet.grid))
    for place in TOUCHED:
        pressed += 3e4 * np.exp(-np.square(sheet.grid.plane - place).sum(axis=1) / 5e-3**2)
    noise = np.random.default_rng(4).normal(size=len(places)) * noise_std
    return sheet, dense.model, dense.matrix, dense.model.matrix @ pressed + noise


def test_noise_is_that_of_the_dense_solver() -> None:
    sheet, _, matrix, _ = solved()
    exact = PressureNoise(matrix * sheet.noise_std)
    noise = WindowNoise.whole(sheet.plan, np.ones(len(sheet), dtype=bool))
    assert np.abs(noise.std - exact.std).max() < 1e-3 * exact.std.max()
    cells = np.flatnonzero(np.random.default_rng(0).uniform(size=len(exact.std)) < 0.03)
    weights = np.random.default_rng(1).normal(size=(3, len(cells)))
    covariance = exact.covariance_of_sums(cells, weights)
    error = np.abs(noise.covariance_of_sums(cells, weights) - covariance)
    assert error.max() < 2e-3 * np.abs(covariance).max()


def test_contacts_are_the_dense_solvers() -> None:
    sheet, model, matrix, readings = solved()
    found = sheet(readings).contacts
    noise = PressureNoise(matrix * sheet.noise_std)
    exact = sf.ContactFinder()(model.grid, matrix @ readings, noise)
    assert len(found) == len(exact) >= len(TOUCHED)
    for mine, other in zip(found, exact, strict=True):
        assert np.abs(mine.position - other.position).max() < 20e-6
        assert mine.normal_force == pytest.approx(other.normal_force, rel=3e-3)
        assert mine.force_std == pytest.approx(other.force_std, rel=3e-3)
        assert len(np.setxor1d(mine.cells, other.cells)) <= 0.05 * len(other.cells)


def test_an_idle_sheet_has_no_contact() -> None:
    """The finder's rate is one false alarm in a thousand readings."""
    sheet = sf.Sheet(jittered(30, np.random.default_rng(5)), LAYER, noise_std=200.0)
    rng = np.random.default_rng(6)
    for _ in range(10):
        assert sheet(rng.normal(size=len(sheet)) * 200.0).contacts == ()


def test_faint_and_strong_contacts_far_apart() -> None:
    sheet = sf.Sheet(jittered(40, np.random.default_rng(7)), LAYER, noise_std=20.0)
    rows, columns = np.indices(sheet.shape)
    pressed = np.zeros(sheet.shape)
    for (row, column), peak in (((40, 40), 60e3), ((120, 120), 3e3)):
        pressed += peak * np.exp(-((rows - row) ** 2 + (columns - column) ** 2) / 3.5**2)
    estimate = sheet(sheet.predict(pressed.ravel()))
    found = estimate.contacts  # that drops what is below a fifth of the highest
    assert np.argmax(estimate.pressure) in found[0].cells
    faint = sheet.origin + np.array([120, 120]) * sheet.pitch
    apart = [np.hypot(*(contact.position[:2] - faint)) for contact in found]
    nearest = found[int(np.argmin(apart))]
    assert min(apart) < DISTANCE
    assert nearest.peak_pressure < 0.1 * found[0].peak_pressure


def test_windows_hold_what_is_marked_once() -> None:
    rng = np.random.default_rng(0)
    high = rng.uniform(size=(230, 310)) < 2e-4
    count = np.zeros(high.shape, dtype=int)
    for rows, columns, free in windows(high):
        count[rows, columns] += free
    assert (count[high] == 1).all()
    for row, column in np.argwhere(high):  # with at least a tile around, once or more
        low, left = max(row - TILE, 0), max(column - TILE, 0)
        assert (count[low : row + TILE + 1, left : column + TILE + 1] >= 1).all()
