"""Regions, borders and contacts: closed forms, the slow definition, and what comes later."""

import copy
import pickle
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, fields, replace
from itertools import pairwise

import contacts_reference as reference
import numpy as np
import pytest
from contact_scenes import FINDERS, bumps, errors_on, grids, regions, scenes
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from skinfield.errors import InputError
from skinfield.estimate import Contact, ContactFinder, Estimate, ModelError, PressureNoise
from skinfield.estimate.estimate import REQUIRED
from skinfield.estimate.ranking import by_falling_force, falling_order, first_largest
from skinfield.estimate.row_contacts import Outline
from skinfield.skin import Grid, Patch

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
    assert contact.axes == pytest.approx(6e-3, rel=0.02)


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


def pair(distance: float, weaker: float = 1e4) -> np.ndarray:
    """Two domes of 6 mm, one of them of a peak of its own."""
    return dome(GRID, -distance / 2, 0, 6e-3, weaker) + dome(GRID, distance / 2, 0, 6e-3)


@pytest.mark.parametrize(
    ("pressure", "finder", "noise", "count"),
    [
        (pair(11e-3), {"prominence": 0.3}, 20.0, 2),  # while the saddle is deep
        (pair(6e-3), {"prominence": 0.3}, 20.0, 1),
        (pair(16e-3, 1e3), {"relative_height": 0.2}, 20.0, 1),  # else it counts as ringing
        (pair(16e-3, 1e3), {"relative_height": 0.05}, 20.0, 2),
        (-pair(0.0), {}, 20.0, 0),  # suction
        (pair(0.0), {}, 12e3, 0),  # below the noise
    ],
)
def test_what_counts_as_a_contact(
    pressure: np.ndarray, finder: dict[str, float], noise: float, count: int
) -> None:
    error = PressureNoise(np.full((len(GRID), 1), noise))
    assert len(ContactFinder(**finder)(GRID, pressure, error)) == count


