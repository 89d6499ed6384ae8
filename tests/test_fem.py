"""Finite elements against closed forms: presses at small strain, and the field in the gap."""

import sys

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import LinearNDInterpolator
from scipy.special import j0, j1

from skinfield.elastic import Layer
from skinfield.errors import InputError
from skinfield.lab.fem import Profile, indent, pad_capacitance
from skinfield.lab.fem.small_strain import section_around
from skinfield.simulate import Cone, Cylinder, Indenter, Ring, Sphere, press

SOFT = Layer(2e-3, 100e3, 0.5)


def profile(body: Indenter) -> Profile:
    return lambda radius: body.height(radius, np.zeros_like(radius))


BALL = profile(Sphere(radius=6e-3))
TWO_BALLS = [
    Sphere(radius=6e-3, force=0.8, position=(-3e-3, 0.0)),
    Sphere(radius=6e-3, force=0.5, position=(3e-3, 0.0)),
]


def exact_disc(radius: float, at: float, nu: float) -> tuple[float, float]:
    """Base stress at a radius and depth at the axis, of a disc of unit pressure; h = E = 1."""
    soft = 3 - 4 * nu

    def below(k: float) -> float:
        return float(soft * np.cosh(2 * k) + 2 * k**2 + 8 * nu**2 - 12 * nu + 5)

    def base(k: float) -> float:
        transfer = 4 * (1 - nu) * (k * np.sinh(k) + 2 * (1 - nu) * np.cosh(k)) / below(k)
        return float(transfer * radius * j1(k * radius) * j0(k * at))

    def added(k: float) -> float:
        share = (soft * np.sinh(2 * k) - 2 * k) / below(k) - 1
        return float(share * radius * j1(k * radius) / k)

    depth = radius + quad(added, 1e-9, 40, limit=400)[0]
    return quad(base, 0, 40, limit=400)[0], 2 * (1 - nu**2) * depth


@pytest.mark.parametrize("nu", [0.5, 0.49, 0.3, 0.0])
def test_a_loaded_disc_gives_the_base_stress_and_depth_of_the_layer(nu: float) -> None:
    section = section_around(Layer(2e-3, 100e3, nu), [0.75], 0.75, 0.01, 0.05)
    trace = section.trace
    forces = trace.loads(lambda r: np.where(r < 0.75, 1.0, 0.0))
    assert forces.sum() == pytest.approx(np.pi * 0.75**2, rel=1e-9)
    state = section.respond(forces)
    base = trace.density((section.stiffness @ state)[section.base_z])
    for at in (0.0, 0.5, 1.0, 2.0):
        stress, depth = exact_disc(0.75, at, nu)
        assert trace.at(base, np.array([at]))[0] == pytest.approx(stress, abs=2e-3 * 0.68)
    assert -state[section.top_z][0] == pytest.approx(depth, rel=3e-4)
    assert trace.integral(base) == pytest.approx(forces.sum(), rel=3e-4)


@pytest.mark.parametrize(("a", "kappa"), [(0.8, 2.86024), (3.0, 18.1574)])
def test_a_sharp_punch_has_the_stiffness_of_hayes_and_others(a: float, kappa: float) -> None:
    radius = a * 2e-3
    found = indent(SOFT, profile(Cylinder(radius=radius)), depth=1e-5)
    stiffness = found.force * 0.75 / (2 * 100e3 * radius * 1e-5)
    assert 0.0 < stiffness / kappa - 1 < 3e-3  # held displacements stiffen
    finer = indent(SOFT, profile(Cylinder(radius=radius)), depth=1e-5, finest=0.003)
    assert finer.force < found.force
    assert found.contact_radius == pytest.approx(radius, rel=5e-3)


@pytest.mark.parametrize(
    ("a", "chi", "over_hertz"),
    [(0.5, 0.417207, 1.85712), (1.0, 0.747941, 3.3711), (2.0, 1.34893, 8.46801)],
)
def test_a_paraboloid_presses_as_the_exact_solution(
    a: float, chi: float, over_hertz: float
) -> None:
    """Contact radius a and chi = sqrt(R depth), in thicknesses, and force over that of Hertz."""
    radius = 40e-3
    depth = (chi * 2e-3) ** 2 / radius
    found = indent(SOFT, lambda r: r**2 / (2 * radius), depth=depth)
    hertz = 16 / 9 * 100e3 * np.sqrt(radius) * depth**1.5
    assert found.force == pytest.approx(over_hertz * hertz, rel=2e-4)
    assert found.contact_radius == pytest.approx(a * 2e-3, rel=7e-3)


