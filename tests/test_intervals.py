"""Intervals: do they hold the truth as often as they say, and are files what was written?"""

import contextlib
import json
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import skinfield as sf
from skinfield.errors import FileError, Floats, InputError
from skinfield.estimate import Contact, Estimate
from skinfield.reconstruct import Intervals, load_intervals, save_intervals
from skinfield.reconstruct.interval_training import (
    Rehearsal,
    _carried,
    _solved,
    learn,
    nearest,
    rehearse,
)
from skinfield.simulate import Bar, Cylinder, Sphere, press
from skinfield.skin import Grid
from skinfield.solve.contract import square_patch

PATCH = square_patch(side=8, pitch=5e-3)
LAYER = sf.Layer(2e-3, 100e3, 0.5)
LEVELS = (0.5, 0.68, 0.9)
REST = ("pressure", "traction", "displacement", "pressure_std", "residual", "valid")
KNOWN = (Sphere(radius=4e-3), Sphere(radius=9e-3), Cylinder(radius=3e-3))
OTHERS = (Sphere(radius=6e-3), Cylinder(radius=4e-3))


def pretended(bias: float, spread: float) -> Callable[[Floats], Estimate]:
    """A solver that is told the truth in its readings, x, y, force and area, and errs from it.

    Half its contacts err three times as much, and say so, but all state half of what they err.
    """
    grid, rng = Grid.square(PATCH, nodes=4), np.random.default_rng(8)

    def solve(readings: Floats) -> Estimate:
        x, y, force, area = readings[:4]
        wrong = spread * (1.0 if rng.uniform() < 0.5 else 3.0)
        found = force / np.exp(bias + wrong * rng.standard_normal())
        off = 1e-3 * wrong * rng.standard_normal(2) * (1.0, 2.0)
        stated = np.diag([1e-3 * wrong, 2e-3 * wrong, wrong * found]) / 2
        contact = Contact.later(
            None,
            position=np.array([x + off[0], y + off[1], 0.0]),
            force=np.array([0.0, 0.0, -found]),
            normal=np.array([0.0, 0.0, 1.0]),
            area=area * np.exp(wrong * rng.standard_normal()),
            covariance=stated**2,
            spread=None,
        )
        rest = dict.fromkeys(REST, np.zeros(0))
        return Estimate(grid=grid, contacts=(contact,), **rest)

    return solve


def invented(count: int, seed: int) -> Rehearsal:
    rng = np.random.default_rng(seed)
    places, forces = rng.uniform(-0.015, 0.015, (count, 2)), 10 ** rng.uniform(-1, 0.5, count)
    areas = rng.uniform(1e-5, 1e-4, count)
    readings = np.zeros((count, len(PATCH)))
    readings[:, :4] = np.column_stack([places, forces, areas])
    return Rehearsal(readings, places, forces, areas, np.zeros(count))


def shares(
    solve: Callable[[Floats], Estimate],
    learnt: Intervals,
    rehearsal: Rehearsal,
    readings: Floats,
) -> dict[str, Floats]:
    """How often intervals at LEVELS, and the covariance at 90 %, hold the truth."""
    rows = []
    for row, reading in enumerate(readings):
        truth = np.append(rehearsal.places[row], 0.0)
        contact = nearest(learnt(solve(reading).contacts), truth)
        if contact is None:
            continue
        off, force = (truth - contact.position)[:2], rehearsal.forces[row]
        wide = contact.covariance
        rows.append(
            [
                *(np.ptp([*contact.force_interval(v), force]) <= np.ptp(contact.force_interval(v))
                  for v in LEVELS),
                *(np.hypot(*off) <= contact.place_radius(v) for v in LEVELS),
                *(np.ptp([*contact.area_interval(v), rehearsal.areas[row]])
                  <= np.ptp(contact.area_interval(v)) for v in LEVELS),
                abs(force - contact.normal_force) <= 1.645 * contact.force_std,
                off @ np.linalg.solve(wide[:2, :2], off) <= 4.605,
            ]
        )  # fmt: skip
    mean = np.mean(rows, axis=0)
    return {"force": mean[:3], "place": mean[3:6], "area": mean[6:9], "covariance": mean[9:]}


