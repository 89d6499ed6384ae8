"""Readings that lack taxels: as if the solver had been prepared without them."""

from dataclasses import replace

import numpy as np
import pytest

import skinfield as sf
from skinfield.elastic import ObservationModel
from skinfield.estimate import Contact, Estimate, PressureNoise
from skinfield.solve import LinearOperator, Solver
from skinfield.solve.linear import PITCHES, taxel_distance

PATCH = sf.layouts.hexagon72()
LAYER = sf.Layer(2e-3, 100e3, 0.4)
GRID = sf.Grid.square(PATCH, nodes=24)
LENGTH = PITCHES * taxel_distance(PATCH.plane, 1.0)  # that of all taxels, whichever are there
SMOOTH = sf.GaussianField(length_scale=LENGTH, common_mode=5.0)
SURE = sf.GaussianField(snr=200.0, length_scale=1e-3, common_mode=5.0)
SOLVERS = [SMOOTH, SURE, sf.Tikhonov(common_mode=5.0), sf.Tikhonov(snr=1.0, common_mode=5.0)]
NOISE = np.linspace(1e-3, 3e-3, 72)
FIELDS = ("pressure", "displacement", "pressure_std", "traction")


class Anew:
    """A solver that says nothing of how it answers without some taxels: prepared each time."""

    def __init__(self, solver: Solver) -> None:
        self.solver = solver

    def prepare(self, model: ObservationModel) -> LinearOperator:
        known = prepared(self.solver, model)
        return replace(known, solver=self, gaussian=None)


def prepared(solver: Solver, model: ObservationModel) -> LinearOperator:
    """Prepare for some taxels, with the offset that all of them are taken to share."""
    common = 5.0 * np.median(NOISE) / np.median(model.noise_std)
    return replace(solver, common_mode=common).prepare(model)


def matrix_of(operator: LinearOperator) -> np.ndarray:
    return operator.matrix @ operator.filled(np.eye(72)).T


def masks(silent: int, count: int = 3, seed: int = 8) -> np.ndarray:
    rng = np.random.default_rng([seed, silent])
    valid = np.ones((count, 72), dtype=np.bool_)
    for row in valid:
        row[rng.choice(72, silent, replace=False)] = False
    return valid


@pytest.fixture(scope="module")
def pressed() -> np.ndarray:
    """Readings of a ball and a bar together, fading in, with noise."""
    bodies = [
        sf.simulate.Sphere(radius=6e-3, position=(-9e-3, 6e-3), force=1.0),
        sf.simulate.Cylinder(radius=3e-3, position=(12e-3, -8e-3), force=1.5),
    ]
    press = sf.simulate.press(LAYER, bodies, extent=70e-3, cell=1e-3)
    change = press.capacitance(PATCH.positions, PATCH.pad_diameter)
    noise = np.random.default_rng(3).normal(size=(12, 72)) * NOISE
    return np.linspace(0.0, 1.0, 12)[:, None] * change + noise


def reconstructor(solver: object, **settings: object) -> sf.Reconstructor:
    return sf.Reconstructor(PATCH, LAYER, GRID, solver=solver, noise_std=NOISE, **settings)


def apart(mine: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(mine - other).max() / np.abs(other).max())


def assert_same_contact(mine: Contact, other: Contact) -> None:
    assert mine.cells.tolist() == other.cells.tolist()
    for name in ("position", "force", "moment", "area", "peak_pressure", "outline", "angle"):
        assert getattr(mine, name) == pytest.approx(getattr(other, name), rel=1e-9, abs=1e-12)
    scale = np.sqrt(np.diagonal(other.covariance))
    wrong = (mine.covariance - other.covariance) / np.outer(scale, scale)
    assert np.abs(wrong).max() < 1e-6  # factors are in single precision


def assert_same(mine: Estimate, other: Estimate) -> None:
    """Of one reading, or of several."""
    for name in FIELDS:
        assert apart(getattr(mine, name), getattr(other, name)) < 1e-9, name
    assert mine.residual == pytest.approx(other.residual, rel=1e-9, abs=1e-12, nan_ok=True)
    assert np.array_equal(mine.valid, other.valid)
    assert not np.any(mine.gap)
    assert not np.any(other.gap)
    several = mine.pressure.ndim == 2
    ours, theirs = (each.contacts if several else (each.contacts,) for each in (mine, other))
    for found, expected in zip(ours, theirs, strict=True):
        for contact, twin in zip(found, expected, strict=True):
            assert_same_contact(contact, twin)


