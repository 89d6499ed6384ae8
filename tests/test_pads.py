"""Squares against round pads: rings about the pad, 25 digits, sums of parts."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from layer_reference import mean_inverse_distance as by_rings

from skinfield.mechanics.love import inverse_distance_integrals
from skinfield.mechanics.pads import disc_potential, mean_inverse, mean_inverse_distance

PLACES = {  # of the pad's centre, in sides of the cell and radii of the pad
    "centre": (0.0, 0.0, 0.0, 0.0),
    "on an edge": (0.5, 0.0, 0.1, 0.0),
    "on a corner": (0.5, 0.0, 0.5, 0.0),
    "rim through the centre": (0.0, 1.0, 0.0, 0.0),
    "rim along an edge": (0.5, 1.0, 0.2, 0.0),
    "rim through a corner": (0.5, 0.6, 0.5, 0.8),
    "overlapping": (0.3, 0.7, 0.1, 0.3),
    "just apart": (0.7, 1.0, 0.0, 0.0),
    "before the change of rule": (2.99, 1.0, 0.0, 0.0),
    "behind it": (3.01, 1.0, 0.0, 0.0),
    "far": (6.0, 4.0, 5.0, 4.0),
}


@pytest.mark.parametrize("ratio", [0.02, 0.1, 0.5, 1.0, 4.0, 40.0])
def test_mean_inverse_distance_ring_by_ring(ratio: float) -> None:
    """Pads from a fiftieth of the cell's side to forty times it."""
    cell, radius = 0.7, 0.7 * ratio
    places = np.array(
        [(a * cell + b * radius, c * cell + d * radius) for a, b, c, d in PLACES.values()]
    )
    expected = [by_rings(place, cell, radius) for place in places]
    got = mean_inverse_distance(places, cell, radius)
    np.testing.assert_allclose(got, expected, rtol=5e-12)


def test_rings_against_twenty_five_digits() -> None:
    """The reference itself: a square of side 2 under a pad of radius 1, both about the origin."""
    with mp.workdps(25):
        half = lambda r: 4 * mp.ellipe(r**2) if r <= 1 else _outside(r)
        angle = lambda r: 2 * mp.pi if r <= 1 else 2 * mp.pi - 8 * mp.acos(1 / r)
        exact = mp.quad(lambda r: half(r) * r * angle(r), [0, 1, mp.sqrt(2)]) / mp.pi
    assert by_rings(np.zeros(2), 2.0, 1.0) == pytest.approx(float(exact), rel=1e-13)
    assert mean_inverse_distance(np.zeros((1, 2)), 2.0, 1.0)[0] == pytest.approx(
        float(exact), rel=1e-13
    )


def _outside(r):
    m = 1 / r**2
    return 4 * r * (mp.ellipe(m) - (1 - m) * mp.ellipk(m))


def test_potential_of_a_disc() -> None:
    r = np.array([0.0, 0.3, 0.999, 1.0, 1.001, 2.0, 2.999, 3.001, 10.0, 1e4])
    with mp.workdps(25):
        exact = [
            float(4 * mp.ellipe(mp.mpf(float(v)) ** 2) if v <= 1 else _outside(mp.mpf(float(v))))
            for v in r
        ]
    np.testing.assert_allclose(disc_potential(r, 1.0), exact, rtol=2e-14)
    np.testing.assert_allclose(disc_potential(2 * r, 2.0), 2 * disc_potential(r, 1.0), rtol=1e-14)
    np.testing.assert_allclose(mean_inverse(r[1:], 0.0), 1 / r[1:])


def test_point_is_a_pad_of_no_radius() -> None:
    offset = np.array([[0.0, 0.0], [0.3, 0.1], [2.0, 5.0]])
    point = inverse_distance_integrals(offset, 1.0).inverse
    np.testing.assert_array_equal(mean_inverse_distance(offset, 1.0, 0.0), point)
    np.testing.assert_allclose(mean_inverse_distance(offset, 1.0, 1e-5), point, rtol=1e-5)


@settings(deadline=None, max_examples=60)
@given(
    x=st.floats(-8.0, 8.0),
    y=st.floats(-8.0, 8.0),
    radius=st.floats(0.05, 5.0),
    cell=st.floats(0.1, 3.0),
)
def test_a_cell_is_the_sum_of_its_quarters(x: float, y: float, radius: float, cell: float) -> None:
    place = np.array([[x, y]])
    quarters = place + cell / 4 * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    whole = mean_inverse_distance(place, cell, radius)[0]
    parts = mean_inverse_distance(quarters, cell / 2, radius).sum()
    assert whole == pytest.approx(parts, rel=5e-12)


@settings(deadline=None, max_examples=30)
@given(x=st.floats(0.0, 6.0), y=st.floats(0.0, 6.0), size=st.floats(1e-4, 1e3))
def test_symmetric_and_homogeneous(x: float, y: float, size: float) -> None:
    one = mean_inverse_distance(np.array([[x, y]]), 1.0, 0.8)[0]
    turned = mean_inverse_distance(np.array([[-y, x], [x, -y], [y, x]]) * size, size, 0.8 * size)
    np.testing.assert_allclose(turned, one * size, rtol=1e-12)
