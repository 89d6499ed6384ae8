"""Mechanics that nobody stated: chosen by evidence, press by press, with a note."""

import re
import time
from dataclasses import replace

import numpy as np
import pytest

import skinfield as sf
from skinfield.elastic import ObservationModel
from skinfield.solve.atoms import table
from skinfield.solve.atoms.mechanics_choice import MAKING, MechanicsChoice, other_physics

PATCH, LAYER, NOISE, FORCE = sf.layouts.hexagon72(), sf.Layer(), 5e-4, 1.5
GRID = sf.Grid.square(PATCH, nodes=12)
PLACES = np.array([[0.0, 1.0], [-8.0, 3.0], [6.0, -7.0], [3.0, 8.0], [-5.0, -6.0]]) * 1e-3
WORLDS = {
    "": (LAYER, sf.BondedLayer()),
    "Poisson's ratio were 0.45": (replace(LAYER, poisson_ratio=0.45), sf.BondedLayer()),
    "an inextensible cover": (LAYER, sf.BondedLayer(inextensible_cover=True)),
}


def presses(layer, mechanics):
    """Readings of one ball at each of the places."""
    ball = sf.simulate.Sphere(radius=7e-3, force=FORCE)
    true = sf.simulate.press(layer, [ball], extent=24e-3, cell=0.3e-3, mechanics=mechanics)
    rng = np.random.default_rng(4)
    for place in PLACES:
        clean = true.capacitance(PATCH.plane - place, PATCH.pad_diameter)
        yield clean + rng.normal(scale=NOISE, size=len(PATCH))


@pytest.fixture(scope="module")
def operator():
    physics = sf.Capacitance()
    model = ObservationModel.of(PATCH, LAYER, GRID, sf.BondedLayer(), physics, NOISE)
    return sf.ContactFit().prepare(model)


@pytest.mark.parametrize("clause", WORLDS)
def test_presses_tell_what_the_skin_is_made_of(operator, clause):
    data, errors, notes = operator.data(), [], []
    for reading in presses(*WORLDS[clause]):
        solution = operator.solve(reading, data)
        (contact,) = operator.contacts(solution)
        errors.append(abs(contact.normal_force - FORCE) / contact.force_std)
        notes.append(" ".join(solution.notes))
    assert max(errors[2:]) < 2.6
    assert ("as if" in notes[-1]) == bool(clause)
    assert clause in notes[-1]
    assert not clause or re.search(r"\(probability (above )?0\.9\d over [345] presses\)", notes[-1])
    assert contact.force_std < 0.2 * FORCE  # it is sure again
    data.reset()
    solution = operator.solve(np.zeros(len(PATCH)), data)
    assert not any("as if" in note for note in solution.notes)


def test_one_press_alone_leaves_the_mechanics_open(operator):
    alone = replace(operator.solver, check_mechanics=False).prepare(operator.model)
    reading = next(presses(*WORLDS["Poisson's ratio were 0.45"]))
    (wide,), (narrow,) = (
        each.contacts(each.solve(reading, each.data())) for each in (operator, alone)
    )
    assert wide.normal_force == pytest.approx(narrow.normal_force, rel=0.02)
    assert wide.force_std > 1.5 * narrow.force_std


def test_a_half_space_has_no_other_mechanics(operator):
    physics = operator.model.physics
    assert [clause for clause, _ in other_physics(physics)] == [
        "its Poisson's ratio were 0.45 or less, as of a foam",
        "it had an inextensible cover",
    ]
    softer = replace(physics, layer=replace(LAYER, poisson_ratio=0.4))
    assert other_physics(softer)[0][1].layer.poisson_ratio == 0.5
    assert not other_physics(replace(physics, mechanics=sf.HalfSpace()))


def test_tables_are_kept_on_disk(operator, tmp_path, monkeypatch):
    made, read = [], table.atom_tables.__wrapped__
    monkeypatch.setattr(table, "cache_folder", lambda file: tmp_path)
    monkeypatch.setattr(
        table, "tabulate", lambda physics: made.append(1) or operator.fitter.fit_model.tables
    )
    physics = operator.model.physics
    first, second = read(physics), read(physics)
    assert len(made) == 1
    for one, other in zip(first, second, strict=True):
        np.testing.assert_array_equal(one, other)
        assert type(one) is type(other)
    (file,) = tmp_path.iterdir()
    file.write_bytes(b"half of it")
    read(physics)
    assert len(made) == 2
    monkeypatch.setattr(table, "cache_folder", lambda file: tmp_path / "gone")
    read(physics)  # though nothing can be written
    assert len(made) == 3


def test_no_table_is_made_under_a_deadline(operator):
    other = sf.ContactFit().prepare(operator.model)
    reading = next(presses(*WORLDS[""]))
    soon = time.perf_counter_ns() + MAKING
    (wide,) = other.contacts(other.solve(reading, other.data(), soon))
    assert not other.fitter.mechanics.is_ready
    (sure,) = operator.contacts(operator.solve(reading, operator.data()))
    assert wide.normal_force == pytest.approx(sure.normal_force, rel=0.01)
    assert wide.force_std > 1.5 * sure.force_std  # as nobody compared them
    other.solve(reading, other.data())
    assert other.fitter.mechanics.is_ready


def sliding(layer, mechanics, count, force=FORCE):
    """Readings of a ball that slides over the skin, 0.5 mm from one to the next."""
    ball = sf.simulate.Sphere(radius=7e-3, force=force)
    true = sf.simulate.press(layer, [ball], extent=24e-3, cell=0.3e-3, mechanics=mechanics)
    rng = np.random.default_rng(5)
    for k in range(count):
        clean = true.capacitance(PATCH.plane - [(k % 24 - 12) * 5e-4, 1e-3], PATCH.pad_diameter)
        yield clean + rng.normal(scale=NOISE, size=len(PATCH))


def test_a_contact_that_slides_is_one_press(operator):
    data, skin = operator.data(), WORLDS["an inextensible cover"]
    for reading in sliding(*skin, 20):
        operator.solve(reading, data)
    assert data.choice.acting == 0
    for _ in range(2):  # other presses tell it
        operator.solve(np.zeros(len(PATCH)), data)
        operator.solve(*sliding(*skin, 1), data)
    assert data.choice.acting == 2


def test_mechanics_are_tried_beside_the_readings_of_a_contact_that_goes_on(operator, monkeypatch):
    decided, data = [], operator.data()
    decide = MechanicsChoice._decide
    monkeypatch.setattr(MechanicsChoice, "_decide", lambda it: decided.append(1) or decide(it))
    operator.solve(*sliding(*WORLDS[""], 1, 0.3 * FORCE), data)
    assert len(decided) == 1  # a press that begins is tried at once
    counts = []
    for reading in sliding(*WORLDS[""], 23):  # it became stronger
        operator.solve(reading, data)
        counts.append(len(decided))
    assert counts[4] == 1
    for reading in sliding(*WORLDS[""], 23):
        operator.solve(reading, data)
        if len(decided) > 1:
            return
    raise AssertionError("no other mechanics were tried in all that time")