@pytest.mark.parametrize("solver", SOLVERS, ids=repr)
def test_fields_and_contacts_are_those_of_a_fresh_plan(solver: Solver, pressed: np.ndarray) -> None:
    mine, other = reconstructor(solver), reconstructor(Anew(solver))
    assert mine.plan.gaussian is not None
    assert other.plan.gaussian is None
    valid = np.concatenate([masks(0, 2), masks(1), masks(5), masks(71), masks(40, 1)])
    valid[6] = valid[3]  # a set that comes twice
    assert_same(mine(pressed, valid=valid), other(pressed, valid=valid))
    assert sum(map(len, mine(pressed, valid=valid).contacts)) > 10
    for row in (1, 4, 11):  # one by one, again, and by NaN
        assert_same(mine(pressed[row], valid=valid[row]), other(pressed, valid=valid)[row])
        silent = np.where(valid[row], pressed[row], np.nan)
        assert_same(mine(silent), other(pressed, valid=valid)[row])


@pytest.mark.parametrize("solver", SOLVERS, ids=repr)
def test_what_is_stated_of_sets_of_taxels_is_that_of_solvers_prepared_for_them(solver) -> None:
    model = reconstructor(solver).model
    whole = solver.prepare(model)
    valid = np.concatenate([masks(silent, 1) for silent in (0, 1, 3, 40, 71)])
    cells, weights = np.arange(100, 200), np.random.default_rng(1).normal(size=(2, 100))
    for mask in valid:
        other, alone = prepared(solver, model.subset(mask)), whole.without(mask)
        posterior, noise = alone.posterior, alone.noise
        assert apart(matrix_of(alone)[:, mask], other.matrix) < 1e-9
        assert posterior.std == pytest.approx(other.pressure_std(), rel=1e-9)
        moved = PressureNoise(other.matrix * model.noise_std[mask])
        assert noise.std == pytest.approx(moved.std, rel=1e-9)  # far cells too, 1e-6 of the rest
        assert noise.felt == moved.felt
        for mine, theirs in ((posterior, other.posterior), (noise, moved)):
            spread = theirs.covariance_of_sums(cells, weights)
            assert apart(mine.covariance_of_sums(cells, weights), spread) < 1e-9


def test_in_single_precision_and_in_a_window(pressed: np.ndarray) -> None:
    window = sf.Grid(PATCH, (9, 8), GRID.pitch, GRID.origin + 6 * GRID.pitch)
    valid = masks(3, 12)
    for settings, error in (({}, 1e-9), ({"precision": np.float32}, 3e-6)):
        parts = {"solver": SMOOTH, "noise_std": NOISE}
        mine = sf.Reconstructor(PATCH, LAYER, window, **parts, **settings)
        other = sf.Reconstructor(PATCH, LAYER, window, **parts | {"solver": Anew(SMOOTH)})
        assert len(mine.model.grid) > len(window)
        found, expected = mine(pressed, valid=valid), other(pressed, valid=valid)
        for name in FIELDS:
            assert apart(getattr(found, name), getattr(expected, name)) < error


def test_many_sets_are_those_prepared_for_them(pressed: np.ndarray) -> None:
    solver = sf.Tikhonov(common_mode=5.0)
    mine, other = reconstructor(solver), reconstructor(Anew(solver))
    count = 37
    valid = masks(2, count)
    readings = np.resize(pressed, (count, 72))
    assert_same(mine(readings, valid=valid), other(readings, valid=valid))


def test_model_errors_hold_without_taxels(pressed: np.ndarray) -> None:
    mine, valid = reconstructor(SMOOTH), masks(2, 1)[0]
    stated, plans = mine(pressed[-1], valid=valid), mine.plans
    operator = plans.of(valid)
    (bare, *_) = plans.find.finder(mine.grid, stated.pressure, operator.noise, operator.posterior)
    more = stated.contacts[0].covariance - bare.covariance
    expected = mine.plan.model_error.covariance(stated.contacts[0].normal_force)
    assert more == pytest.approx(expected, rel=1e-6, abs=1e-12)


def test_other_solvers_are_prepared_anew(pressed: np.ndarray) -> None:
    for solver in (sf.PseudoInverse(), sf.Inverse()):
        mine = reconstructor(solver)
        assert mine.plan.gaussian is None
        valid = masks(1, 1)[0]
        made = solver.prepare(mine.model.subset(valid))
        expected = made.matrix @ sf.Capacitance().linearise(
            pressed[-1, valid], np.empty(valid.sum())
        )
        assert apart(mine(pressed[-1], valid=valid).pressure, expected) < 1e-9
        without = solver.prepare(mine.model).without(valid).matrix[:, valid]
        assert np.array_equal(without, made.matrix)


def test_the_default_length_stays_that_of_all_taxels() -> None:
    free = sf.GaussianField(common_mode=5.0)
    whole = free.prepare(reconstructor(free).model)
    spaced = np.zeros(72, dtype=np.bool_)
    spaced[::9] = True  # far from each other: prepared alone, their prior would be longer
    fixed = reconstructor(SMOOTH).model
    alone, own = matrix_of(whole.without(spaced))[:, spaced], fixed.subset(spaced)
    assert apart(alone, prepared(SMOOTH, own).matrix) < 1e-9
    assert apart(alone, free.prepare(own).matrix) > 0.1
