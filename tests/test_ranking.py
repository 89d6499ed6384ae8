"""Orders that rounding does not choose."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.estimate import ContactFinder, PressureNoise
from skinfield.estimate.ranking import by_falling_force, falling_order, first_largest
from skinfield.skin import Grid, Patch

ROUNDED = st.integers(-8, 8).map(lambda steps: 1.0 + steps * 2e-16)


@given(st.lists(st.tuples(st.sampled_from([0.5, 1.0, 1.0 + 1e-7, 3.0]), ROUNDED), min_size=1))
def test_rounding_changes_no_order(pairs: list[tuple[float, float]]) -> None:
    plain, rounded = [value for value, _ in pairs], [value * part for value, part in pairs]
    ties = list(range(len(pairs)))[::-1]
    assert falling_order(rounded, ties) == falling_order(plain, ties)
    assert falling_order(plain, ties) == sorted(ties, key=lambda i: (-plain[i], ties[i]))
    assert first_largest(np.array(rounded)) == plain.index(max(plain))


@pytest.mark.parametrize("rounding", [-4e-16, 0.0, 4e-16])
def test_mirror_images_come_by_their_cells(rounding: float) -> None:
    corners = np.array([[0.0, 0, 0], [0.02, 0, 0], [0, 0.01, 0]])
    grid = Grid(Patch(corners, 2e-3), (5, 9), 2e-3, np.zeros(2))
    picture = np.zeros(grid.shape)
    picture[1:4, 1] = picture[1:4, 7] = [300.0, 1000.0, 300.0]
    picture[2, 7] *= 1.0 + rounding
    noise = PressureNoise(np.full((len(grid), 1), 1.0))
    found = ContactFinder()(grid, picture.ravel(), noise)
    assert [int(each.cells[0]) for each in found] == [10, 16]
    assert [int(each.cells[0]) for each in by_falling_force(found[::-1])] == [10, 16]