def test_false_alarms_stay_at_the_stated_rate() -> None:
    rng = np.random.default_rng(3)
    factor = np.eye(len(GRID))[:, :: len(GRID) // 50] * 100.0  # fifty cells that are independent
    finder = ContactFinder(false_alarm_rate=0.1)
    noise = PressureNoise(factor)
    seen = sum(bool(finder(GRID, factor @ rng.normal(size=factor.shape[1]), noise))
               for _ in range(400))  # fmt: skip
    assert 0.05 <= seen / 400 <= 0.16  # binomial, three standard deviations


def test_fractions_are_checked() -> None:
    with pytest.raises(ValueError, match="edge is 2, expected a number from 0 to 1"):
        ContactFinder(edge=2)


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
    grid = Grid(SQUARE, (5, 9), 2e-3, np.zeros(2))
    picture = np.zeros(grid.shape)
    picture[1:4, 1] = picture[1:4, 7] = [300.0, 1000.0, 300.0]
    picture[2, 7] *= 1.0 + rounding
    noise = PressureNoise(np.full((len(grid), 1), 1.0))
    found = ContactFinder()(grid, picture.ravel(), noise)
    assert [int(each.cells[0]) for each in found] == [10, 16]
    assert [int(each.cells[0]) for each in by_falling_force(found[::-1])] == [10, 16]


NAMES = [field.name for field in fields(Contact)]
THINNED = 96  # cells of a region beyond which its covariance is that of a sample


def check_defined(found: Contact, expected: Contact, grid: Grid) -> None:
    """Compare with the definition; a curved skin is interpolated between its nodes."""
    flat, pitch = grid.patch.surface.is_flat, grid.pitch
    assert found.cells.tolist() == expected.cells.tolist()
    near = 1e-9 if flat else 0.05
    assert np.linalg.norm(found.position - expected.position) < near * pitch
    assert found.normal @ expected.normal > (1 - 1e-12 if flat else 0.995)
    force = pytest.approx(expected.normal_force, rel=1e-9 if flat else 0.01)
    assert found.normal_force == force
    assert found.force == pytest.approx(-found.normal_force * found.normal)
    assert (found.area, found.radius) == pytest.approx((expected.area, expected.radius))
    assert found.peak_pressure == expected.peak_pressure
    assert found.axes == pytest.approx(expected.axes, rel=1e-6, abs=1e-6 * pitch)
    assert (found.shape, found.track_id) == ("other", None)
    assert not found.moment.any()
    assert np.isnan(found.area_std)  # of a part of a field
    if expected.axes[1] < (1 - 1e-6) * expected.axes[0]:  # a round one has no angle
        assert np.sin(found.angle - expected.angle) == pytest.approx(0.0, abs=1e-3)
    if len(found.cells) > THINNED:
        for name in ("place_std", "force_std"):
            assert getattr(found, name) == pytest.approx(getattr(expected, name), rel=0.35)
        return
    scale = np.sqrt(np.diag(expected.covariance)) + np.array([1e-9, 1e-9, 1.0]) * pitch
    off = (found.covariance - expected.covariance) / np.outer(scale, scale)
    assert np.abs(off).max() < 1e-4


def check_same(found: Contact, expected: Contact) -> None:
    """To the last bit."""
    for name in NAMES:
        mine, other = getattr(found, name), getattr(expected, name)
        assert type(mine) is type(other), name
        np.testing.assert_array_equal(mine, other, err_msg=name)


def of_note(contacts: tuple[Contact, ...]) -> list[Contact]:
    """Without what edges at 0 leave of the tails of other bumps: its place is rounding."""
    return [c for c in contacts if c.normal_force > 1e-5 * contacts[0].normal_force]


@pytest.mark.parametrize("kind", list(grids()))
def test_all_is_as_defined(kind: str) -> None:
    counts = []
    for scene in scenes(seed=11, each=5, kinds={kind: grids()[kind]}):
        found = scene()
        expected = reference.contacts(
            scene.finder, scene.grid, scene.pressure, scene.noise, scene.error, scene.model_error
        )
        assert len(found) == len(expected), scene.name
        forces = [each.normal_force for each in found]
        assert all(b < 1.01 * a for a, b in pairwise(forces))
        by_cell = [sorted(of_note(each), key=lambda c: c.cells[0]) for each in (found, expected)]
        for mine, other in zip(*by_cell, strict=True):
            check_defined(mine, other, scene.grid)
        counts.append(len(found))
    assert 0 in counts
    assert max(counts) >= (1 if kind == "node" else 3)


@settings(max_examples=150, deadline=None)
@given(
    hnp.arrays(float, (5, 8), elements=st.integers(-2, 6).map(float)),
    st.sampled_from([0.0, 0.3, 1.0]),
    st.sampled_from([0.0, 0.2, 0.7]),
    st.sampled_from([0.0, 0.1, 0.5]),
)
def test_regions_of_plateaus_and_equal_peaks(
    values: np.ndarray, share: float, edge: float, height: float
) -> None:
    flat, least = values.ravel(), height * values.max()
    found = regions(values, share, height, edge)
    expected = reference.regions(flat, share * np.abs(flat), max(edge * least, 0.0), edge, 8)
    expected = [cells for cells in expected if (flat[cells] > max(least, 0.0)).any()]
    assert [cells.tolist() for cells in found] == [cells.tolist() for cells in expected]


def test_hills_of_one_height_that_meet_in_turn_stay_whole() -> None:
    values = np.array([[2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0]])
    for turned in (values, values.T.copy(), values[:, ::-1].copy()):
        (found,) = regions(turned, 1.0, 0.0, 0.0)
        assert found.tolist() == list(range(7))


def test_numbers_that_are_not_finite_hide_all_contacts_as_ever() -> None:
    grid = grids()["coarse"]
    noise, _ = errors_on(grid, np.random.default_rng(1))
    pressure = bumps(grid, np.random.default_rng(1), 2)
    assert len(ContactFinder()(grid, pressure, noise)) > 0
    for place in (0, 70, len(grid) - 1):
        broken = pressure.copy()
        broken[place] = np.nan
        assert ContactFinder()(grid, broken, noise) == ()


def test_pressure_in_single_precision_read_only_or_strided() -> None:
    (scene, *_) = (s for s in scenes(3, 1, {"hexagon": grids()["hexagon"]}) if "bumps" in s.name)
    whole = replace(scene, pressure=scene.pressure.astype(np.float32).astype(np.float64))
    table = np.zeros((len(scene.pressure), 2))
    table[:, 1] = whole.pressure
    frozen = whole.pressure.copy()
    frozen.setflags(write=False)
    for pressure in (whole.pressure.astype(np.float32), frozen, table[:, 1]):
        for mine, other in zip(replace(scene, pressure=pressure)(), whole(), strict=True):
            check_same(mine, other)


def test_shapes_are_checked() -> None:
    grid = grids()["coarse"]
    noise, _ = errors_on(grid, np.random.default_rng(1))
    with pytest.raises(InputError, match="pressure has shape"):
        ContactFinder()(grid, np.zeros(len(grid) + 1), noise)
    with pytest.raises(InputError, match=r"noise\.std has shape"):
        ContactFinder()(grid, np.zeros(len(grid)), PressureNoise(noise.factor[:-1]))
    with pytest.raises(InputError, match=r"cells go from 0 to 144, expected from 0 to 143"):
        noise.covariance_of_sums(np.array([0, 144]), np.ones((1, 2)))
    with pytest.raises(InputError, match=r"weights have shape \(1, 3\), expected \(M, 2\)"):
        noise.covariance_of_sums(np.array([0, 1]), np.ones((1, 3)))


@pytest.mark.parametrize("count", [0, 1, 30, 199, 201])
def test_covariances_of_sums_are_those_of_the_dense_matrix(count: int) -> None:
    grid, rng = grids()["hexagon"], np.random.default_rng(count)
    noise, posterior = errors_on(grid, rng)
    cells, weights = rng.integers(0, len(grid), count), rng.normal(size=(3, count))
    columnwise = PressureNoise(np.asfortranarray(noise.factor))
    part = posterior.on(np.arange(len(grid))[::-1])
    for error in (noise, columnwise, posterior, part):
        found = error.covariance_of_sums(cells, weights)
        expected = reference.covariance_of_sums(error, cells, weights)
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())


