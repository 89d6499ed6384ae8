"""Transfer functions of the layer and their inverse transforms against closed forms."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from layer_reference import propagate, ratios

from skinfield.elastic.cell_integrals import integrate_over_cell
from skinfield.elastic.hankel import (
    CoveredTransfer,
    LayerTransfer,
    RadialKernel,
    bessel,
    electrostatic,
    jinc,
)

NUS = [0.0, 0.2, 0.3, 0.45, 0.499, 0.5]
ALL = [1e-6, 1e-5, 1e-3, 0.01, 0.2, 0.499, 0.501, 1.0, 2.5, 5.0, 10.0, 20.0, 40.0]
FREE = {"normal": 1.0, "tangential": 1.0, "coupling": None, "antiplane": 1.0}  # half-space limits
BASE = ["base_normal", "base_shear", "base_shear_from_normal", "base_normal_from_shear"]
BASE += ["base_antiplane"]
COVERED = ["normal", "base_normal", "base_shear_from_normal"]


def responses(nu: float, alpha: float) -> dict[str, float]:
    """All that the program offers, under the names of the reference."""
    free, covered, at = LayerTransfer(nu), CoveredTransfer(nu), np.array([alpha])
    out = {name: getattr(free, name)(at)[0] for name in ("normal", "tangential", "coupling", *BASE)}
    out["antiplane"] = 1.0 + free.antiplane_rest(at)[0]
    return out | {f"covered_{name}": getattr(covered, name)(at)[0] for name in COVERED}


@pytest.mark.parametrize("nu", NUS)
def test_matrix_exponential_in_sixty_digits(nu: float) -> None:
    for alpha in ALL:
        expected = propagate(nu, alpha)
        got = responses(nu, alpha)
        if alpha < 1.0:
            del got["antiplane"]  # 1 + rest; the rest itself is checked below
        for name, value in got.items():
            assert value == pytest.approx(float(expected[name]), rel=1e-12, abs=1e-300), (
                name,
                alpha,
            )


@pytest.mark.parametrize("nu", NUS)
def test_rests_keep_their_digits_when_little_is_left(nu: float) -> None:
    for alpha in ALL:
        expected = propagate(nu, alpha)
        for name in FREE:
            rest = getattr(LayerTransfer(nu), f"{name}_rest")(np.array([alpha]))[0]
            small = float(expected[name] - (2 * expected["nu"] - 1 if name == "coupling" else 1))
            assert rest == pytest.approx(small, rel=1e-12, abs=1e-300), (name, alpha)
        covered = CoveredTransfer(nu)
        left = float(expected["covered_normal"] - expected["covered_limit"])
        got = covered.normal_rest(np.array([alpha]))[0]
        assert got == pytest.approx(left, rel=1e-12, abs=1e-15), alpha


@pytest.mark.parametrize("nu", NUS)
def test_formulas_written_out_plainly_agree_in_their_own_range(nu: float) -> None:
    alpha = np.array([0.2, 1.0, 5.0, 20.0])
    plain = ratios(nu, alpha)
    for name, values in plain.items():
        exact = [float(propagate(nu, a)[name]) for a in alpha]
        np.testing.assert_allclose(values, exact, rtol=1e-12, err_msg=name)


@given(nu=st.floats(0.0, 0.5), log_alpha=st.floats(-9.0, 4.0))
def test_energy_is_positive_and_nothing_overflows(nu: float, log_alpha: float) -> None:
    at = np.array([10.0**log_alpha])
    free, covered = LayerTransfer(nu), CoveredTransfer(nu)
    normal, tangential = free.normal(at)[0], free.tangential(at)[0]
    mixed = free.coupling(at)[0] / (2 * (1 - nu))
    assert 0.0 < normal <= 1.0 + 1e-12
    assert tangential > 0.0
    assert normal * tangential >= mixed**2 * (1 - 1e-12)
    assert 0.0 < covered.normal(at)[0] <= normal * (1 + 1e-12)
    for model, names in ((free, BASE), (covered, COVERED)):
        assert all(np.isfinite(getattr(model, name)(at)[0]) for name in names)


RHO = np.array([0.0, 1e-9, 0.1, 0.2499, 0.25, 0.7, 1.0, 2.3, 5.0, 11.0, 31.9])
ELEMENTARY = {  # order: transform, kernel over rho^order
    0: (lambda a: np.exp(-a), lambda s: 1 / s),
    1: (lambda a: a * np.exp(-a), lambda s: 1 / s**3),
    2: (lambda a: a**2 * np.exp(-a), lambda s: 3 / s**5),
}


@pytest.mark.parametrize("order", [0, 1, 2])
def test_tables_of_elementary_transforms(order: int) -> None:
    transform, kernel = ELEMENTARY[order]
    table = RadialKernel(transform, order, cutoff=46.0, reach=32.0)
    expected = kernel(np.hypot(RHO, 1.0))
    np.testing.assert_allclose(table(RHO), expected, rtol=0.0, atol=1e-14 * expected[0])


@pytest.mark.parametrize("radius", [0.05, 1.0, 10.0, 40.0])
def test_wide_pads_average_the_kernel(radius: float) -> None:
    """1/(2 pi (1 + rho²)^1.5) averaged over a disc, by rings; pads far wider than the layer too."""
    pad = RadialKernel(
        lambda a: a * np.exp(-a) * jinc(a, radius) / (2 * np.pi),
        0,
        cutoff=46.0,
        reach=32.0 + radius,
        width=radius,
    )
    rho = np.array([0.0, 0.3 * radius, 0.99 * radius, radius + 0.5, radius + 10.0])
    node, weight = np.polynomial.legendre.leggauss(400)
    count = int(400 + 100 * radius)
    angle = (np.arange(count) + 0.5) * np.pi / count  # half a turn, by symmetry
    r = radius * (node + 1) / 2
    x = rho[:, None, None] + np.outer(r, np.cos(angle))
    s = np.sqrt(x**2 + np.outer(r, np.sin(angle)) ** 2 + 1.0)
    mean = (1 / (2 * np.pi * s**3)).mean(axis=-1) @ (weight * r) / radius
    np.testing.assert_allclose(pad(rho), mean, rtol=0.0, atol=2e-13 * mean[0])


TABLE = RadialKernel(lambda a: a * LayerTransfer(0.45).base_normal(a) / (2 * np.pi), 0, 46.0, 32.0)


def test_tables_end_at_their_reach_and_keep_shapes() -> None:
    rho = np.array([[31.999, 32.0, 33.0], [0.0, 1.0, 1e9]])
    values = TABLE(rho)
    assert values.shape == (2, 3)
    np.testing.assert_array_equal(values[[0, 0, 1], [1, 2, 2]], 0.0)
    assert abs(values[0, 0]) < 1e-11 * values[1, 0]


@pytest.mark.parametrize("order", [0, 1, 2])
def test_bessel_functions(order: int) -> None:
    x = np.array([0.0, 1e-8, 1e-3, 0.5, 0.999999, 1.0, 1.5, 20.0, 1000.0])
    exact = [float(mp.besselj(order, mp.mpf(float(v)))) for v in x]
    np.testing.assert_allclose(bessel(order, x), exact, rtol=1e-14, atol=1e-15)


def test_electrostatic_smoothing_is_alpha_over_sinh() -> None:
    at = np.array([0.0, 1e-12, 1e-7, 0.1, 1.0, 30.0, 300.0])
    exact = [1.0, *(float(mp.mpf(float(a)) / mp.sinh(mp.mpf(float(a)))) for a in at[1:])]
    np.testing.assert_allclose(electrostatic(at), exact, rtol=1e-14)


def solid_angle(offset, cell: float) -> np.ndarray:
    """Integral of (x² + y² + 1)^-1.5 over a square: atan of products over corners."""
    total = 0.0
    for i in (1, -1):
        for j in (1, -1):
            x, y = offset[:, 0] + i * cell / 2, offset[:, 1] + j * cell / 2
            total += i * j * np.arctan(x * y / np.sqrt(x**2 + y**2 + 1))
    return total


@pytest.mark.parametrize("cell", [0.01, 0.25, 0.75, 2.0, 2.5, 10.0, 40.0])
def test_cells_of_any_size_against_the_solid_angle(cell: float) -> None:
    distance = np.array([0.0, 0.3, 0.5, 1.0, 3.0, 10.0]) * (cell + 1)
    offset = np.column_stack([0.8 * distance, 0.6 * distance])
    got = integrate_over_cell(
        lambda x, y: (x**2 + y**2 + 1) ** -1.5, offset, cell, depth=1.0, reach=np.inf
    )
    expected = solid_angle(offset, cell)
    np.testing.assert_allclose(got, expected, rtol=1e-11, atol=2e-14 * expected[0] + 3e-16)
