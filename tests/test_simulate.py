"""Presses with known truth: forces, complementarity, and what the readings say."""

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import InputError
from skinfield.mechanics import HalfSpace
from skinfield.simulate import Cylinder, Sphere, press

LAYER = sf.Layer(2e-3, 100e3, 0.5)
BALL = Sphere(radius=6e-3, force=1.0)


def test_a_ball_on_the_layer_has_the_published_depth_and_stress() -> None:
    """A finite-element solution of the same contact: 0.6258 mm, 56.3 kPa at the base, 2.63 mm."""
    found = press(LAYER, [BALL], extent=16e-3, cell=0.2e-3)
    assert found.approach == pytest.approx([0.6258e-3], rel=1e-3)
    assert found.base_stress([[0, 0]], 0.0) == pytest.approx([56.3e3], rel=2e-3)
    assert np.sqrt(found.contact_area / np.pi) == pytest.approx(2.63e-3, rel=0.02)


@pytest.mark.parametrize(
    ("force", "change"), [(0.5, 0.1258), (1.0, 0.2389)]
)  # of a solution of Laplace's equation between the deformed electrodes
def test_the_capacitance_of_a_centred_pad_is_that_of_the_deformed_gap(
    force: float, change: float
) -> None:
    found = press(LAYER, [Sphere(radius=6e-3, force=force)], extent=16e-3, cell=0.2e-3)
    assert found.capacitance([[0, 0]], 4e-3) == pytest.approx([change], rel=0.03)
    assert found.capacitance([[0, 0]], 4e-3, order=1)[0] < 0.75 * change


def test_a_small_contact_on_a_thick_layer_is_hertz() -> None:
    thick, radius = sf.Layer(100e-3, 100e3, 0.5), 6e-3
    modulus = 100e3 / 0.75
    found = press(thick, [Sphere(radius=radius, force=0.05)], extent=6e-3, cell=0.06e-3)
    edge = (3 * 0.05 * radius / (4 * modulus)) ** (1 / 3)
    assert np.sqrt(found.contact_area / np.pi) == pytest.approx(edge, rel=0.02)
    assert found.pressure.max() == pytest.approx(1.5 * 0.05 / (np.pi * edge**2), rel=0.02)
    # A sphere, not a paraboloid, and a layer of 100 mm: 2 % in depth.
    assert found.approach == pytest.approx([edge**2 / radius], rel=0.025)


def test_forces_are_exact_and_pressure_only_pushes() -> None:
    balls = [Sphere(radius=6e-3, force=1.0, position=(-8e-3, 0)),
             Cylinder(radius=3e-3, force=0.4, position=(8e-3, 3e-3))]  # fmt: skip
    found = press(LAYER, balls, extent=40e-3, cell=0.5e-3)
    left = found.grid.plane[:, 0] < 0
    assert found.pressure[left].sum() * found.grid.cell_area == pytest.approx(1.0, rel=1e-9)
    assert found.force == pytest.approx(1.4, rel=1e-9)
    assert found.pressure.min() == 0.0


def test_the_surface_follows_the_ball_where_it_touches_and_stays_below_it_elsewhere() -> None:
    found = press(LAYER, [BALL], extent=24e-3, cell=0.4e-3)
    depth = -found.displacement[:, 2]
    x, y = found.grid.plane.T
    ball = found.approach[0] - BALL.height(x, y)
    assert depth[found.contact] == pytest.approx(ball[found.contact], abs=1e-7)
    free = ~found.contact & np.isfinite(ball)
    assert (depth[free] - ball[free]).min() > -1e-7


def test_readings_are_in_equilibrium_and_symmetric() -> None:
    found = press(LAYER, [BALL], extent=20e-3, cell=0.5e-3)
    axis = np.arange(-16, 17) * 1.5e-3
    places = np.stack(np.meshgrid(axis, axis), -1).reshape(-1, 2)
    stress = found.base_stress(places, 0.0)
    assert stress.sum() * 1.5e-3**2 == pytest.approx(1.0, rel=1e-3)
    picture = found.gap_change(places, 4e-3).reshape(33, 33)
    assert picture == pytest.approx(picture[::-1, ::-1], abs=1e-9)
    assert picture == pytest.approx(picture.T, abs=1e-9)


def test_the_bonded_base_carries_most_of_a_press() -> None:
    """1.74 mm by Hertz on a half-space, 0.626 mm on the layer: the base is felt through it."""
    layer = press(LAYER, [BALL], extent=20e-3, cell=0.5e-3)
    thick = press(sf.Layer(200e-3, 100e3), [BALL], extent=20e-3, cell=0.5e-3)
    assert thick.approach[0] > 2.5 * layer.approach[0]
    half = press(LAYER, [BALL], 20e-3, 0.5e-3, mechanics=HalfSpace(point_forces=False))
    assert half.approach[0] != pytest.approx(layer.approach[0], rel=0.02)  # eq. (17) is no layer


def test_bad_indenters_are_named() -> None:
    with pytest.raises(InputError, match="radius is -1, expected a finite number above 0"):
        Sphere(radius=-1)
    with pytest.raises(InputError, match=r"indenters\[0\] at \(1.0, 0.0\) m covers no cell"):
        press(LAYER, [Sphere(radius=1e-3, position=(1.0, 0.0))])
    with pytest.raises(InputError, match="indenters is empty"):
        press(LAYER, [])
    with pytest.raises(InputError, match=r"indenters\[1\] at \(0.0, 0.0\) m lies behind"):
        press(LAYER, [BALL, BALL])
    with pytest.raises(
        InputError, match=r"indenters\[0\] with 100 N sinks .* into a layer of 2 mm"
    ):
        press(LAYER, [Sphere(radius=6e-3, force=100.0)], 30e-3, 1e-3)
    with pytest.raises(InputError, match="quantity is 'volts', expected one of"):
        press(LAYER, [BALL], 20e-3, 1e-3).readings([[0, 0]], 4e-3, "volts")