def one_contact() -> Contact:
    (scene, *_) = (s for s in scenes(3, 1, {"pipe": grids()["pipe"]}) if "bumps" in s.name)
    return scene()[0]


def eager(contact: Contact) -> Contact:
    return Contact(**{name: getattr(contact, name) for name in NAMES})


def test_what_is_dear_is_worked_out_once_and_when_asked_for() -> None:
    contact = one_contact()
    assert "outline" not in vars(contact)
    assert contact.outline is contact.outline
    assert contact.force_std == np.sqrt(contact.covariance[2, 2])
    with pytest.raises(AttributeError, match="'Contact' object has no attribute 'weight'"):
        contact.weight  # noqa: B018
    with pytest.raises(AttributeError, match="cannot assign"):
        contact.area = 0.0


def test_copies_and_pickles_hold_all_and_nothing_else() -> None:
    for made in (
        copy.copy(one_contact()),
        copy.deepcopy(one_contact()),
        pickle.loads(pickle.dumps(one_contact())),
        replace(one_contact(), track_id=None),
        eager(one_contact()),
    ):
        assert vars(made).keys() == set(NAMES)
        check_same(made, eager(one_contact()))
    assert repr(one_contact()) == repr(eager(one_contact()))
    assert asdict(one_contact()).keys() == set(NAMES)
    assert Outline.__name__.encode() not in pickle.dumps(one_contact())


def test_a_contact_lends_what_another_does_not_have() -> None:
    lender = one_contact()
    contact = Contact.later(lender, area=2 * lender.area, track_id=7)
    assert (contact.area, contact.track_id) == (2 * lender.area, 7)
    assert contact.outline is lender.outline
    assert vars(Contact.later(contact)).keys() == {"_rest"}
    assert Contact.later(contact).track_id == 7
    with pytest.raises(InputError, match="Contact has no size: expected its attributes"):
        Contact.later(lender, size=3.0)


def test_what_comes_later_does_not_see_what_is_written_into_the_field() -> None:
    (scene, *_) = (s for s in scenes(3, 1, {"hexagon": grids()["hexagon"]}) if "bumps" in s.name)
    expected = [eager(contact) for contact in scene()]
    field = scene.pressure.copy()
    found = replace(scene, pressure=field)()
    field[:] = 0.0
    for mine, other in zip(found, expected, strict=True):
        check_same(mine, other)


def test_an_error_of_ones_own_is_asked() -> None:
    class Flat:
        std, felt = np.zeros(144), 0

        def covariance_of_sums(self, cells: np.ndarray, weights: np.ndarray) -> np.ndarray:
            return np.eye(len(weights)) * len(cells)

    grid = grids()["coarse"]
    noise, _ = errors_on(grid, np.random.default_rng(1))
    pressure = bumps(grid, np.random.default_rng(1), 1)
    (contact,) = FINDERS[0](grid, pressure, noise, Flat(), ModelError(place=2.0))
    assert contact.covariance == pytest.approx(np.eye(3) * len(contact.cells) + np.diag([4, 4, 0]))


def test_threads_that_ask_for_one_lazy_part_get_the_same() -> None:
    computing, asked, go, calls = threading.Event(), threading.Event(), threading.Event(), []

    def traction() -> list[float]:
        calls.append(1)
        computing.set()
        assert go.wait(60.0)
        return []

    known = dict.fromkeys(REQUIRED - {"traction"})
    estimate = Estimate.later({"traction": traction}, **known)

    def ask() -> list[float]:
        asked.set()
        return estimate.traction

    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(ask)
        assert computing.wait(60.0)
        asked.clear()
        second = pool.submit(ask)
        assert asked.wait(60.0)
        go.set()
        assert first.result() is second.result()
    assert len(calls) == 1
