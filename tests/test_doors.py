"""One reading has the same contacts through every door, bit for bit."""

import json
from dataclasses import replace

import numpy as np
import pytest
from command_line import result_of, run

import skinfield as sf
from skinfield.cli import options
from skinfield.cli.report import plain_contacts
from skinfield.estimate.contact_table import rows_from_estimate
from skinfield.estimate.row_contacts import contacts_of_rows
from skinfield.files import save_recording
from skinfield.files.results import read_results
from skinfield.skin.reading import Recording

PATCH, LAYER, NOISE = sf.layouts.icub_triangle(), sf.Layer(), 0.002
GRID = sf.Grid.square(PATCH, nodes=12)
STATED = ("position", "force", "covariance", "area_std", "axes", "outline", "cells")
WORDS = ("--skin", "icub_triangle", "--grid", 12, "--noise", NOISE, "--profile", "silicone-2mm")


@pytest.fixture(scope="module")
def readings():
    """Six of one press, the first as `skinfield demo` makes it."""
    ball = sf.simulate.Sphere(position=(1e-3, 2e-3), force=1.0, radius=4e-3)
    extent = 2 * float(np.abs(PATCH.plane).max()) + 12e-3
    true = sf.simulate.press(LAYER, [ball], extent=extent, cell=min(0.4e-3, extent / 40))
    clean, rng = true.capacitance(PATCH.plane, PATCH.pad_diameter), np.random.default_rng(0)
    return clean + np.stack([rng.normal(scale=NOISE, size=len(PATCH)) for _ in range(6)])


@pytest.fixture(scope="module")
def rec():
    return sf.Reconstructor(PATCH, LAYER, GRID, noise_std=NOISE)


def rows(estimate):
    return [row[3:] for row in rows_from_estimate(estimate, 0, 0)]


def test_one_name_is_the_default_of_library_and_commands(rec):
    assert rec.solver == options.solver_of(options.USUAL_SOLVER) == sf.Auto()


def test_runs_are_their_readings_one_after_the_other(rec, readings):
    rec.reset()
    each = [rec(reading) for reading in readings]
    rec.reset()
    together = rec(readings)
    assert together.solver == ("ContactFit",) * 6
    assert not together.is_field.any()
    assert rows(together) == [row for one in each for row in rows(one)]
    assert together.normal_force.tolist() == [
        sum(contact.normal_force for contact in found) for found in together.contacts
    ]
    rec.reset()
    out = rec.rows()
    for one, other, reading in zip(together, each, readings, strict=True):
        assert rec.into(reading, out) == len(one.contacts) == 1
        np.testing.assert_array_equal(one.contacts[0].covariance, other.contacts[0].covariance)
        (row,) = contacts_of_rows(out[:1], GRID, one.pressure)
        for name in STATED:
            np.testing.assert_array_equal(getattr(row, name), getattr(one.contacts[0], name))
    skin = sf.Skin((PATCH, replace(PATCH, name="next")))
    engine = sf.Engine(skin, LAYER, rungs=(12,), solver=sf.Auto(), noise_std=NOISE)
    rec.reset()
    first = rec(readings[0]).contacts[0]
    for patch in engine([readings[0]] * 2, budget=10.0).values():
        for name in STATED:
            np.testing.assert_array_equal(
                getattr(patch.contacts[0], name), getattr(first, name), name
            )


def test_commands_give_what_a_reconstructor_gives(rec, readings, tmp_path, monkeypatch):
    rec.reset()
    expected = rec(readings)
    monkeypatch.chdir(tmp_path)
    said = result_of("demo", *WORDS, "--press", "1,2,1,4")
    assert (said["solver"], len(said["contacts"])) == ("ContactFit", 1)
    assert said["contacts"] == json.loads(json.dumps(plain_contacts(expected.contacts[0])))
    stamps = np.arange(6) * 20_000_000
    save_recording(Recording(stamps, readings, unit="dC/C0"), tmp_path / "press.npz")
    run("reconstruct", "press.npz", *WORDS, "-o", "press.skinfield")
    results = read_results("press.skinfield")
    np.testing.assert_array_equal(results.values(0, 6), readings)
    assert rows(results.estimates(0, 6)) == rows(expected)
    assert rows(results.estimate(4)) == rows(expected[4])
    table = sf.load_contacts("press.skinfield").to_pylist()
    assert [tuple(row.values())[3:] for row in table] == rows(expected)
    assert sf.open_results("press.skinfield").normal_force.values.tolist() == (
        expected.normal_force.tolist()
    )


def test_a_field_that_answers_is_summed_and_says_why():
    patch = sf.layouts.hexagon72()
    rec = sf.Reconstructor(patch, sf.Layer(poisson_ratio=0.3), noise_std=NOISE)
    wave = 2 * np.pi * rec.model.grid.plane / 30e-3
    broad = rec.model.matrix @ (1.0 + 0.5 * np.sin(wave).prod(axis=1))
    est = rec(0.15 * broad / broad.max())
    assert (est.solver, est.is_field) == ("NonNegative", True)
    assert est.notes == ("more probable than few contacts: a field answers",)
    assert est.normal_force == est.pressure.sum() * est.grid.cell_area
