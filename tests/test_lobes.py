"""Lobes of readings: which atoms are one contact where the model is far off."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from skinfield.compiled import njit
from skinfield.solve.atoms.fit_kernel import NOW, READINGS
from skinfield.solve.atoms.lobes_kernel import LONE, NONE, Lobes, join_by_lobes
from skinfield.solve.atoms.rows_kernel import Drawing, join_lobe

PLACES = np.stack(np.meshgrid(np.arange(12.0), np.arange(6.0)), axis=-1).reshape(-1, 2)
NOISE = np.full(len(PLACES), 1e-3)


class Memory(NamedTuple):
    """What of a fit's memory lobes go by."""

    counts: np.ndarray
    taxels: np.ndarray
    atoms: np.ndarray


@njit
def join(places: Any, memory: Any, noise: Any, error: float, lobes: Any, out: Any) -> bool:
    """`join_by_lobes` for Python."""
    return bool(join_by_lobes(places, memory, 0.0, noise, error, lobes, out))


def readings_of(bumps: dict[tuple[float, float], float]) -> np.ndarray:
    """Round bumps of given heights at given places, read by all taxels."""
    away = [np.square(PLACES - place).sum(axis=1) for place in bumps]
    heights = zip(away, bumps.values(), strict=True)
    return np.sum([height * np.exp(-0.5 * square) for square, height in heights], axis=0)


def lobes_of(readings: np.ndarray, atoms: list[tuple[float, float]], error: float) -> list[int]:
    """Lobe of each atom."""
    count, out = len(atoms), np.zeros(8, np.int64)
    room = np.zeros((NOW + 1, 8, 6))
    room[NOW, :count, :2] = atoms
    taxels = np.zeros((READINGS + 1, len(PLACES)))
    taxels[READINGS] = readings
    memory = Memory(np.full(NOW + 1, count), taxels, room)
    lobes = Lobes.of(PLACES)
    join(PLACES, memory, NOISE, error, lobes, out)
    assert (lobes.wet == -1).all()
    return list(out[:count])


TWO = [(2.0, 2.0), (4.0, 2.0)]


@pytest.mark.parametrize(("apart", "same"), [(2.0, True), (6.0, False)])
def test_a_valley_parts_two_contacts(apart: float, same: bool) -> None:
    atoms = [(2.0, 2.0), (2.0 + apart, 2.0)]
    one, other = lobes_of(readings_of(dict.fromkeys(atoms, 0.1)), atoms, 0.2)
    assert (one == other) == same
    assert min(one, other) >= 0


def test_a_trusted_model_says_by_itself_how_many_touch() -> None:
    assert lobes_of(readings_of(dict.fromkeys(TWO, 0.1)), TWO, 0.05) == [LONE, LONE]


def test_a_valley_within_the_model_error_parts_nothing() -> None:
    readings = readings_of({(2.0, 2.0): 0.1, (5.0, 2.0): 0.1})
    atoms = [(2.0, 2.0), (5.0, 2.0)]
    one, other = lobes_of(readings, atoms, 0.12)
    assert one != other
    one, other = lobes_of(readings, atoms, 0.4)
    assert one == other


def test_atoms_where_nothing_reads_are_no_contact() -> None:
    atoms = [(2.0, 2.0), (10.0, 4.0)]
    assert lobes_of(readings_of({(2.0, 2.0): 0.1}), atoms, 0.2) == [0, NONE]
    assert lobes_of(readings_of({(6.0, 0.0): 0.1}), [(0.0, 5.0), (11.0, 5.0)], 0.2) == [LONE, LONE]


def test_a_ring_in_a_lobe_is_drawn_within_its_memory() -> None:
    drawing = Drawing.of(2)
    drawing.sums[1] = 1e-3
    drawing.covariance[:] = 1.0
    join_lobe.py_func(drawing, 5, 0, 3)  # type: ignore[attr-defined]
    assert (drawing.order[:3] == 5).all()
    assert (drawing.sums[1, :3] == 0.0).all()
    assert (drawing.covariance[0] == 1.0).all()
    assert not drawing.covariance[1:3].any()
