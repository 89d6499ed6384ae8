"""Exact indentation of the bonded layer, and presses on it."""

import csv
from pathlib import Path

import numpy as np
import pytest
from closed_forms import flat_punch, hertz, hertz_by_depth, sneddon_cone, sneddon_sphere
from disc_rules import disc_rule, graded
from round_profiles import RoundedFlat, Taper
from scipy.special import ellipkm1, j0

from skinfield.elastic import Layer
from skinfield.elastic.axisymmetric import (
    Ball,
    Paraboloid,
    indent_by_force,
    indent_to_radius,
    kappa,
    punch,
)
from skinfield.elastic.hankel import LayerTransfer
from skinfield.errors import InputError

A = 10e-3  # radius of most contacts, m
BODIES = [
    Paraboloid(radius=3 * A),
    Ball(radius=1.4 * A),
    Taper(slope=0.4),
    RoundedFlat(flat_radius=0.6 * A, edge_radius=0.8 * A),
    None,
]
BY_NAME = pytest.mark.parametrize("body", BODIES, ids=lambda body: type(body).__name__)
PLACES = np.array([0.05, 0.5, 0.8, 0.95, 1.2, 3.0])


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_a_thick_layer_is_the_half_space(nu: float) -> None:
    """Depth, force, pressure and surface of four bodies; the layer is 1e9 radii thick."""
    a, layer, star = 1e-9, Layer(1.0, 1.0, nu), 1 / (1 - nu**2)
    pairs = [
        (Paraboloid(radius=3 * a), hertz(3 * a, star, a)),
        (Taper(slope=0.4), sneddon_cone(0.4, star, a)),
        (None, flat_punch(a, star, 1.0)),
    ]
    for body, closed in pairs:
        state, r = indent_to_radius(layer, body, a), a * PLACES
        assert state.depth == pytest.approx(closed.depth, rel=1e-8)
        assert state.force == pytest.approx(closed.force, rel=1e-8)
        np.testing.assert_allclose(state.pressure(r), closed.pressure(r), rtol=1e-7)
        np.testing.assert_allclose(state.indentation(r), closed.indentation(r), rtol=1e-7)
    ball = indent_to_radius(layer, Ball(radius=1.4 * a), a)
    depth_and_force = sneddon_sphere(1.4 * a, star, a)
    assert (ball.depth, ball.force) == pytest.approx(depth_and_force, rel=1e-8, abs=0)


def forward(state, r: float, kink: float) -> float:
    """Displacement of the state's own pressure: half-space by rings, the rest by Hankel sums."""
    nu, h = state.layer.poisson_ratio, state.layer.thickness

    angle, weight = graded(np.arcsin(kink / A), np.arcsin(min(r / A, 1.0)))
    other = A * np.sin(angle)
    less = np.maximum(((r - other) / (r + other)) ** 2, 1e-300)  # 1 - m
    ring = state.pressure(other) * other * 4 * ellipkm1(less) / (r + other) * A * np.cos(angle)
    own = weight @ ring
    k = (np.arange(2600) + 0.5) * 0.01 / h
    others, weight = disc_rule(kink / A)
    hankel = j0(np.outer(k, A * others)) @ (weight * state.pressure(A * others)) * A**2
    rest = np.sum(LayerTransfer(nu).normal_rest(k * h) * hankel * j0(k * r)) * 0.01 / h
    return float((own + rest) / (np.pi * state.modulus))


@BY_NAME
@pytest.mark.parametrize(("nu", "h"), [(0.5, 0.5), (0.3, 2.0)])
def test_the_pressure_makes_the_surface_follow_the_body(body, nu: float, h: float) -> None:
    """A sum that knows nothing of the integral equation gives depth less height, and outside."""
    state = indent_to_radius(Layer(h * A, 1.0, nu), body, A)
    kink = 0.0 if body is None else body.kink
    scale = state.depth
    for r in (0.3 * A, 0.9 * A, 1.4 * A):
        assert forward(state, r, kink) == pytest.approx(
            float(state.indentation(r)), abs=3e-6 * scale
        )


