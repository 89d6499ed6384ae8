"""Thin-layer formulas against the exact solver: where they hold, and that they say so."""

import csv
from functools import cache

import numpy as np
import pytest

from skinfield.errors import InputError
from skinfield.mechanics import Layer
from skinfield.mechanics.axisymmetric import indent_to_depth, indent_to_radius, kappa
from skinfield.mechanics.hertz import HertzSphere, SneddonCone
from skinfield.mechanics.profiles import Paraboloid, Taper
from skinfield.mechanics.radial import gauss_legendre
from skinfield.mechanics.thin_layer import (
    CORRECTIONS,
    DIMITRIADIS,
    DIMITRIADIS_PRINTED,
    FOUNDATION_PARABOLOID,
    FOUNDATION_PUNCH,
    GARCIA_CONE,
    GARCIA_PARABOLOID,
    GARCIA_PUNCH,
    SQUEEZE_PARABOLOID,
    SQUEEZE_PUNCH,
    cone_reach,
    confined_modulus,
    edge_length,
    paraboloid_reach,
)
from skinfield.mechanics.transfer import LayerTransfer

H = 0.01  # m; the ratios have no dimension


@cache
def exact(body: str, nu: float, a_over_h: float) -> tuple[float, float]:
    """Reach, and force over that of the half-space at the same depth."""
    layer, a, star = Layer(H, 1.0, nu), a_over_h * H, 1 / (1 - nu**2)
    if body == "flat end":
        return a_over_h, kappa(a_over_h, nu)
    if body == "cone":
        state = indent_to_radius(layer, Taper(slope=0.1), a)
        free = SneddonCone.from_depth(slope=0.1, modulus=star, depth=state.depth)
        return cone_reach(0.1, state.depth, H), state.force / free.force
    state = indent_to_radius(layer, Paraboloid(radius=1.0), a)
    ball = HertzSphere.from_depth(radius=1.0, modulus=star, depth=state.depth)
    return paraboloid_reach(1.0, state.depth, H), state.force / ball.force


RANGES = [(each, limit) for each in CORRECTIONS for limit in each.ranges]


@pytest.mark.parametrize(
    ("correction", "limit"),
    RANGES,
    ids=[f"{c.name}, {r.poisson_ratio:g}, {r.error:g}" for c, r in RANGES],
)
def test_ranges_are_where_they_are_said_to_be(correction, limit) -> None:
    """The error is the stated one at the end, less inside, more outside."""
    nu, (low, high) = limit.poisson_ratio, limit.a_over_h

    def error(a_over_h: float) -> float:
        reach, ratio = exact(correction.body, nu, a_over_h)
        return abs(float(correction(reach, nu, beyond_range=True)) / ratio - 1)

    if low == np.inf:
        assert error(30.0) > limit.error
        return
    end = low if low > 0 else high
    assert error(end) == pytest.approx(limit.error, rel=0.03)  # three digits of the end
    assert exact(correction.body, nu, end)[0] == pytest.approx(limit.reach[low == 0.0], rel=5e-3)
    inside = np.geomspace(low, 30, 4)[1:] if low > 0 else np.geomspace(0.02, high, 6)[:-1]
    assert max(error(float(a)) for a in inside) < limit.error
    assert error(end * (0.95 if low > 0 else 1.05)) > limit.error


@pytest.mark.parametrize("error", [0.01, 0.05])
@pytest.mark.parametrize("correction", [DIMITRIADIS, FOUNDATION_PARABOLOID, FOUNDATION_PUNCH])
def test_between_the_ratios_that_were_measured(correction, error: float) -> None:
    for nu in (0.05, 0.15, 0.35):
        low, high = correction.valid_a_over_h(nu, error)
        for a in np.geomspace(max(low, 0.05), min(high, 15.0), 3):
            reach, ratio = exact(correction.body, nu, float(a))
            assert float(correction(reach, nu, beyond_range=True)) == pytest.approx(
                ratio, rel=1.2 * error
            )


