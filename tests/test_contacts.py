"""Regions, borders and contacts of fields that are known in closed form."""

import numpy as np
import pytest
from contact_scenes import regions
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from skinfield.estimate import ContactFinder, PressureNoise
from skinfield.estimate.finder import border
from skinfield.skin import Grid, Patch
from skinfield.skin.generators import cylinder

SQUARE = Patch(np.array([(-0.02, -0.02), (0.02, -0.02), (0.02, 0.02), (-0.02, 0.02)]))
GRID = Grid.square(SQUARE, nodes=41)
QUIET = PressureNoise(np.full((len(GRID), 4), 10.0))  # 20 Pa a cell


def dome(grid: Grid, x: float, y: float, radius: float, peak: float = 1e4) -> np.ndarray:
    square = ((grid.plane - (x, y)) ** 2).sum(axis=1)
    return peak * np.maximum(0.0, 1 - square / radius**2)


def test_a_dome_gives_one_contact_with_its_resultant() -> None:
    pressure = dome(GRID, 4e-3, -3e-3, 6e-3)
    (contact,) = ContactFinder(edge=0.0)(GRID, pressure, QUIET)
    assert contact.position == pytest.approx([4e-3, -3e-3, 0], abs=1e-9)
    assert contact.normal_force == pytest.approx(np.pi * 6e-3**2 * 1e4 / 2, rel=5e-3)
    assert contact.force[:2] == pytest.approx(0, abs=1e-12)
    assert contact.force[2] < 0  # into the skin
    assert contact.moment == pytest.approx(0, abs=1e-12)
    assert contact.area == pytest.approx(np.pi * 6e-3**2, rel=0.03)
    assert contact.peak_pressure == pressure.max()
    # A paraboloid has a third of the squared radius as second moment about the axis, on both axes.
    assert contact.axes == pytest.approx(2 * 6e-3 / np.sqrt(6), rel=0.02)


def test_the_edge_cuts_a_region_at_a_share_of_its_peak() -> None:
    (contact,) = ContactFinder(edge=0.5)(GRID, dome(GRID, 0, 0, 8e-3), QUIET)
    assert contact.area == pytest.approx(np.pi * 8e-3**2 / 2, rel=0.05)


def test_an_ellipse_has_its_axes_and_angle() -> None:
    turn = np.deg2rad(30)
    along = GRID.plane @ [np.cos(turn), np.sin(turn)]
    across = GRID.plane @ [-np.sin(turn), np.cos(turn)]
    inside = (along / 10e-3) ** 2 + (across / 5e-3) ** 2 <= 1
    (contact,) = ContactFinder()(GRID, 1e4 * inside, QUIET)
    assert contact.axes == pytest.approx([10e-3, 5e-3], rel=0.03)
    assert contact.angle == pytest.approx(turn, abs=0.02)


def test_two_domes_are_two_contacts_and_the_stronger_comes_first() -> None:
    pressure = dome(GRID, -8e-3, 0, 5e-3, 6e3) + dome(GRID, 8e-3, 2e-3, 5e-3, 1e4)
    first, second = ContactFinder()(GRID, pressure, QUIET)
    assert first.position == pytest.approx([8e-3, 2e-3, 0], abs=1e-4)
    assert second.position == pytest.approx([-8e-3, 0, 0], abs=1e-4)
    assert not set(first.cells) & set(second.cells)


def test_domes_that_overlap_are_two_while_the_saddle_is_deep() -> None:
    def count(distance: float) -> int:
        pressure = dome(GRID, -distance / 2, 0, 6e-3) + dome(GRID, distance / 2, 0, 6e-3)
        return len(ContactFinder(prominence=0.3)(GRID, pressure, QUIET))

    assert count(11e-3) == 2
    assert count(6e-3) == 1


def test_a_weak_peak_beside_a_strong_one_counts_as_ringing() -> None:
    pressure = dome(GRID, -8e-3, 0, 5e-3, 1e3) + dome(GRID, 8e-3, 0, 5e-3, 1e4)
    assert len(ContactFinder(relative_height=0.2)(GRID, pressure, QUIET)) == 1
    assert len(ContactFinder(relative_height=0.05)(GRID, pressure, QUIET)) == 2


