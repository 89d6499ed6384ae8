"""One patch from readings to contacts: the prepared chain against its parts, and bad input."""

import copy
import pickle
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import skinfield as sf
from skinfield.elastic import Deformation
from skinfield.errors import InputError

LAYER = sf.Layer(2e-3, 150e3, 0.5)
PATCH = sf.layouts.hexagon72()
GRID = sf.Grid.square(PATCH, nodes=16)
WHITE: dict[str, Any] = {"quantity": sf.BaseStress(), "solver": sf.Tikhonov(), "noise_std": 400.0}
REC = sf.Reconstructor(PATCH, LAYER, GRID, **WHITE)
CAPACITANCE = sf.Reconstructor(PATCH, LAYER, GRID)

BALL = sf.simulate.Sphere(radius=6e-3, position=tuple(PATCH.plane[30].tolist()), force=1.5)
PRESS = sf.simulate.press(LAYER, [BALL], extent=60e-3, cell=0.6e-3)
STRESS = PRESS.base_stress(PATCH.plane, PATCH.pad_diameter)


@pytest.mark.parametrize("quantity", ["stress", "capacitance"])
@pytest.mark.parametrize("solver", [sf.Tikhonov(), sf.GaussianField(), sf.PseudoInverse()])
def test_a_press_on_a_taxel_is_found(quantity: str, solver: object) -> None:
    """The truth is a contact solved on another grid, with the pads' nonlinear electrostatics."""
    read = {"stress": sf.BaseStress(), "capacitance": sf.Capacitance()}[quantity]
    noise = read.typical_noise
    grid = sf.Grid.square(PATCH, nodes=40)
    rec = sf.Reconstructor(PATCH, LAYER, grid, quantity=read, solver=solver, noise_std=noise)
    readings = PRESS.readings(PATCH.plane, PATCH.pad_diameter, quantity)
    readings = readings + np.random.default_rng(0).normal(scale=noise, size=72)
    contact = rec(readings).contacts[0]
    assert np.linalg.norm(contact.position[:2] - PATCH.plane[30]) < 1.2e-3
    # On a taxel a smooth field is too wide, and reads high; between taxels it reads low.
    assert 0.9 < contact.normal_force / 1.5 < 1.6


def test_fields_are_the_parts_put_together() -> None:
    estimate = REC(STRESS)
    pressure = REC.solver.prepare(REC.model).matrix @ STRESS
    assert estimate.pressure == pytest.approx(pressure)
    assert estimate.traction == pytest.approx(-pressure[:, None] * [0, 0, 1.0])
    moved = Deformation(GRID, LAYER, REC.mechanics)(pressure)
    assert estimate.displacement == pytest.approx(moved, abs=1e-12)
    assert estimate.force.sum(axis=0)[2] == pytest.approx(-estimate.normal_force)
    assert estimate.indentation == pytest.approx(-moved[:, 2], abs=1e-12)
    assert estimate.residual == pytest.approx(STRESS - REC.model.matrix @ pressure)
    assert estimate.latency > 0


def test_a_batch_is_its_readings_one_by_one() -> None:
    readings = STRESS * np.linspace(0.2, 1.2, 5)[:, None]
    readings[1, 7] = np.nan
    batch = REC(readings, stamp_ns=np.arange(5))
    assert batch.pressure.shape == (5, len(GRID))
    assert batch.displacement.shape == (5, len(GRID), 3)
    assert len(batch) == len(batch.contacts) == 5
    for index, each in enumerate(batch):
        alone = REC(readings[index])
        assert each.pressure == pytest.approx(alone.pressure)
        assert each.pressure_std == pytest.approx(alone.pressure_std)
        assert each.valid.tolist() == alone.valid.tolist()
        assert [c.normal_force for c in each.contacts] == pytest.approx(
            [c.normal_force for c in alone.contacts]
        )
        assert each.stamp_ns == index


def test_apply_is_the_call_and_allocates_nothing() -> None:
    for precision, close in ((np.float64, 1e-12), (np.float32, 2e-5)):
        rec = sf.Reconstructor(PATCH, LAYER, GRID, solver=sf.GaussianField(), precision=precision)
        readings = (STRESS * 1e-6).astype(precision)
        out = np.empty(4 * len(GRID), precision)
        rec.apply(readings, out)
        estimate = rec(readings)
        peak = np.abs(estimate.pressure).max()
        assert out[: len(GRID)] == pytest.approx(estimate.pressure, abs=close * peak)
        moved = out[len(GRID) :].reshape(3, -1).T
        deepest = np.abs(estimate.displacement).max()
        assert moved == pytest.approx(estimate.displacement, abs=close * deepest)
        tracemalloc.start()
        before = tracemalloc.get_traced_memory()[0]
        tracemalloc.reset_peak()
        for _ in range(100):
            rec.apply(readings, out)
        _, highest = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert highest - before < 2000  # bytes: Python's own integers, no array


ZEROS = np.zeros(72)