@pytest.mark.parametrize(("bias", "spread"), [(0.0, 0.05), (1.0, 0.3)])
def test_whatever_a_solver_states_intervals_hold_the_truth(bias: float, spread: float) -> None:
    solve = pretended(bias, spread)
    learnt = learn(solve, PATCH, invented(900, 1), np.full(len(PATCH), 1e-30), "None", "x")
    test = invented(1500, 2)
    found = shares(solve, learnt, test, test.readings)
    for name in ("force", "place", "area"):  # 600 and 1500 presses: 1.7 % and 1.0 % at 90 %
        assert found[name] == pytest.approx(LEVELS, abs=0.07), name
    assert found["covariance"] == pytest.approx(0.9, abs=0.05)


def test_sure_and_unsure_contacts_have_intervals_of_their_own() -> None:
    solve = pretended(0.0, 0.05)
    learnt = learn(solve, PATCH, invented(900, 1), np.full(len(PATCH), 1e-30), "None", "x")
    assert len(learnt.groups) > 1
    reading = invented(1, 3).readings[0]
    each = [learnt(solve(reading).contacts)[0] for _ in range(200)]
    width = np.array([np.log(np.divide(*contact.force_interval()[::-1])) for contact in each])
    assert np.quantile(width, 0.9) == pytest.approx(3 * np.quantile(width, 0.1), rel=0.35)
    assert all(np.linalg.eigvalsh(contact.covariance).min() > 0 for contact in each)


@lru_cache(maxsize=1)
def calibrated() -> tuple[sf.Reconstructor, sf.Reconstructor]:
    reconstruct = sf.Reconstructor(
        PATCH, LAYER, Grid.square(PATCH, nodes=24), solver=sf.GaussianField(),
        quantity=sf.BaseStress(), noise_std=400.0,
    )  # fmt: skip
    return reconstruct, reconstruct.calibrated(presses=300, seed=4, bodies=KNOWN)


def intervals() -> Intervals:
    learnt = calibrated()[1].intervals
    assert learnt is not None
    return learnt


def pressed() -> Floats:
    """Readings (L,) of an even pressure about the middle."""
    plain, _ = calibrated()
    return plain.model.matrix @ np.where(np.hypot(*plain.grid.plane.T) < 4e-3, 5e4, 0.0)


def test_intervals_hold_for_bodies_and_seeds_not_seen() -> None:
    _, reconstruct = calibrated()
    rehearsal = rehearse(PATCH, LAYER, sf.BondedLayer(), sf.BaseStress(), 300, 77, OTHERS)
    noise = 400.0 * np.random.default_rng(6).standard_normal(rehearsal.readings.shape)
    raw = reconstruct.with_intervals(None)
    found = shares(raw, intervals(), rehearsal, rehearsal.readings + noise)
    assert 0.84 <= found["force"][2] <= 0.97  # 90 %, some 250 of them: 1.9 %
    assert 0.84 <= found["place"][2] <= 0.97
    assert (found["covariance"] > 0.84).all()
    assert (found["covariance"] < 0.98).all()


def test_a_calibrated_reconstructor_shares_what_is_prepared() -> None:
    plain, reconstruct = calibrated()
    assert reconstruct.plan.fields is plain.plan.fields
    reading = pressed()
    (bare, *_), (contact, *_) = plain(reading).contacts, reconstruct(reading).contacts
    assert bare.spread is None
    assert contact.spread is not None
    assert (bare.position == contact.position).all()
    assert (bare.force == contact.force).all()
    low, high = contact.force_interval(0.5)
    assert contact.force_interval(0.9)[0] < low < high < contact.force_interval(0.9)[1]
    low, high = bare.force_interval()
    assert (low + high) / 2 == pytest.approx(bare.normal_force)
    assert bare.place_radius(0.9) > bare.place_radius(0.5) > 0
    batch = reconstruct(np.stack([reading, reading]))
    assert batch.contacts[1][0].force_std == pytest.approx(contact.force_std)


def test_too_few_presses_are_named() -> None:
    plain, reconstruct = calibrated()
    with pytest.raises(InputError, match=r"presses is 12, of which .* were found, expected 61"):
        plain.calibrated(presses=12, seed=4, bodies=KNOWN)
    with pytest.raises(InputError, match="presses is 0"):
        plain.calibrated(presses=0)
    reading = pressed()
    contact = reconstruct(reading).contacts[0]
    with pytest.raises(InputError, match=r"level is 0.9999, expected at most .* calibrate"):
        contact.force_interval(0.9999)
    with pytest.raises(InputError, match=r"level is 0.9999, expected at most .* calibrate"):
        contact.place_radius(0.9999)
    with pytest.raises(InputError, match=r"level is 1\.2"):
        contact.force_interval(1.2)


