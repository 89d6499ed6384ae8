"""Presses against closed forms and the exact axisymmetric solver, half-space to thin layer.

Neither shares anything with the lattice but the layer's response to a wave. Bodies are a ball, a
flat end and a cone; contacts have 6 cells across, as coarse as tables of results are made of.
"""

from dataclasses import replace

import numpy as np
import pytest
from closed_forms import (
    effective_modulus,
    hertz,
    partial_slip,
    stuck_displacement,
    stuck_traction,
)
from round_profiles import RoundedFlat, Taper

from skinfield.elastic import Layer
from skinfield.elastic.axisymmetric import (
    Ball,
    Indentation,
    indent_by_force,
    indent_to_radius,
    punch,
)
from skinfield.simulate import Cone, Cylinder, Indenter, Press, Sphere, press

H, E = 4e-3, 1e5
SHARES = (0.2, 0.5, 1.0, 2.0, 3.0)  # contact radius over thickness
SLOPE = 0.05
# Of depth, radius and base stress below the tip, relative; of the surface beside it, in depths; of
# the cells' mean pressure, in mean pressures. All are a third above the largest that was found.
LIMITS = {
    "ball": {"depth": 2e-4, "radius": 5e-3, "base": 3e-4, "beside": 1e-4, "pressure": 1e-3},
    "flat": {"depth": 1.2e-3, "radius": 5e-3, "base": 7e-4, "beside": 1e-4, "pressure": 1e-3},
    "cone": {"depth": 1e-4, "radius": 5e-3, "base": 5e-4, "beside": 1e-4, "pressure": 3e-3},
}


def pair(kind: str, a: float, layer: Layer) -> tuple[Indentation, Indenter]:
    """A state with the contact radius a, and the body that must come to it."""
    if kind == "flat":
        state = punch(layer, a, depth=0.01 * layer.thickness)
        return state, Cylinder(radius=a, force=state.force)
    if kind == "cone":
        state = indent_to_radius(layer, Taper(slope=SLOPE), a)
        return state, Cone(half_angle=np.arctan(1 / SLOPE), radius=3 * a, force=state.force)
    state = indent_to_radius(layer, Ball(radius=20 * a), a)
    return state, Sphere(radius=20 * a, force=state.force)


def solved(layer: Layer, body: Indenter, a: float, cells: float = 6.0) -> Press:
    return press(layer, [body], extent=4 * a, cell=2 * a / cells)


def cell_means(profile, a: float, pressed: Press, side: int = 12):
    """Mean of a profile over each cell that lies wholly in the contact, and which."""
    part = ((np.arange(side) + 0.5) / side - 0.5) * pressed.grid.pitch
    x, y = pressed.grid.plane.T
    r = np.hypot((x[:, None] + part)[:, :, None], (y[:, None] + part)[:, None, :])
    whole = r.max(axis=(1, 2)) < a
    return whole, profile(r[whole]).mean(axis=(1, 2))


@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("nu", [0.3, 0.45, 0.5])
@pytest.mark.parametrize("kind", LIMITS)
def test_a_press_on_the_layer(kind: str, nu: float, share: float) -> None:
    layer, a, limit = Layer(H, E, nu), share * H, LIMITS[kind]
    state, body = pair(kind, a, layer)
    pressed = solved(layer, body, a)
    assert pressed.force == pytest.approx(state.force, rel=1e-9)
    assert pressed.approach[0] == pytest.approx(state.depth, rel=limit["depth"])
    assert np.sqrt(pressed.contact_area / np.pi) == pytest.approx(a, rel=limit["radius"])
    below = pressed.base_stress([[0.0, 0.0]], 0.0)[0]
    assert below == pytest.approx(state.base_stress(0.0), rel=limit["base"])
    beside = pressed.gap_change([[2 * a, 0.0]], 0.0)[0]
    off = beside - float(state.indentation(2 * a))
    assert abs(off) < limit["beside"] * state.depth
    whole, mean = cell_means(state.pressure, a, pressed)
    error = np.abs(pressed.pressure[whole] - mean).max() / state.mean_pressure
    assert whole.sum() > 10
    assert error < limit["pressure"]


@pytest.mark.parametrize("kind", LIMITS)
@pytest.mark.parametrize("share", [0.2, 3.0])
def test_depth_gives_the_force(kind: str, share: float) -> None:
    """Force rises as depth, its square and up to its cube, and errs as much more."""
    layer, a = Layer(H, E, 0.5), share * H
    state, body = pair(kind, a, layer)
    pressed = solved(layer, replace(body, force=None, depth=state.depth), a)
    assert pressed.approach[0] == pytest.approx(state.depth, rel=1e-12)
    assert pressed.force == pytest.approx(state.force, rel=4 * LIMITS[kind]["depth"])


@pytest.mark.parametrize("nu", [0.3, 0.5])
def test_a_rounded_flat_end(nu: float) -> None:
    """A circular rim against the parabolic one, little of which touches."""
    layer = Layer(H, E, nu)
    body = Cylinder(radius=5e-3, edge_radius=3e-3, force=0.15)
    state = indent_by_force(layer, RoundedFlat(flat_radius=2e-3, edge_radius=3e-3), 0.15)
    assert 2.1e-3 < state.contact_radius < 2.9e-3
    pressed = press(layer, [body], extent=12e-3, cell=0.5e-3)
    assert pressed.approach[0] == pytest.approx(state.depth, rel=2e-3)
    assert np.sqrt(pressed.contact_area / np.pi) == pytest.approx(state.contact_radius, rel=0.01)


def test_a_sheared_flat_end_that_sticks() -> None:
    """Moves as Mindlin says, on an incompressible layer of 400 contact radii.

    Only there do tangential tractions not tip the surface, which Mindlin leaves out.
    """
    a, shear, nu = 1e-3, 5e-4, 0.5
    body = Cylinder(radius=a, force=1e-3, shear=(shear, 0.0))
    pressed = solved(Layer(400 * a, E, nu), body, a)
    moved = stuck_displacement(E, nu, a, shear)
    assert pressed.translation[0, 0] == pytest.approx(moved, rel=3e-3)
    assert abs(pressed.translation[0, 1]) < 1e-6 * moved
    whole, mean = cell_means(lambda r: stuck_traction(a, shear, r), a, pressed)
    error = np.abs(pressed.traction[whole, 0] - mean).max() / (shear / (np.pi * a**2))
    assert error < 3e-3


@pytest.mark.parametrize("share", [0.3, 0.7])
def test_a_sheared_ball_slips_in_a_ring(share: float) -> None:
    """Displacement within 0.4 % of Mindlin's, the ring's part of the area within 0.005."""
    a, star = 1e-3, effective_modulus(E, 0.5)
    ball = hertz(20 * a, star, a)
    shear = 0.5 * share * ball.force
    moved, stick_radius = partial_slip(ball, E, 0.5, 0.5, shear)
    body = Sphere(radius=20 * a, force=ball.force, shear=(shear, 0.0))
    pressed = press(Layer(400 * a, E, 0.5), [body], extent=4 * a, cell=a / 3, friction=0.5)
    assert pressed.translation[0, 0] == pytest.approx(moved, rel=4e-3)
    assert pressed.slipping_share == pytest.approx(1 - (stick_radius / a) ** 2, abs=5e-3)