def test_nothing_is_found_in_suction_or_below_the_noise() -> None:
    assert ContactFinder()(GRID, -dome(GRID, 0, 0, 6e-3), QUIET) == ()
    loud = PressureNoise(np.full((len(GRID), 4), 3e3))
    assert ContactFinder()(GRID, dome(GRID, 0, 0, 6e-3), loud) == ()


def test_false_alarms_stay_at_the_stated_rate() -> None:
    rng = np.random.default_rng(3)
    factor = np.eye(len(GRID))[:, :: len(GRID) // 50] * 100.0  # fifty cells that are independent
    finder = ContactFinder(false_alarm_rate=0.1)
    noise = PressureNoise(factor)
    seen = sum(bool(finder(GRID, factor @ rng.normal(size=factor.shape[1]), noise))
               for _ in range(400))  # fmt: skip
    assert 0.05 <= seen / 400 <= 0.16  # binomial, three standard deviations


def test_force_std_adds_what_the_cells_share() -> None:
    (contact,) = ContactFinder()(GRID, dome(GRID, 0, 0, 6e-3), QUIET)
    # All cells move together here: 4 readings, 10 Pa each.
    assert contact.force_std == pytest.approx(20.0 * contact.area)


def test_the_outline_surrounds_the_region() -> None:
    (contact,) = ContactFinder()(GRID, dome(GRID, 4e-3, -3e-3, 6e-3), QUIET)
    outline = contact.outline
    assert outline[0] == pytest.approx(outline[-1])
    x, y = outline[:, 0], outline[:, 1]
    shoelace = 0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])
    assert shoelace == pytest.approx(contact.area)  # counter-clockwise, without holes


def test_a_contact_on_a_curved_patch_points_inwards() -> None:
    patch = cylinder(radius=40e-3)
    grid = Grid.square(patch, nodes=30)
    middle = grid.plane[len(grid) // 2 + 15]
    pressure = dome(grid, *middle, 8e-3)
    (contact,) = ContactFinder()(grid, pressure, PressureNoise(np.full((len(grid), 1), 1.0)))
    assert contact.normal_force > 0.9 * pressure.sum() * grid.cell_area
    assert np.cross(contact.force, contact.normal) == pytest.approx(0, abs=0.1)
    assert np.linalg.norm(contact.position[:2]) != pytest.approx(0)


@settings(max_examples=60, deadline=None)
@given(hnp.arrays(float, (6, 7), elements=st.integers(-3, 9).map(float)), st.floats(0, 1))
def test_regions_are_disjoint_connected_and_hold_their_peak(
    values: np.ndarray, share: float
) -> None:
    found = regions(values, share * np.abs(values), 0.0, edge=0.0)
    cells = np.concatenate([*found, np.empty(0, int)])
    assert sorted(cells) == sorted(np.flatnonzero(values.ravel() > 0))  # a partition
    for part in found:
        rows, columns = np.divmod(part, 7)
        reached, waiting = {0}, [0]
        while waiting:
            here = waiting.pop()
            near = (abs(rows - rows[here]) <= 1) & (abs(columns - columns[here]) <= 1)
            fresh = set(np.flatnonzero(near).tolist()) - reached
            reached |= fresh
            waiting += fresh
        assert len(reached) == len(part)


def test_the_border_of_cells_that_touch_at_a_corner_holds_both() -> None:
    loop = border(np.array([0, 4]), (3, 3))
    assert (loop[0] == loop[-1]).all()
    x, y = loop.T
    assert 0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]) == 2.0


@settings(max_examples=60, deadline=None)
@given(hnp.arrays(bool, (5, 6)))
def test_the_border_surrounds_the_region_and_its_holes(picture: np.ndarray) -> None:
    from scipy.ndimage import binary_fill_holes, label

    labels, count = label(picture, np.ones((3, 3)))
    for region in range(1, count + 1):
        mask = labels == region
        loop = border(np.flatnonzero(mask), mask.shape)
        assert (loop[0] == loop[-1]).all()
        assert np.abs(np.diff(loop, axis=0)).sum(axis=1).tolist() == [1.0] * (len(loop) - 1)
        x, y = loop.T
        area = 0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])
        assert area == binary_fill_holes(mask).sum()  # cells join by corners, holes by sides


def test_fractions_are_checked() -> None:
    with pytest.raises(ValueError, match="edge is 2, expected a number from 0 to 1"):
        ContactFinder(edge=2)