def test_a_ball_touches_without_pull_and_without_overlap() -> None:
    found = indent(SOFT, BALL, force=1.0)
    assert found.force == pytest.approx(1.0, rel=1e-9)
    nodes = found.surface.nodes
    gap = BALL(nodes) - found.depth - found.nodal_displacement[:, 1]
    assert found.nodal_force.min() == 0.0
    assert np.abs(gap[found.contact][1:]).max() < 1e-12
    assert gap[~found.contact].min() > 0
    pressure = found.pressure(np.linspace(0, 4e-3, 400))
    assert pressure.min() > -0.01 * pressure.max()
    assert pressure[300:].max() == 0.0
    half = indent(SOFT, BALL, depth=found.depth)
    assert half.force == pytest.approx(1.0, rel=1e-6)


def test_a_ring_touches_between_its_edges_and_a_cone_at_its_tip() -> None:
    ring = indent(SOFT, profile(Ring(inner_radius=2.5e-3, outer_radius=4e-3)), force=1.0)
    radius = ring.surface.nodes[ring.contact]
    assert radius.min() == pytest.approx(2.5e-3, abs=1e-9)
    assert radius.max() == pytest.approx(4e-3, abs=1e-9)
    assert ring.pressure([0.0, 1e-3]).tolist() == [0.0, 0.0]
    cone = indent(SOFT, profile(Cone(radius=6e-3, half_angle=np.arctan(1 / 0.3))), force=0.5)
    assert cone.pressure([0.05e-3])[0] > 2 * cone.pressure([0.5 * cone.contact_radius])[0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "force is None and depth is None, expected exactly one"),
        ({"force": 1.0, "depth": 1e-4}, "expected exactly one"),
        ({"force": -1.0}, "force is -1.0, expected a finite number above 0"),
        ({"depth": 3e-3}, "depth is 0.003 m, expected less than the layer's 0.002 m"),
        ({"force": 50.0}, "which sinks the body through the layer"),
        ({"force": 1.0, "finest": 0.0}, "finest is 0.0"),
    ],
)
def test_loads_that_cannot_be_are_named(arguments: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        indent(SOFT, BALL, **arguments)


def test_bodies_that_cannot_be_are_named_and_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match=r"profile gives .* expected as many heights of"):
        indent(SOFT, lambda r: r - 1e-3, force=1.0)
    with pytest.raises(InputError, match="profile is nowhere below"):
        indent(SOFT, lambda r: np.full_like(r, np.inf), force=1.0)
    monkeypatch.setitem(sys.modules, "skfem", None)
    with pytest.raises(InputError, match=r"pip install 'skinfield\[lab\]'"):
        indent(SOFT, BALL, force=1.0)


PAD, H = 4e-3, 2e-3


def test_a_gap_that_is_narrower_everywhere_holds_the_charge_of_plates() -> None:
    found = pad_capacitance(H, lambda r: np.full_like(r, 0.3 * H), [0.0, 3e-3], PAD)
    assert found == pytest.approx([1 / 0.7 - 1] * 2, rel=1e-9)


def test_a_slight_ripple_is_smoothed_by_the_distance_to_the_pads() -> None:
    """J0(kr) a on the plane gives a/h kh/sinh(kh) J0(kr) on the pads, to first order in a."""
    k, small = 1.2 / H, 1e-5
    found = pad_capacitance(
        H, lambda r: small * H * j0(k * r) * np.exp(-((r / 30e-3) ** 8)), [0.0, 3e-3], PAD,
        reach=40e-3,
    )  # fmt: skip
    smooth = 1.2 / np.sinh(1.2) * 2 * j1(k * PAD / 2) / (k * PAD / 2)
    assert found / small == pytest.approx(smooth * j0(k * np.array([0.0, 3e-3])), abs=2e-3)


@pytest.mark.parametrize(
    ("radius", "force", "change", "short"),
    [(6e-3, 0.5, 0.1258, 0.01), (6e-3, 1.0, 0.2389, 0.022), (6e-3, 3.0, 0.6853, 0.10),
     (3e-3, 1.0, 0.4038, 0.07), (3e-3, 3.0, 2.1626, 0.396)],
)  # fmt: skip
def test_a_press_reads_the_field_and_the_series_falls_short_of_it(
    radius: float, force: float, change: float, short: float
) -> None:
    """ΔC/C₀ of a centred pad, by two other Laplace solutions; `short` is what the series lacks."""
    found = indent(SOFT, profile(Sphere(radius=radius)), force=force)
    judge = pad_capacitance(H, found.indentation, [0.0], PAD, edges=[found.contact_radius])[0]
    assert judge == pytest.approx(change, rel=2e-3)
    found = press(SOFT, [Sphere(radius=radius, force=force)], extent=16e-3, cell=0.4e-3)
    assert found.capacitance([[0.0, 0.0]], PAD)[0] == pytest.approx(judge, rel=1e-3)
    series = found.capacitance([[0.0, 0.0]], PAD, order=3)[0]
    assert 1 - series / judge == pytest.approx(short, abs=0.004)


