"""Forces along the skin: their readings against the press solver, and contacts that push."""

from functools import lru_cache

import numpy as np
import pytest

import skinfield as sf
from skinfield.elastic import (
    BaseStress,
    BondedLayer,
    Capacitance,
    HalfSpace,
    Layer,
    Mechanics,
    Physics,
)
from skinfield.errors import Floats
from skinfield.simulate import Sphere
from skinfield.simulate.pressing.press import Press, press, readings_around
from skinfield.solve.atoms.shear_table import Traction, shear_readings

LAYER, PATCH, NOISE = Layer(2e-3, 150e3, 0.5), sf.layouts.hexagon72(), 0.0005
FORCE, PUSH, CENTRE = 1.0, (0.35, -0.2), (0.0, 0.0)
NEAR = PATCH.plane[np.argmin(np.hypot(*(PATCH.plane - [9e-3, 6e-3]).T))]  # a taxel amid others
PLACE = (float(NEAR[0]) + 1.5e-3, float(NEAR[1]) - 1e-3)


@lru_cache(maxsize=4)
def pushed(
    push: tuple[float, float],
    friction: float | None = None,
    place: tuple[float, float] = PLACE,
) -> Press:
    body = Sphere(radius=6e-3, force=FORCE, position=place, shear=push)
    extent = 2.0 * float(np.abs(place).max()) + 30e-3
    return press(LAYER, [body], extent, 0.4e-3, friction=friction)


def readings_of(push: tuple[float, float], seed: int) -> Floats:
    rng = np.random.default_rng(seed)
    change = pushed(push).readings(PATCH.plane, PATCH.pad_diameter, "capacitance")
    return np.asarray(change + rng.normal(scale=NOISE, size=len(PATCH)))


@pytest.fixture(scope="module", name="rec")
def _rec() -> sf.Reconstructor:
    return sf.Reconstructor(PATCH, LAYER, noise_std=NOISE)


@pytest.mark.parametrize(
    ("name", "share"), [("stress", 0.16), ("capacitance", 0.13)]
)  # what sticking and sliding differ by; and the gap's nonlinearity
def test_the_dipole_is_that_of_the_press(name: str, share: float) -> None:
    """An even traction lies between one that sticks and one that slides, by another solver."""
    quantity = BaseStress() if name == "stress" else Capacitance()
    physics = Physics(LAYER, BondedLayer(), quantity, PATCH.pad_diameter)
    for friction in (None, 0.41):
        made = pushed((0.4, 0.0), friction, CENTRE)
        around = readings_around(made, PATCH.pad_diameter, name)
        found, r = around.harmonics[1] / 0.4, around.distance
        even = Traction.even(np.sqrt(made.contact_area / np.pi) / LAYER.thickness)
        per_distance = shear_readings(physics, [even], r / LAYER.thickness)[0]
        model = per_distance * r / LAYER.thickness
        off = np.sqrt(np.mean(r * (found - model) ** 2) / np.mean(r * found**2))
        assert off < share
        assert np.sign(model[np.abs(model).argmax()]) == (1.0 if name == "stress" else -1.0)


def test_a_push_is_told_by_direction_and_size(rec: sf.Reconstructor) -> None:
    inside = 0
    for seed in range(4):
        rec.reset()
        (contact,) = rec(readings_of(PUSH, seed)).contacts
        assert np.linalg.norm(contact.position[:2] - PLACE) < 0.4e-3
        assert contact.normal_force == pytest.approx(FORCE, rel=0.15)
        off = contact.shear[:2] - PUSH
        assert np.linalg.norm(off) < 0.12
        assert contact.force @ contact.normal == pytest.approx(-contact.normal_force)
        assert off @ np.linalg.solve(contact.force_covariance[:2, :2], off) < 13.8  # of one in 1000
        inside += np.linalg.norm(off) < 0.08
    assert inside >= 2


def test_what_only_presses_has_no_push(rec: sf.Reconstructor) -> None:
    for seed in range(4):
        rec.reset()
        (contact,) = rec(readings_of((0.0, 0.0), seed)).contacts
        assert not contact.shear.any()
        assert contact.normal_force == pytest.approx(FORCE, rel=0.15)
        widths = np.sqrt(np.diag(contact.force_covariance))
        assert widths[0] == pytest.approx(0.35 * contact.normal_force, rel=0.02)


@pytest.mark.parametrize("mechanics", [BondedLayer(inextensible_cover=True), HalfSpace()])
def test_where_nothing_tells_of_a_push_none_is_sought(mechanics: Mechanics) -> None:
    physics = Physics(LAYER, mechanics, Capacitance(), PATCH.pad_diameter)
    made = shear_readings(physics, [Traction.even(1.0)], np.linspace(0.0, 5.0, 9))
    assert made.shape == (1, 0)
