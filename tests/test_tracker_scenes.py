"""Moving contacts: their readings against presses solved where they are, and numbers counted."""

import json

import numpy as np
import pytest
from test_tracker import contact, estimate

import skinfield as sf
from skinfield.estimate import TrackedContact
from skinfield.lab.paper import paper_patch
from skinfield.lab.report import PAPER_LAYER, SMOKE, Section, Settings
from skinfield.lab.sections.tracks import tracks, tracks_parts
from skinfield.lab.tracking import (
    NEAREST,
    TRACKER,
    Nearest,
    Numbering,
    Scene,
    exact_readings,
    scenes,
)
from skinfield.simulate import Sphere, press

CELL = 0.5e-3
SETTINGS = Settings(size=SMOKE)


@pytest.mark.parametrize(("distance", "low", "high"), [(12e-3, 0.0, 0.01), (5e-3, 0.01, 0.08)])
def test_readings_of_two_balls_beside_those_of_the_two_solved_together(
    distance: float, low: float, high: float
) -> None:
    """As part of the highest: nothing at 12 mm; at 5 mm each ball feels the other a little."""
    patch, middle = paper_patch(), np.array([8e-3, 5e-3])
    ways, forces = np.array([[-distance / 2, 0.0], [distance / 2, 0.0]]), np.array([1.5, 1.0])
    balls = [
        Sphere(radius=6e-3, force=float(force), position=(float(x), 0.0))
        for (x, _), force in zip(ways, forces, strict=True)
    ]
    solved = press(PAPER_LAYER, balls, distance + 8e-3, CELL)
    for quantity in ("stress", "capacitance"):
        scene = Scene("two", (middle + ways)[None], forces[None])
        (added,) = exact_readings(scene, PAPER_LAYER, CELL, quantity)
        exact = solved.readings(patch.plane - middle, patch.pad_diameter, quantity)
        assert low < np.abs(added - exact).max() / exact.max() < high


def test_scenes_are_what_they_say() -> None:
    made = {scene.name: scene for scene in scenes(50.0, 1)}
    slide = np.linalg.norm(np.diff(made["slide"].places[:, 0], axis=0), axis=1) * 50.0
    assert slide.max() == pytest.approx(0.04)
    assert slide.sum() / 50.0 == pytest.approx(0.04, abs=1e-4)
    for name, nearest in (("cross", 12e-3), ("meet", 5e-3)):
        apart = np.linalg.norm(made[name].places[:, 0] - made[name].places[:, 1], axis=1)
        assert apart.min() == pytest.approx(nearest, rel=0.02)
        assert apart.max() > 25e-3
    assert made["taps"].touches.any(axis=0).sum() == 5
    assert made["taps"].touches.sum(axis=1).max() == 1
    assert not made["idle"].touches.any()


def counts(**changes: int) -> dict[str, int]:
    return {"switches": 0, "whole": 0, "missed": 0, "false": 0, "coasting": 0} | changes


def test_switches_are_counted_by_hand() -> None:
    """A ball that is seen as 0, 0, missed, 1, 1 beside a false one: one switch, and one miss."""
    steps, place = Numbering(), np.zeros((1, 2))
    here, there = contact(0.5, 0.0, 1.0), contact(20.0, 0.0, 1.0)
    for found in ([(0, here)], [(0, here)], [], [(1, here), (2, there)], [(1, here)]):
        steps.add([0], place, found)
    assert steps.counts() == counts(switches=1, missed=1, false=1)
    assert steps.hits[0][-1] == pytest.approx([5e-4, 0.0])


def test_a_ball_keeps_its_number_while_it_is_near() -> None:
    steps = Numbering()
    steps.add([0], np.zeros((1, 2)), [(0, contact(1.0, 0.0, 1.0))])
    both = [(1, contact(0.1, 0.0, 1.0)), (0, contact(3.0, 0.0, 1.0))]
    steps.add([0], np.zeros((1, 2)), both)
    assert steps.counts() == counts(whole=1, false=1)


def test_coasting_is_not_false() -> None:
    tracker, steps = sf.Tracker(), Numbering()
    tracker(estimate([contact(0.0, 0.0, 1.0)]))
    (coasts,) = tracker(estimate([]))
    assert isinstance(coasts, TrackedContact)
    steps.add([], np.empty((0, 2)), [(0, coasts)])
    assert steps.counts() == counts(coasting=1)


def test_the_nearest_one_before_gives_its_number() -> None:
    nearest = Nearest()
    first = nearest(estimate([contact(0.0, 0.0, 1.0), contact(10.0, 0.0, 1.0)]))
    then = nearest(estimate([contact(11.0, 0.0, 1.0), contact(-9.0, 0.0, 1.0)]))
    assert [number for number, _ in first] == [0, 1]
    assert [number for number, _ in then] == [1, 2]


def test_the_section_of_the_smoke_size() -> None:
    (part,) = tracks_parts(SETTINGS)
    result = json.loads(json.dumps(part.function(*part.arguments)))  # as a campaign keeps it
    section = tracks(SETTINGS, [result])
    assert isinstance(section, Section)
    assert section.pictures[0].png.startswith(b"\x89PNG")
    rows = {(row[2], row[3]): row for row in section.tables[0].rows}
    crossing = "two that pass at 12 mm"
    assert rows[crossing, TRACKER][4] <= rows[crossing, NEAREST][4]
    assert rows["noise alone", TRACKER][-1] == ""  # nothing is told
