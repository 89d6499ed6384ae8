"""Closed forms on the half-space against integrals of Boussinesq's and Cerruti's point forces."""

import re
from pathlib import Path

import numpy as np
import pytest
from disc_rules import disc_rule, graded
from scipy.integrate import quad
from scipy.special import ellipkm1

from skinfield.elastic.hertz import (
    FlatPunch,
    FullStick,
    HertzLine,
    HertzSphere,
    PartialSlip,
    SneddonCone,
    SneddonSphere,
    effective_modulus,
    tangential_stiffness,
)
from skinfield.errors import InputError

E, NU = 2e5, 0.4
STAR = effective_modulus(E, NU)
A = 1.3e-3
CONTACTS = [
    HertzSphere(radius=4e-3, modulus=STAR, contact_radius=A),
    SneddonSphere(radius=1.9e-3, modulus=STAR, contact_radius=A),
    SneddonSphere(radius=40e-3, modulus=STAR, contact_radius=A),
    SneddonCone(slope=0.3, modulus=STAR, contact_radius=A),
    FlatPunch(contact_radius=A, modulus=STAR, approach=0.4e-3),
]
BY_NAME = pytest.mark.parametrize("body", CONTACTS, ids=lambda body: type(body).__name__)


def by_rings(body, r: float) -> float:
    """Displacement below the pressure: rings of point forces, by complete elliptic integrals."""

    angle, weight = graded(np.arcsin(min(r / A, 1.0)))
    other = A * np.sin(angle)
    less = np.maximum(((r - other) / (r + other)) ** 2, 1e-300)  # 1 - m
    ring = body.pressure(other) * other * 4 * ellipkm1(less) / (r + other) * A * np.cos(angle)
    return float(weight @ ring) / (np.pi * STAR)


@BY_NAME
def test_the_pressure_carries_the_force(body) -> None:
    r, weight = disc_rule()
    assert weight @ body.pressure(A * r) * A**2 == pytest.approx(body.force, rel=1e-7)
    assert body.mean_pressure * np.pi * A**2 == pytest.approx(body.force, rel=1e-12)
    assert body.pressure([1.001 * A, 3 * A]).tolist() == [0.0, 0.0]


@BY_NAME
@pytest.mark.parametrize("share", [0.2, 0.7, 1.3, 4.0])
def test_the_displacement_is_that_of_the_pressure(body, share: float) -> None:
    assert body.indentation(share * A) == pytest.approx(by_rings(body, share * A), rel=1e-6)


@BY_NAME
def test_the_surface_is_whole_at_the_edge(body) -> None:
    inside, outside = body.indentation([A * (1 - 1e-12), A * (1 + 1e-12)])
    assert outside == pytest.approx(inside, rel=1e-5)


@BY_NAME
def test_force_is_the_slope_of_the_energy(body) -> None:
    """dU/d depth = F, with U half the pressure times the displacement."""
    make, r, weight = type(body).from_depth, *disc_rule()
    own = "contact_radius" if isinstance(body, FlatPunch) else None
    own = own or ("slope" if isinstance(body, SneddonCone) else "radius")

    def energy(depth: float) -> float:
        at = make(**{own: getattr(body, own)}, modulus=STAR, depth=depth)
        a = at.contact_radius
        return float(weight @ (at.pressure(a * r) * at.indentation(a * r)) * a**2 / 2)

    step = 1e-4 * body.depth
    slope = (energy(body.depth + step) - energy(body.depth - step)) / (2 * step)
    assert slope == pytest.approx(body.force, rel=2e-6)


@BY_NAME
def test_depth_and_force_lead_back(body) -> None:
    kinds = {FlatPunch: "contact_radius", SneddonCone: "slope"}
    own = {(name := kinds.get(type(body), "radius")): getattr(body, name), "modulus": STAR}
    for again in (
        type(body).from_depth(**own, depth=body.depth),
        type(body).from_force(**own, force=body.force),
    ):
        assert again.contact_radius == pytest.approx(A, rel=1e-10)
        assert again.force == pytest.approx(body.force, rel=1e-9)
        assert again.depth == pytest.approx(body.depth, rel=1e-9)


def test_hertz_in_numbers() -> None:
    """A ball of 12 mm with 1 N on rubber of 100 kPa, nu = 0.5, by hand."""
    ball = HertzSphere.from_force(radius=6e-3, modulus=effective_modulus(1e5, 0.5), force=1.0)
    assert ball.contact_radius == pytest.approx((0.75 * 6e-3 / (1e5 / 0.75)) ** (1 / 3), rel=1e-14)
    assert ball.depth == pytest.approx(1.7406e-3, rel=1e-4)
    assert ball.peak_pressure == pytest.approx(1.5 * ball.mean_pressure, rel=1e-14)


def test_a_true_sphere_is_hertz_when_shallow() -> None:
    for share, off in ((1e-3, 1e-5), (0.09, 1e-2), (0.11, 1e-2)):
        true = SneddonSphere(radius=1.0, modulus=1.0, contact_radius=share)
        taken = HertzSphere(radius=1.0, modulus=1.0, contact_radius=share)
        assert true.depth == pytest.approx(taken.depth, rel=off)
        assert true.force == pytest.approx(taken.force, rel=off)
        assert true.force > taken.force


