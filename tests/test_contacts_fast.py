"""The compiled finder against its definition, and contacts that work out the rest later."""

import copy
import multiprocessing
import pickle
from dataclasses import asdict, fields, replace

import contacts_reference as reference
import numpy as np
import pytest
from contact_scenes import FINDERS, area_moves, bumps, errors_on, grids, regions, scenes
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from skinfield.errors import InputError
from skinfield.estimate import Contact, ContactFinder, ModelError, PressureNoise
from skinfield.estimate.regions_kernel import sort_falling
from skinfield.skin import Grid

NAMES = [field.name for field in fields(Contact)]
LATE = {"covariance", "area_std", "outline"}
CLOSE = 1e-9  # of the largest entry of an attribute


def check_same(found: Contact, expected: Contact) -> None:
    """Compare all attributes, each with the scale on which its error is seen."""
    assert found.cells.tolist() == expected.cells.tolist()
    reach, force = expected.axes[0], float(np.linalg.norm(expected.force))
    place = np.hypot(expected.place_std, 1e-3 * reach)
    size = np.array([place, place, np.hypot(expected.force_std, 1e-3 * force)])
    scales = {"position": reach, "moment": force * reach, "covariance": np.outer(size, size)}
    for name in NAMES:
        mine, other = getattr(found, name), getattr(expected, name)
        assert type(mine) is type(other), name
        assert np.shape(mine) == np.shape(other), name
        if name in ("shape", "track_id", "spread", "cells"):
            assert np.array_equal(mine, other), name
        elif name == "angle":  # a round region has none
            minor = expected.axes[1]
            assert abs(np.sin(mine - other)) * (1 - (minor / reach) ** 2) < CLOSE
        else:
            scale = scales.get(name, np.abs(other).max())
            assert np.max(np.abs(mine - other) / scale) < CLOSE, name


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
        for mine, other in zip(of_note(found), of_note(expected), strict=True):
            check_same(mine, other)
        counts.append(len(found))
    assert 0 in counts
    assert max(counts) >= (1 if kind == "node" else 3)


@settings(max_examples=150, deadline=None)
@given(
    hnp.arrays(float, (5, 8), elements=st.integers(-2, 6).map(float)),
    st.sampled_from([0.0, 0.3, 1.0]),
    st.sampled_from([0.0, 0.2, 0.7]),
)
def test_regions_of_plateaus_and_equal_peaks(values: np.ndarray, share: float, edge: float) -> None:
    drop = share * np.abs(values)
    found = regions(values, drop, 0.5, edge)
    expected = reference.regions(values.ravel(), drop.ravel(), 0.5, edge, 8)
    assert [cells.tolist() for cells in found] == [cells.tolist() for cells in expected]


def test_hills_of_one_height_that_meet_in_turn_stay_whole() -> None:
    values = np.array([[2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0]])
    for turned in (values, values.T.copy(), values[:, ::-1].copy()):
        (found,) = regions(turned, np.full(turned.shape, 5.0), 0.0, 0.0)
        assert found.tolist() == list(range(7))


@given(st.lists(st.sampled_from([0.0, -0.0, 1.0, 1.5, 2.0, 7.0, 9.0]), max_size=80))
def test_sorting_is_stable(values: list[float]) -> None:
    flat, order = np.array(values), np.arange(len(values))
    expected = np.argsort(-flat, kind="stable")
    sort_falling(flat, order, np.empty(len(flat)), np.empty_like(order))
    assert order.tolist() == expected.tolist()
    assert flat.tolist() == [values[place] for place in expected]


@pytest.mark.parametrize("shape", [(9, 13), (1, 20)])
def test_area_moves_are_those_of_the_border(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(5)
    grid = Grid(grids()["hexagon"].patch, shape, 1e-3)
    pressure = bumps(grid, rng, 3)
    for cells in regions(pressure.reshape(shape), np.zeros(shape), 0.2 * pressure.max(), 0.3):
        around, moves, rounding = area_moves(grid, pressure, cells, 0.3)
        cells_around, expected, same = reference.area_moves(grid, pressure, cells, 0.3)
        sums = np.bincount(around, moves, len(grid))
        assert sums == pytest.approx(np.bincount(cells_around, expected, len(grid)), rel=1e-12)
        assert rounding == pytest.approx(same)
        assert len(np.unique(around[:-1])) == len(around) - 1


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


@pytest.mark.parametrize("count", [0, 1, 30, 499, 501])
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
    assert not LATE & vars(contact).keys()
    assert contact.covariance is contact.covariance
    assert LATE & vars(contact).keys() == {"covariance"}
    assert contact.force_std == np.sqrt(contact.covariance[2, 2])
    with pytest.raises(AttributeError, match="'Contact' object has no attribute 'weight'"):
        contact.weight  # noqa: B018
    with pytest.raises(AttributeError, match="cannot assign"):
        contact.area = 0.0


def test_copies_and_pickles_hold_all_and_nothing_else() -> None:
    import skinfield.estimate.finder as resultant

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
    assert resultant.Details.__name__.encode() not in pickle.dumps(one_contact())


def test_a_contact_comes_over_from_another_process() -> None:
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        check_same(pool.apply(one_contact), one_contact())


def test_a_contact_lends_what_another_does_not_have() -> None:
    lender = one_contact()
    contact = Contact.later(lender, area=2 * lender.area, track_id=7)
    assert (contact.area, contact.track_id) == (2 * lender.area, 7)
    assert contact.outline is lender.outline
    assert contact.spread is None
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
        std = np.zeros(0)

        def covariance_of_sums(self, cells: np.ndarray, weights: np.ndarray) -> np.ndarray:
            return np.eye(len(weights)) * len(cells)

    grid = grids()["coarse"]
    noise, _ = errors_on(grid, np.random.default_rng(1))
    pressure = bumps(grid, np.random.default_rng(1), 1)
    (contact,) = FINDERS[0](grid, pressure, noise, Flat(), ModelError(place=2.0))
    assert contact.covariance == pytest.approx(np.eye(3) * len(contact.cells) + np.diag([4, 4, 0]))