def test_contacts_are_counted_without_room_for_them() -> None:
    read = PRESS.capacitance(PATCH.plane, PATCH.pad_diameter)
    assert CAPACITANCE.into(read, CAPACITANCE.rows(0)) == 1


@pytest.mark.parametrize(
    ("readings", "how", "message"),
    [
        (np.zeros(71), {}, r"readings has shape \(1, 71\), expected \(any, 72\)"),
        (np.zeros((2, 3, 72)), {}, r"readings has shape \(2, 3, 72\), expected \(any, 72\)"),
        (np.zeros((0, 72)), {}, "readings is empty, expected one reading or more"),
        (np.full(72, np.nan), {}, r"readings\[0\] has no valid taxel \(1 of 1 readings\)"),
        (np.r_[np.zeros(71), np.inf], {}, r"readings\[0, 71\] is inf, expected finite numbers"),
        (["a"] * 72, {}, r"readings is .* expected numbers"),
        (np.r_[-1.0, np.zeros(71)], {}, r"readings\[0, 0\] is -1.0, expected between -1 and 100"),
        (np.r_[np.zeros(71), 1e30], {}, r"readings\[0, 71\] is 1e\+30, .* mark such taxels with"),
        (ZEROS, {"valid": np.ones(3)}, r"valid has shape \(3,\), expected \(72,\)"),
        (ZEROS, {"stamp_ns": np.arange(3)}, r"stamp_ns has shape \(3,\), expected one, or \(1,\)"),
        (ZEROS, {"stamp_ns": "now"}, "stamp_ns is 'now', expected whole nanoseconds"),
        (ZEROS, {"deadline": "x"}, "deadline is .* seconds for each reading"),
        (ZEROS, {"deadline": 0.0}, "deadline is .* seconds for each reading"),
        (ZEROS, {"deadline": np.nan}, "deadline is .* seconds for each reading"),
        (ZEROS, {"deadline": True}, "deadline is True, .* seconds for each reading"),
    ],
)
def test_bad_readings_are_named(readings: Any, how: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        CAPACITANCE(readings, **how)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"patch": "hexagon72"}, r"patch is 'hexagon72', expected a Patch: such as layouts\."),
        ({"layer": 2e-3}, r"layer is 0.002, expected a Layer: such as Layer\(thickness=2e-3"),
        ({"grid": 40}, r"grid is 40, expected a Grid: such as Grid.square"),
        ({"mechanics": "half-space"}, r"mechanics is 'half-space', a string; .*: sf.HalfSpace\(\)"),
        (
            {"quantity": "capacitance"},
            r"quantity is 'capacitance', a string; .*: sf.Capacitance\(\)",
        ),
        ({"quantity": sf.BaseStress}, r"the class BaseStress, .*: give BaseStress\(\)"),
        ({"solver": "contact"}, r"solver is 'contact', a string; .*: sf.ContactFit\(\)$"),
        ({"solver": sf.ContactFit}, r"the class ContactFit, .*: give ContactFit\(\)"),
        ({"finder": 1e-3}, r"finder is 0.001, .* one such as ContactFinder\(\)"),
    ],
)
def test_parts_of_a_wrong_kind_are_named_with_the_right_one(
    arguments: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        sf.Reconstructor(**({"patch": PATCH} | arguments))  # type: ignore[arg-type]


def test_a_grid_may_come_from_another_patch_of_the_same_surface_only() -> None:
    twin = sf.Reconstructor(sf.layouts.hexagon72(), LAYER, GRID, **WHITE)
    assert twin(STRESS).pressure == pytest.approx(REC(STRESS).pressure)
    assert twin(STRESS).grid.positions == pytest.approx(GRID.positions)
    raised = sf.Patch(PATCH.positions + np.array([0, 0, 2e-3]))
    with pytest.raises(
        InputError, match="grid lies on patch 'hexagon72', whose surface is up to 2"
    ):
        sf.Reconstructor(raised, LAYER, GRID)


@pytest.mark.parametrize("solver", [sf.Tikhonov(), sf.GaussianField(), sf.PseudoInverse()])
def test_a_window_sees_its_part_of_the_whole(solver: object) -> None:
    """The same lattice over the whole patch, cut to the window, is the window's answer."""
    window = sf.Grid.window(PATCH, (-0.006, -0.012), (0.009, 0.003), pitch=3e-3)
    whole = sf.Grid.window(PATCH, (-0.030, -0.030), (0.030, 0.030), pitch=3e-3)
    inside = [int(np.argmin(np.linalg.norm(whole.plane - node, axis=1))) for node in window.plane]
    assert whole.plane[inside] == pytest.approx(window.plane)
    both = [
        sf.Reconstructor(PATCH, LAYER, grid, quantity=sf.BaseStress(), solver=solver)(STRESS)
        for grid in (window, whole)
    ]
    peak = both[1].pressure.max()
    # Solvers may count nodes beyond the taxels a little: the whole has some, the window none.
    assert both[0].pressure == pytest.approx(both[1].pressure[inside], abs=0.02 * peak)
    deepest = np.abs(both[1].displacement).max()
    assert both[0].displacement == pytest.approx(both[1].displacement[inside], abs=0.02 * deepest)


def test_a_press_beside_a_window_is_not_pushed_into_it() -> None:
    x, y = PATCH.plane[30]
    away = sf.Grid.window(PATCH, (-x - 4e-3, -y - 4e-3), (-x + 4e-3, -y + 4e-3), pitch=1e-3)
    estimate = sf.Reconstructor(PATCH, LAYER, away, quantity=sf.BaseStress())(STRESS)
    assert estimate.contacts == ()
    assert abs(estimate.normal_force) < 0.1
    here = sf.Grid.window(PATCH, (x - 5e-3, y - 5e-3), (x + 5e-3, y + 5e-3), pitch=1e-3)
    estimate = sf.Reconstructor(PATCH, LAYER, here, quantity=sf.BaseStress())(STRESS)
    assert 0.9 < estimate.contacts[0].normal_force / 1.5 < 1.6


def test_a_window_that_no_taxel_sees_is_refused() -> None:
    far = sf.Grid.window(PATCH, (0.1, 0.1), (0.12, 0.12), pitch=2e-3)
    with pytest.raises(InputError, match=r"nearest node is .* mm from any taxel of 'hexagon72'"):
        sf.Reconstructor(PATCH, LAYER, far)


def test_noise_alone_gives_contacts_at_the_stated_rate() -> None:
    for quantity in (sf.Capacitance(), sf.BaseStress()):
        rec = sf.Reconstructor(PATCH, LAYER, GRID, quantity=quantity)
        spread = quantity.typical_noise
        noise = np.random.default_rng(5).normal(scale=spread, size=(4000, 72))
        assert sum(bool(found) for found in rec(noise).contacts) <= 10  # 1e-3, and three sigma


def test_a_single_estimate_says_that_it_is_single() -> None:
    estimate = REC(STRESS)
    with pytest.raises(InputError, match="one reading has no length"):
        len(estimate)
    with pytest.raises(InputError, match="one reading cannot be indexed"):
        estimate[0]


def test_a_curved_patch_presses_inwards_everywhere() -> None:
    patch = sf.layouts.cylinder(radius=40e-3)
    rec = sf.Reconstructor(patch, LAYER, sf.Grid.square(patch, 20), quantity=sf.BaseStress())
    readings = np.zeros(len(patch))
    readings[len(patch) // 2] = 2e4
    contact = rec(readings).contacts[0]
    assert contact.normal_force > 0
    assert contact.position == pytest.approx(patch.positions[len(patch) // 2], abs=1.5e-3)
    assert contact.normal == pytest.approx(patch.normals[len(patch) // 2], abs=0.1)


@pytest.mark.parametrize("solver", [sf.GaussianField(), sf.NonNegative(), sf.Auto()])
def test_what_is_computed_later_is_of_the_reading_that_was(solver: Any) -> None:
    rec = sf.Reconstructor(PATCH, LAYER, GRID, quantity=sf.BaseStress(), solver=solver)
    readings = np.full(len(PATCH), 5e3)
    whole = rec(readings[None])
    rec.reset()
    prompt = rec(readings)
    readings[:] = 0.0
    rec(readings)
    for name in ("pressure", "displacement", "residual", "pressure_std", "traction"):
        expected = getattr(whole, name)[0]
        assert np.allclose(getattr(prompt, name), expected, atol=1e-9 * np.abs(expected).max())
    assert [c.normal_force for c in prompt.contacts] == pytest.approx(
        [c.normal_force for c in whole.contacts[0]]
    )


@pytest.mark.parametrize("solver", [sf.GaussianField(), sf.Auto()], ids=repr)
def test_a_copy_and_what_another_process_gets_answer_the_same(solver: Any) -> None:
    rec = sf.Reconstructor(PATCH, LAYER, GRID, solver=solver, noise_std=0.001)
    readings = PRESS.readings(PATCH.plane, PATCH.pad_diameter, "capacitance")
    copies = copy.deepcopy(rec), pickle.loads(pickle.dumps(rec))
    expected = rec(readings)
    for each in copies:
        found = each(readings)
        assert np.array_equal(found.pressure, expected.pressure)
        assert found.normal_force == expected.normal_force


@pytest.mark.parametrize("solver", [sf.GaussianField(), sf.NonNegative()], ids=repr)
def test_threads_may_share_a_reconstructor(solver: object) -> None:
    rec = sf.Reconstructor(PATCH, LAYER, GRID, quantity=sf.BaseStress(), solver=solver)
    rows = [scale * STRESS for scale in np.linspace(0.5, 1.5, 40)]
    expected = [rec(row).pressure for row in rows]
    with ThreadPoolExecutor(4) as threads:
        for mine, alone in zip(threads.map(rec, rows), expected, strict=True):
            assert np.allclose(mine.pressure, alone, atol=5e-3 * alone.max())