@BY_NAME
@pytest.mark.parametrize(("nu", "h"), [(0.5, 0.3), (0.45, 1.0), (0.0, 5.0)])
def test_pressure_and_base_stress_carry_the_force(body, nu: float, h: float) -> None:
    state = indent_to_radius(Layer(h * A, 1e5, nu), body, A)
    r, weight = disc_rule(0.0 if body is None else body.kink / A)
    assert weight @ state.pressure(A * r) * A**2 == pytest.approx(state.force, rel=1e-6)
    assert state.mean_pressure * np.pi * A**2 == pytest.approx(state.force, rel=1e-12)
    far, step = np.linspace(0, A + 24 * h * A, 1501, retstep=True)
    base = np.trapezoid(state.base_stress(far) * 2 * np.pi * far, dx=float(step))
    assert base == pytest.approx(state.force, rel=1e-3)


@BY_NAME
def test_the_surface_is_whole_at_the_edge(body) -> None:
    state = indent_to_radius(Layer(0.7 * A, 1.0, 0.5), body, A)
    inside, outside = state.indentation([A, A * (1 + 1e-10)])
    assert outside == pytest.approx(inside, abs=5e-5 * state.depth)
    if body is not None:
        assert state.springs([A])[0] == pytest.approx(0.0, abs=1e-12)
        assert state.pressure([A * (1 - 1e-9)])[0] < 1e-3 * state.mean_pressure


@pytest.mark.parametrize("body", BODIES[:-1], ids=lambda body: type(body).__name__)
@pytest.mark.parametrize("nu", [0.2, 0.5])
def test_the_force_leads_to_the_radius(body, nu: float) -> None:
    layer = Layer(0.5 * A, 2e5, nu)
    for a in (0.61 * A, 1.3 * A):
        state = indent_to_radius(layer, body, a)
        by_force = indent_by_force(layer, body, state.force)
        assert by_force.contact_radius == pytest.approx(a, rel=1e-8)
        assert by_force.force == pytest.approx(state.force, rel=1e-9)


def rows(shared_data: Path, name: str) -> list[dict[str, float]]:
    with (shared_data / "tables" / name).open() as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def test_tables_are_met_to_their_last_digit(shared_data) -> None:
    for row in rows(shared_data, "hayes_flat_punch_kappa.csv"):
        for nu in (0.3, 0.45, 0.5):
            wanted = row[f"kappa_computed_nu{nu:.2f}"]
            assert kappa(row["a_over_h"], nu) == pytest.approx(wanted, rel=5e-6)
    for row in rows(shared_data, "paraboloid_bonded_layer_nu0.5.csv"):
        a, radius = row["a_over_h"], 20 * row["a_over_h"]
        state = indent_to_radius(Layer(1.0, 1.0, 0.5), Paraboloid(radius=radius), a)
        half_space = hertz_by_depth(radius, 4 / 3, state.depth)
        assert state.depth == pytest.approx(row["delta_over_h"], rel=5e-6)
        assert half_space.contact_radius == pytest.approx(row["chi"], rel=5e-6)
        assert state.force / half_space.force == pytest.approx(row["F_over_FHertz_exact"], rel=5e-6)


UNIT, BALL = Layer(1.0, 1.0, 0.5), Ball(radius=2.0)
FLAT = RoundedFlat(flat_radius=0.6, edge_radius=0.1)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: indent_to_radius(UNIT, BALL, 2.5), r"contact_radius is 2.5 m"),
        (lambda: indent_to_radius(UNIT, FLAT, 0.5), r"contact_radius is 0.5 m, expected above 0.6"),
        (lambda: indent_to_radius(UNIT, None, 61.0), "60 thicknesses"),
        (lambda: indent_by_force(Layer(1e-3, 1.0, 0.5), FLAT, 1.0), "60 thicknesses"),
        (lambda: indent_by_force(UNIT, Paraboloid(radius=1.0), 1e12), "expected less"),
        (lambda: punch(UNIT, 1.0), "exactly one"),
        (lambda: indent_by_force(UNIT, BALL, -1.0), "force is -1"),
    ],
)
def test_bad_values_are_named(call, words: str) -> None:
    with pytest.raises(InputError, match=words):
        call()