def test_pads_off_the_axis_read_as_the_field_says() -> None:
    found = indent(SOFT, BALL, force=0.5)
    away = np.array([2e-3, 3e-3, 4e-3, 5e-3, 8e-3])
    judge = pad_capacitance(H, found.indentation, away, PAD, edges=[found.contact_radius])
    found = press(SOFT, [Sphere(radius=6e-3, force=0.5)], extent=16e-3, cell=0.4e-3)
    places = np.column_stack([away, np.zeros(5)])
    assert found.capacitance(places, PAD) == pytest.approx(judge, abs=3e-5)
    assert found.capacitance(places, PAD, order=3) == pytest.approx(judge, abs=6e-4)
    assert judge[3] < 0  # beside the ball the elastomer comes up


@pytest.mark.parametrize(
    ("force", "near"), [(0.5, 0.015), (1.0, 0.025), (1.4, 0.025)]
)  # 0.23, 0.46 and 0.65 of the thickness
def test_a_sharp_edge_costs_some_of_the_fields_accuracy(force: float, near: float) -> None:
    end = indent(SOFT, profile(Cylinder(radius=1.5e-3)), force=force, finest=0.01)
    judge = pad_capacitance(
        H, end.indentation, [0.0, 2e-3], PAD, edges=[end.contact_radius], finest=0.01
    )
    body = Cylinder(radius=1.5e-3, force=force, position=(0.13e-3, 0.07e-3))
    pads = [[0.13e-3, 0.07e-3], [2.13e-3, 0.07e-3]]
    found = press(SOFT, [body], extent=10e-3).capacitance(pads, PAD)
    assert found == pytest.approx(judge, abs=near * judge[0])


def test_a_plane_that_touches_the_pads_is_refused() -> None:
    with pytest.raises(InputError, match=r"indentation reaches 1\.20 of the thickness"):
        pad_capacitance(H, lambda r: np.where(r < 1e-3, 1.2 * H, 0.0), [0.0], PAD)
    with pytest.raises(InputError, match="pad_diameter is 0"):
        pad_capacitance(H, np.zeros_like, [0.0], 0.0)


def test_pads_under_two_balls_read_as_the_field_says() -> None:
    """ΔC/C₀ of Laplace's equation in bricks of 0.12 h below elements of 0.15 h: docs, two balls."""
    pads = np.array([[0, 0], [-3, 0], [3, 0], [0, 4], [-3, 5], [8, 0]]) * 1e-3
    judge = np.array([0.06173, 0.18413, 0.11194, -0.01664, -0.01297, -0.00832])
    found = press(SOFT, TWO_BALLS, extent=20e-3, cell=0.4e-3)
    assert found.capacitance(pads, PAD) == pytest.approx(judge, abs=3e-4)
    series = found.capacitance(pads, PAD, order=3)
    assert series == pytest.approx(judge, abs=4e-3)
    assert judge[1] - series[1] > 2e-3  # where the gap is narrow the series falls short


def test_two_balls_that_feel_each_other_press_as_bricks_say() -> None:
    """Base stress (Pa) and indentation (m) of Q2/Q1 bricks of 0.12 h, in three dimensions."""
    places = np.array([[0, 0], [-3, 0], [3, 0], [0, 2], [-3, 2], [6, 0]]) * 1e-3
    base = np.array([11397.7, 48936.3, 36164.2, 3624.5, 23174.4, 3181.6])
    sunk = np.array([-92.617, 550.958, 432.839, -105.622, 207.813, -48.895]) * 1e-6
    cells = press(SOFT, TWO_BALLS, extent=16e-3, cell=0.25e-3)
    assert cells.base_stress(places, 0.0) == pytest.approx(base, abs=0.01 * base.max())
    between = LinearNDInterpolator(cells.grid.plane, -cells.displacement[:, 2])
    assert between(places) == pytest.approx(sunk, abs=0.06 * sunk.max())
    alone = indent(SOFT, BALL, force=0.8)
    assert abs(alone.depth / cells.approach[0] - 1) > 5e-3  # the other one matters
