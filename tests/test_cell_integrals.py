"""Integrals over square cells and round pads against quadrature and antiderivatives."""

import mpmath as mp
import numpy as np
import pytest
from closed_forms import square_displacement
from layer_reference import mean_inverse_distance as by_rings

from skinfield.elastic.cell_integrals import (
    InverseDistances,
    inverse_distance_integrals,
    mean_inverse,
    mean_inverse_distance,
)
from skinfield.errors import InputError

KERNELS = {
    "inverse": lambda x, y, r: 1 / r,
    "xx": lambda x, y, r: x**2 / r**3,
    "xy": lambda x, y, r: x * y / r**3,
    "yy": lambda x, y, r: y**2 / r**3,
    "x": lambda x, y, r: x / r**2,
    "y": lambda x, y, r: y / r**2,
}


def antiderivative(name: str, x, y):
    grow = lambda a, b: a * mp.asinh(b / abs(a)) if a else mp.mpf(0)
    match name:
        case "inverse":
            return grow(x, y) + grow(y, x)
        case "xx":
            return grow(y, x)
        case "xy":
            return -mp.hypot(x, y)
        case "x":
            return y * mp.log(mp.hypot(x, y) or 1) + (x * mp.atan(y / x) if x else 0)
        case "yy":
            return antiderivative("xx", y, x)
        case _:
            return antiderivative("x", y, x)


def reference(name: str, offset, cell: float):
    half, centre = mp.mpf(cell) / 2, [mp.mpf(float(v)) for v in offset]
    with mp.workdps(40):
        return sum(
            i * j * antiderivative(name, centre[0] + i * half, centre[1] + j * half)
            for i in (1, -1)
            for j in (1, -1)
        )


def gauss_square(count: int):
    node, weight = np.polynomial.legendre.leggauss(count)
    x, y = (a.ravel() for a in np.meshgrid(node / 2, node / 2))
    return np.column_stack([x, y]), np.outer(weight, weight).ravel() / 4


@pytest.mark.parametrize("name", InverseDistances._fields)
@pytest.mark.parametrize("offset", [(2.0, 1.0), (-1.5, 3.0), (0.0, -2.0)])
def test_integrals_are_those_of_their_kernels(name: str, offset) -> None:
    node, weight = gauss_square(40)
    x, y = (np.array(offset) - node).T
    want = weight @ KERNELS[name](x, y, np.hypot(x, y))
    got = getattr(inverse_distance_integrals(np.array([offset]), 1.0), name)[0]
    assert got == pytest.approx(want, abs=1e-14)


@pytest.mark.parametrize("name", InverseDistances._fields)
@pytest.mark.parametrize(
    ("cells", "error"), [(0.3, 1e-14), (1.0, 1e-13), (3.0, 1e-12), (30, 1e-10)]
)
def test_integrals_keep_their_digits_near_and_far(name: str, cells: float, error: float) -> None:
    angle, cell = np.linspace(0.0, 6.0, 13), 1e-3
    offset = np.column_stack([np.cos(angle), np.sin(angle)]) * cells * cell
    got = inverse_distance_integrals(offset, cell)
    for row, place in enumerate(offset):
        miss = getattr(got, name)[row] - reference(name, place, cell)
        assert abs(miss) < error * got.inverse[row]


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match=r"cell is -1.0, expected"):
        inverse_distance_integrals(np.zeros((1, 2)), -1.0)
    with pytest.raises(InputError, match=r"offset has shape \(1, 3\)"):
        square_displacement(np.zeros((1, 3)), 1.0, 1.0, 0.5)
    with pytest.raises(InputError, match=r"offset\[\(0, 1\)\] is nan"):
        inverse_distance_integrals(np.array([[0.0, np.nan]]), 1.0)


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
    np.testing.assert_allclose(np.pi * mean_inverse(r, 1.0), exact, rtol=2e-14)
    np.testing.assert_allclose(2 * mean_inverse(2 * r, 2.0), mean_inverse(r, 1.0), rtol=1e-14)
    np.testing.assert_allclose(mean_inverse(r[1:], 0.0), 1 / r[1:])


def test_point_is_a_pad_of_no_radius() -> None:
    offset = np.array([[0.0, 0.0], [0.3, 0.1], [2.0, 5.0]])
    point = inverse_distance_integrals(offset, 1.0).inverse
    np.testing.assert_array_equal(mean_inverse_distance(offset, 1.0, 0.0), point)
    np.testing.assert_allclose(mean_inverse_distance(offset, 1.0, 1e-5), point, rtol=1e-5)