def test_first_terms_are_integrals_of_the_layer() -> None:
    """Of 1 - X, which the papers have by fits and by other kernels."""
    k, share = gauss_legendre(0.0, 26.0, panels=100)
    for nu in (0.3, 0.4, 0.45, 0.5):
        first = 2 / np.pi * share @ -LayerTransfer(nu).normal_rest(k)
        slope = (float(DIMITRIADIS(1e-4, nu)) - 1) / 1e-4
        assert slope == pytest.approx(first, rel=0.007)
    for correction, share_of in ((GARCIA_PARABOLOID, 1.0), (GARCIA_CONE, 1.0), (GARCIA_PUNCH, 1.0)):
        slope = (float(correction(1e-4)) - 1) / 1e-4
        assert slope == pytest.approx(share_of * first, rel=0.007)


def test_wide_flat_ends_need_their_edge() -> None:
    """With it the limit is met to 1e-4 at 20 thicknesses, without it by a share h/a."""
    for nu in (0.0, 0.3, 0.4):
        stiff = np.pi / 2 * confined_modulus(nu) * (1 - nu**2)
        true = kappa(20.0, nu)
        assert float(FOUNDATION_PUNCH(20.0, nu)) == pytest.approx(true, rel=1e-4)
        assert stiff * 20 / true == pytest.approx(1 - 2 * edge_length(nu) / 20, abs=2e-3)
    assert float(SQUEEZE_PUNCH(20.0)) == pytest.approx(kappa(20.0, 0.5), rel=1e-3)
    assert edge_length(0.5) == pytest.approx(1.459, abs=1e-3)


def test_a_squeezed_paraboloid_in_numbers() -> None:
    """F = (2 pi/3) E R² depth³/h³ on a thin incompressible layer, by hand."""
    layer, radius = Layer(1e-3, 1e5, 0.5), 0.5
    state = indent_to_depth(layer, Paraboloid(radius=radius), 0.2e-3)
    assert state.contact_radius == pytest.approx(2 * np.sqrt(radius * 0.2e-3), rel=0.1)
    thin = 2 * np.pi / 3 * 1e5 * radius**2 * 0.2**3
    ball = HertzSphere.from_depth(radius=radius, modulus=1e5 / 0.75, depth=0.2e-3)
    reach = paraboloid_reach(radius, 0.2e-3, 1e-3)
    assert float(SQUEEZE_PARABOLOID(reach)) * ball.force == pytest.approx(thin, rel=1e-12)
    assert thin == pytest.approx(state.force, rel=0.05)


def test_table_columns_are_these_formulas(shared_data) -> None:
    with (shared_data / "tables" / "paraboloid_bonded_layer_nu0.5.csv").open() as file:
        for row in csv.DictReader(file):
            reach = float(row["chi"])
            for correction, name in (
                (DIMITRIADIS_PRINTED, "dimitriadis2002"),
                (GARCIA_PARABOLOID, "garcia2018"),
            ):
                found = float(correction(reach, 0.5, beyond_range=True))
                assert found == pytest.approx(float(row[name]), rel=5e-4)
    with (shared_data / "tables" / "hayes_flat_punch_kappa.csv").open() as file:
        for row in csv.DictReader(file):
            found = float(GARCIA_PUNCH(float(row["a_over_h"]), 0.5, beyond_range=True))
            assert found == pytest.approx(float(row["kappa_garcia2018_series_nu0.50"]), rel=1e-5)


def test_beyond_its_range_a_formula_refuses() -> None:
    with pytest.raises(InputError, match=r"reach is 1, expected 0 to 0.388.*beyond_range=True"):
        DIMITRIADIS([0.1, 1.0], 0.5)
    assert float(DIMITRIADIS(1.0, 0.5, beyond_range=True)) > 1
    with pytest.raises(InputError, match=r"nowhere within 1%"):
        SQUEEZE_PARABOLOID(20.0, error=0.01)
    with pytest.raises(InputError, match=r"poisson_ratio is 0.3"):
        GARCIA_PARABOLOID(0.1, 0.3)
    with pytest.raises(InputError, match=r"error is 0.02"):
        DIMITRIADIS(0.1, error=0.02)
    with pytest.raises(InputError, match=r"reach is nan"):
        DIMITRIADIS(float("nan"))
