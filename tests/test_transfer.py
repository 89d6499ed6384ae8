"""Closed forms in Fourier space: boundary-value problems solved two ways, limits, energy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from layer_reference import collocate, propagate, ratios

from skinfield.mechanics.transfer import CoveredTransfer, LayerTransfer

NUS = [0.0, 0.2, 0.3, 0.45, 0.499, 0.5]
MODERATE = [0.01, 0.03, 0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0]
ALL = [1e-6, 1e-5, 1e-3, 0.01, 0.2, 0.499, 0.501, 1.0, 2.5, 5.0, 10.0, 20.0, 40.0]
FREE = {"normal": 1.0, "tangential": 1.0, "coupling": None, "antiplane": 1.0}  # half-space limits
BASE = [
    "base_normal",
    "base_shear",
    "base_shear_from_normal",
    "base_normal_from_shear",
    "base_antiplane",
]
COVERED = ["normal", "base_normal", "base_shear_from_normal"]


def limit(nu: float, name: str) -> float:
    return 2 * nu - 1 if name == "coupling" else FREE[name]


def responses(nu: float, alpha: float) -> dict[str, float]:
    """All that the program offers, under the names of the reference."""
    free, covered, at = LayerTransfer(nu), CoveredTransfer(nu), np.array([alpha])
    out = {name: getattr(free, name)(at)[0] for name in ("normal", "tangential", "coupling", *BASE)}
    out["antiplane"] = 1.0 + free.antiplane_rest(at)[0]
    return out | {f"covered_{name}": getattr(covered, name)(at)[0] for name in COVERED}


@pytest.mark.parametrize("nu", NUS)
def test_collocation_of_the_equations_of_elasticity(nu: float) -> None:
    for alpha in MODERATE:
        expected = collocate(nu, alpha)
        for name, value in responses(nu, alpha).items():
            assert value == pytest.approx(expected[name], rel=1e-8, abs=1e-12), (name, alpha)


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


def test_maxwell_reciprocity_of_the_reference() -> None:
    for nu in NUS:
        both = propagate(nu, 1.0)
        assert float(both["coupling"] - both["reciprocal"]) == pytest.approx(0.0, abs=1e-30)


@pytest.mark.parametrize("nu", NUS)
def test_small_alpha_is_equilibrium_and_confined_compression(nu: float) -> None:
    small = np.array([1e-4])
    free, covered = LayerTransfer(nu), CoveredTransfer(nu)
    assert free.base_normal(small)[0] == pytest.approx(1.0, rel=1e-7)
    assert free.base_shear(small)[0] == pytest.approx(1.0, rel=1e-7)
    assert free.base_normal_from_shear(small)[0] == pytest.approx(-1e-4, rel=1e-7)  # moment
    # w = p h / M: 2 (1 - nu²) X / (E k) = h / M
    inverse_modulus = (1 + nu) * (1 - 2 * nu) / (1 - nu)
    for model in (free, covered):
        sunk = 2 * (1 - nu**2) * model.normal(small)[0] / 1e-4
        assert sunk == pytest.approx(inverse_modulus, abs=2e-8)


def test_incompressible_layer_is_lubrication_at_small_alpha() -> None:
    small = np.array([1e-3])
    assert LayerTransfer(0.5).normal(small)[0] == pytest.approx(2e-9 / 3, rel=1e-5)
    assert CoveredTransfer(0.5).normal(small)[0] == pytest.approx(1e-9 / 6, rel=1e-5)


def test_stress_at_depth_is_twice_the_half_space_for_the_incompressible() -> None:
    at = np.array([12.0, 25.0])
    half_space = (1 + at) * np.exp(-at)
    np.testing.assert_allclose(LayerTransfer(0.5).base_normal(at) / half_space, 2.0, rtol=1e-7)


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


@given(nu=st.floats(0.0, 0.5), alpha=st.floats(1e-3, 30.0))
def test_rest_and_whole_differ_by_the_half_space(nu: float, alpha: float) -> None:
    at, free = np.array([alpha]), LayerTransfer(nu)
    for name in ("normal", "tangential", "coupling"):
        whole, rest = getattr(free, name)(at)[0], getattr(free, f"{name}_rest")(at)[0]
        assert whole - rest == pytest.approx(limit(nu, name), abs=1e-14)


@given(nu=st.floats(0.0, 0.5))
def test_series_and_closed_forms_join(nu: float) -> None:
    """At alpha = 1/2 power series give way to hyperbolic functions: no step."""
    at = np.array([0.5 * (1 - 1e-12), 0.5 * (1 + 1e-12)])
    free, covered = LayerTransfer(nu), CoveredTransfer(nu)
    for model, names in ((free, ("normal", "coupling", *BASE)), (covered, COVERED)):
        for name in names:
            below, above = getattr(model, name)(at)
            assert below == pytest.approx(above, rel=1e-10, abs=1e-11), name
