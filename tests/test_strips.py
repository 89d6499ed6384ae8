"""Fingers in readings: which atoms are one contact where the model is far off."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from skinfield.compiled import njit
from skinfield.solve.atoms.fit_kernel import NOW, READINGS
from skinfield.solve.atoms.rows_kernel import Drawing, divide, join_strip
from skinfield.solve.atoms.strips_kernel import LONE, NONE, Strips, join_by_strips

PITCH, THICKNESS = 6.5e-3, 2e-3  # m
COLUMNS = np.stack(np.meshgrid(np.arange(16.0), np.arange(12.0)), axis=-1).reshape(-1, 2)
PLACES = COLUMNS * PITCH / THICKNESS
NOISE = np.full(len(PLACES), 3e-3)


class Memory(NamedTuple):
    """What of a fit's memory strips go by."""

    counts: np.ndarray
    taxels: np.ndarray
    atoms: np.ndarray


@njit
def join(places: Any, memory: Any, noise: Any, error: float, strips: Any, out: Any) -> bool:
    """`join_by_strips` for Python."""
    return bool(join_by_strips(places, memory, 0.0, noise, error, strips, out))


def readings_of(fingers: list[tuple[float, float, float, float]], seed: int = 0) -> np.ndarray:
    """Fingers from (x, y) to (x, y), in columns: taxels within 0.8 of one read half to all."""
    rng, readings = np.random.default_rng(seed), np.zeros(len(PLACES))
    for x, y, to_x, to_y in fingers:
        along = np.array([to_x - x, to_y - y])
        share = np.clip((COLUMNS - (x, y)) @ along / max(along @ along, 1e-9), 0.0, 1.0)
        away = np.linalg.norm(COLUMNS - (x, y) - share[:, None] * along, axis=1)
        readings += np.where(away < 0.8, 0.5 * rng.uniform(0.5, 1.0, len(PLACES)), 0.0)
    return readings


def strips_of(readings: np.ndarray, atoms: list[tuple[float, float]], error: float) -> list[int]:
    """Strip of each atom; atoms in columns."""
    count, out = len(atoms), np.zeros(12, np.int64)
    room = np.zeros((NOW + 1, 12, 6))
    room[NOW, :count, :2] = np.array(atoms) * PITCH / THICKNESS
    taxels = np.zeros((READINGS + 1, len(PLACES)))
    taxels[READINGS] = readings
    memory = Memory(np.full(NOW + 1, count), taxels, room)
    join(PLACES, memory, NOISE, error, Strips.of(PLACES, THICKNESS), out)
    return list(out[:count])


LAID_DOWN = [(3.0, 3.0), (5.0, 3.0), (8.0, 3.0)]


@pytest.mark.parametrize("seed", range(5))
def test_atoms_along_a_finger_are_one_contact(seed: int) -> None:
    readings = readings_of([(3.0, 3.0, 8.0, 3.0)], seed)
    assert strips_of(readings, LAID_DOWN, 0.2) == [0, 0, 0]


@pytest.mark.parametrize("seed", range(5))
def test_fingers_side_by_side_are_several(seed: int) -> None:
    fingers = [(3.0, y, 8.0, y) for y in (2.0, 5.0, 8.0)]
    found = strips_of(readings_of(fingers, seed), [(5.0, y) for y in (2.0, 5.0, 8.0)], 0.2)
    assert sorted(found) == [0, 1, 2]


def test_tips_far_from_each_other_are_several() -> None:
    tips = [(2.0, 2.0, 3.0, 2.0), (12.0, 2.0, 13.0, 2.0)]
    found = strips_of(readings_of(tips), [(2.5, 2.0), (12.5, 2.0)], 0.2)
    assert sorted(found) == [0, 1]


def test_a_trusted_model_says_by_itself_how_many_touch() -> None:
    readings = readings_of([(3.0, 3.0, 8.0, 3.0)])
    assert strips_of(readings, LAID_DOWN, 0.05) == [LONE, LONE, LONE]


def test_atoms_where_nothing_reads_are_no_contact() -> None:
    readings = readings_of([(3.0, 3.0, 8.0, 3.0)])
    assert strips_of(readings, [(5.0, 3.0), (13.0, 10.0)], 0.2) == [0, NONE]
    assert strips_of(readings, [(1.0, 10.0), (13.0, 10.0)], 0.2) == [LONE, LONE]


def test_more_touched_taxels_than_there_is_room_for_end_in_strips() -> None:
    readings = np.full(len(PLACES), 0.5)
    found = strips_of(readings, [(x, 5.0) for x in range(12)], 0.2)
    assert set(found) <= set(range(NONE, 12))


def test_a_ring_in_a_strip_is_drawn_within_its_memory() -> None:
    drawing = Drawing.of(2)
    drawing.sums[1] = 1e-3
    drawing.covariance[:] = 1.0
    join_strip.py_func(drawing, 5, 0, 3)  # type: ignore[attr-defined]
    assert (drawing.order[:3] == 5).all()
    assert (drawing.sums[1, :3] == 0.0).all()
    assert (drawing.covariance[0] == 1.0).all()
    assert not drawing.covariance[1:3].any()


def test_a_wide_atom_is_divided_among_the_strips_that_it_reads_for() -> None:
    strips, drawing = Strips.of(PLACES, THICKNESS), Drawing.of(4)
    drawing.atoms[0, :4] = 5.0 * PITCH, 2.5 * PITCH, 3.0, 0.02
    strips.middle[:2] = [(5.0 * PITCH / THICKNESS, y * PITCH / THICKNESS, 1.0) for y in (2.0, 5.0)]
    strips.middle[1, 2] = 0.5
    drawing.covariance[0] = np.eye(8)
    assert divide.py_func(drawing, strips, 0, THICKNESS, 1) == 0  # type: ignore[attr-defined]
    assert divide.py_func(drawing, strips, 1, THICKNESS, 1) == 1  # type: ignore[attr-defined]
    assert drawing.atoms[:2, 2] == pytest.approx([2.0, 1.0])
    assert drawing.atoms[1, :2] == pytest.approx([5.0 * PITCH, 5.0 * PITCH])
    assert drawing.covariance[:2, 2, 2] == pytest.approx([4.0 / 9.0, 1.0 / 9.0])
    assert drawing.covariance[1, 0, 0] > 1.0
    assert drawing.owner[1] == 1