def test_line_contact() -> None:
    """The pressure carries the load, and bends the surface to the cylinder's slope x/R."""
    line = HertzLine(radius=5e-3, modulus=STAR, force_per_length=80.0)
    b = line.half_width
    total = quad(lambda x: float(line.pressure(x)), -b, b)[0]
    assert total == pytest.approx(80.0, rel=1e-8)
    for x in (0.2 * b, -0.6 * b):
        slope = quad(lambda s: float(line.pressure(s)), -b, b, weight="cauchy", wvar=x)[0]
        assert 2 / (np.pi * STAR) * -slope == pytest.approx(x / 5e-3, rel=1e-6)


def along_rays(traction, a: float, x: float, y: float) -> tuple[float, float]:
    """Tangential displacement (along and across the load) at a place inside, by Cerruti.

    (1 + nu)/(pi E) times the integral of [(1 - nu) + nu cos²] over chords through the place.
    """
    angle = np.pi * (np.arange(60) + 0.5) / 60
    node, weight = np.polynomial.legendre.leggauss(200)
    turn, weight = node * np.pi / 2, weight * np.pi / 2
    offset = x * np.sin(angle) - y * np.cos(angle)  # of the chord from the centre
    half = np.sqrt(a**2 - offset**2)
    r = np.hypot(offset[:, None], half[:, None] * np.sin(turn))
    chord = half * (traction(r) * np.cos(turn) @ weight)
    scale = (1 + NU) / (np.pi * E) * np.pi / 60
    along = scale * np.sum(((1 - NU) + NU * np.cos(angle) ** 2) * chord)
    return float(along), float(scale * np.sum(NU * np.cos(angle) * np.sin(angle) * chord))


def test_full_stick_moves_as_one() -> None:
    stuck = FullStick(contact_radius=A, young_modulus=E, poisson_ratio=NU, shear=0.3)
    r, weight = disc_rule()
    assert weight @ stuck.traction(A * r) * A**2 == pytest.approx(0.3, rel=1e-9)
    for x, y in ((0.0, 0.0), (0.5 * A, 0.2 * A), (-0.1 * A, 0.8 * A)):
        along, across = along_rays(stuck.traction, A, x, y)
        assert along == pytest.approx(stuck.displacement, rel=1e-6)
        assert abs(across) < 1e-9 * along
    assert stuck.displacement * tangential_stiffness(E, NU, A) == pytest.approx(0.3, rel=1e-14)


def test_partial_slip_sticks_inside_and_slides_outside() -> None:
    ball = HertzSphere(radius=4e-3, modulus=STAR, contact_radius=A)
    slip = PartialSlip(
        normal=ball, young_modulus=E, poisson_ratio=NU, friction=0.5, shear=0.3 * ball.force
    )
    c = slip.stick_radius
    assert c == pytest.approx(A * 0.4 ** (1 / 3), rel=1e-12)
    r, weight = disc_rule(c / A)
    assert weight @ slip.traction(A * r) * A**2 == pytest.approx(slip.shear, rel=1e-6)
    ring = np.linspace(c, A, 20)
    np.testing.assert_allclose(slip.traction(ring), 0.5 * ball.pressure(ring), rtol=1e-12)
    inside = np.linspace(0, 0.99 * c, 20)
    assert np.all(slip.traction(inside) < 0.5 * ball.pressure(inside))
    for x, y in ((0.0, 0.0), (0.6 * c, 0.0), (0.1 * c, -0.7 * c)):
        sliding, _ = along_rays(lambda r: 0.5 * ball.pressure(r), A, x, y)
        held, _ = along_rays(lambda r: 0.5 * ball.pressure(r) - slip.traction(r), c, x, y)
        assert sliding - held == pytest.approx(slip.displacement, rel=1e-6)
    gentle = PartialSlip(
        normal=ball, young_modulus=E, poisson_ratio=NU, friction=0.5, shear=1e-6 * ball.force
    )
    stiff = tangential_stiffness(E, NU, A)
    assert gentle.displacement * stiff == pytest.approx(gentle.shear, rel=1e-5)


def test_bad_values_are_named() -> None:
    ball = HertzSphere(radius=4e-3, modulus=STAR, contact_radius=A)
    with pytest.raises(InputError, match=r"shear is .*the body slides"):
        PartialSlip(normal=ball, young_modulus=E, poisson_ratio=NU, friction=0.1, shear=ball.force)
    with pytest.raises(InputError, match=r"contact_radius is .*below the equator"):
        SneddonSphere(radius=A, modulus=STAR, contact_radius=A)
    for wrong in (0.0, -1.0, float("nan")):
        with pytest.raises(InputError, match="depth is"):
            HertzSphere.from_depth(radius=1e-3, modulus=STAR, depth=wrong)
        with pytest.raises(InputError, match="force is"):
            SneddonCone.from_force(slope=0.3, modulus=STAR, force=wrong)


def test_the_page_runs_and_gives_its_numbers() -> None:
    page = Path(__file__).resolve().parents[1] / "docs" / "closed-forms.md"
    names: dict[str, object] = {}
    for code in re.findall(r"^```python\n(.*?)^```$", page.read_text("utf-8"), re.M | re.S):
        exec(compile(code, str(page), "exec"), names)
    ball, state = names["ball"], names["state"]
    assert ball.depth == pytest.approx(1.741e-3, abs=1e-6)
    assert ball.contact_radius == pytest.approx(3.232e-3, abs=1e-6)
    assert ball.peak_pressure == pytest.approx(45.7e3, abs=100)
    assert state.depth == pytest.approx(0.626e-3, abs=1e-6)
    assert state.contact_radius == pytest.approx(2.626e-3, abs=1e-6)