def test_intervals_of_another_reconstructor_are_refused() -> None:
    plain, learnt = calibrated()[0], intervals()
    same = sf.Reconstructor(
        PATCH, LAYER, plain.grid, solver=sf.GaussianField(), quantity=sf.BaseStress(),
        noise_std=420.0, intervals=learnt,
    )  # fmt: skip
    reading = pressed()
    assert same(reading).contacts[0].spread is not None
    for other, what in (
        ({"solver": sf.Tikhonov()}, "solver 'GaussianField', expected 'Tikhonov'"),
        ({"quantity": sf.Capacitance()}, "quantity 'stress', expected 'ΔC/C₀'"),
        ({"noise_std": 900.0}, "noise_std 400, expected about 900"),
    ):
        setting: dict[str, Any] = {"solver": sf.GaussianField(), "quantity": sf.BaseStress()}
        setting |= {"noise_std": 400.0, **other}
        with pytest.raises(InputError, match=what):
            sf.Reconstructor(PATCH, LAYER, plain.grid, intervals=learnt, **setting)


def test_a_rehearsed_press_reads_as_one_that_is_made_there() -> None:
    """A bar that is carried and turned with the taxels against a bar that is pressed there."""
    bar = Bar(length=8e-3, width=3e-3, edge_radius=0.5e-3)
    solved = _solved(bar, 0.8, LAYER, sf.BondedLayer(), PATCH.pad_diameter, "capacitance")
    assert solved is not None
    places = np.array([(3e-3, -1e-3), (-6e-3, 2e-3)])
    rehearsal = _carried(np.random.default_rng(1), PATCH, [solved] * 2, places)
    for row in range(2):
        body = replace(
            bar,
            force=float(rehearsal.forces[row]),
            position=(float(rehearsal.places[row, 0]), float(rehearsal.places[row, 1])),
            rotation=float(rehearsal.angles[row]),
        )
        made = press(LAYER, [body], 40e-3, 0.5e-3)
        readings = made.readings(PATCH.plane, PATCH.pad_diameter, "capacitance")
        error = np.abs(readings - rehearsal.readings[row]).max()
        assert error < 0.02 * np.abs(readings).max()


def test_intervals_survive_a_file(tmp_path: Path) -> None:
    learnt = intervals()
    save_intervals(learnt, tmp_path / "learnt.json")
    again = load_intervals(tmp_path / "learnt.json")
    assert (again.solver, again.detected, again.place_floor) == (
        learnt.solver,
        learnt.detected,
        learnt.place_floor,
    )
    for one, other in zip(again.groups, learnt.groups, strict=True):
        assert all((vars(one)[name] == vars(other)[name]).all() for name in vars(one))
    with pytest.raises(FileError, match="cannot be read"):
        load_intervals(tmp_path / "none.json")
    with pytest.raises(FileError, match="cannot be written"):
        save_intervals(learnt, tmp_path / "none" / "learnt.json")


ODD = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=4),
                st.lists(st.floats(), max_size=3), st.just({}), st.just(10**400))  # fmt: skip


@settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.data())
def test_garbage_in_a_file_is_refused(tmp_path: Path, data: st.DataObject) -> None:
    learnt = intervals()
    path = tmp_path / "learnt.json"
    save_intervals(learnt, path)
    good = json.loads(path.read_text())
    learnt = good["intervals"]
    inner = data.draw(st.sampled_from([good, learnt, learnt["force"], learnt["groups"][0]]))
    inner[data.draw(st.sampled_from(sorted(inner)))] = data.draw(ODD)
    path.write_text(json.dumps(good))
    with contextlib.suppress(FileError):  # some changes are harmless
        load_intervals(path)(())


@settings(
    max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.one_of(st.binary(max_size=80), st.just(b"[" * 100_000)))
def test_any_bytes_are_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "learnt.json"
    path.write_bytes(content)
    with pytest.raises(FileError, match="expected"):
        load_intervals(path)


def test_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from test_readme import ROOT, follow

    monkeypatch.chdir(tmp_path)
    assert follow(ROOT / "docs" / "uncertainty.md") == (3, 0)
