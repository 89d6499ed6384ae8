"""Readings of single contacts against simulated presses, equilibrium and kernels."""

from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from contact_truth import LAYER, PATCH, solved
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import skinfield as sf
from skinfield.elastic import (
    BaseStress,
    BondedLayer,
    Capacitance,
    HalfSpace,
    Layer,
    Mechanics,
    Physics,
    Quantity,
)
from skinfield.elastic.axisymmetric import Ball, indent_by_force
from skinfield.solve.atoms.atom_readings import PARAMETERS, predict
from skinfield.solve.atoms.fit_kernel import hold
from skinfield.solve.atoms.table import (
    BALL,
    FAMILIES,
    FLAT,
    RING,
    Tables,
    atom_tables,
    curvature_force,
    load_quadrature,
    unit_indentation,
    unit_pressure,
)

Floats = NDArray[np.float64]
H = LAYER.thickness
LINE = np.column_stack([np.linspace(0.0, 8e-3, 33), np.zeros(33)])  # m from the axis
BODIES = {
    "a ball": (sf.simulate.Sphere(radius=6e-3, force=1.0), BALL),
    "a small ball, deep": (sf.simulate.Sphere(radius=4e-3, force=1.0), BALL),
    "a big ball": (sf.simulate.Sphere(radius=14e-3, force=2.0), BALL),
    "a flat end": (sf.simulate.Cylinder(radius=3e-3, force=1.0), FLAT),
}


def atom_of(body: Any, family: int, force: float) -> Floats:
    """Parameters of the atom that a body is, by exact radii."""
    radius = body.radius if family == FLAT else touching(body.radius, force)
    return np.array([0.0, 0.0, np.log(force), np.log(radius / H), 0.0, 0.0])


def touching(curvature: float, force: float) -> float:
    """Contact radius in m of a ball: a true one, not the paraboloid that atoms are made of."""
    return indent_by_force(LAYER, Ball(radius=curvature), force).contact_radius


@pytest.mark.parametrize("quantity", ["stress", "capacitance"])
@pytest.mark.parametrize("name", list(BODIES))
def test_the_simulator_reads_the_same(name: str, quantity: str) -> None:
    """Below 1 %, but for the gap below a ball: a paraboloid that touches as far is less deep."""
    body, family = BODIES[name]
    press, anywhere = solved(body, quantity)
    expected = anywhere(LINE)
    found = read(quantity, atom_of(body, family, press.force), [family], LINE / H)
    off = np.abs(found - expected).max() / np.abs(expected).max()
    assert off < (0.025 if quantity == "capacitance" else 0.01)
    assert off > 1e-6  # they share no code below the elasticity


@pytest.mark.parametrize("quantity", ["stress", "capacitance"])
@pytest.mark.parametrize("name", list(BODIES))
def test_force_and_radius_make_up_for_what_is_no_paraboloid(name: str, quantity: str) -> None:
    """What a fit without noise can reach: 0.7 % of a ball's force, 0.05 mm of the radius."""
    from scipy.optimize import least_squares

    body, family = BODIES[name]
    press, anywhere = solved(body, quantity)
    expected = anywhere(LINE)
    start = atom_of(body, family, press.force)

    def residuals(moved: Floats) -> Floats:
        atom = start.copy()
        atom[2:4] += moved
        off = read(quantity, atom, [family], LINE / H) - expected
        return np.asarray(off / np.abs(expected).max())

    found = least_squares(residuals, [0.1, -0.1])
    assert np.abs(found.fun).max() < 1e-3
    hidden = family == FLAT and quantity == "capacitance"  # its middle hardly changes the gap
    assert np.exp(found.x[0]) == pytest.approx(1.0, abs=0.06 if hidden else 0.007)
    assert np.exp(start[3]) * H * np.expm1(found.x[1]) == pytest.approx(0.0, abs=0.05e-3)


def test_the_simulator_touches_as_far_as_the_ball_is_said_to() -> None:
    """Within a part of the 0.25 mm of its cells; a paraboloid touches farther."""
    press, _ = solved(BODIES["a small ball, deep"][0], "stress")
    radius = np.sqrt(press.contact_area / np.pi)
    assert radius == pytest.approx(touching(4e-3, press.force), abs=0.03e-3)
    assert curvature_force(LAYER, radius) / 4e-3 < 0.95 * press.force


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("radius", [0.3, 1.0, 3.0])
def test_the_stress_below_carries_the_force(family: int, radius: float) -> None:
    """Equilibrium: summed over the whole base, pads in place of points or not."""
    r = np.linspace(0.0, radius + 7.0, 4001)
    atom = np.array([0.0, 0.0, 0.0, np.log(radius), 0.0, 0.0])
    reading = read("stress", atom, [family], np.column_stack([r, np.zeros_like(r)]))
    total = np.trapezoid(2 * np.pi * r * reading, r) * H**2
    assert total == pytest.approx(1.0, abs=6e-3)  # the rest lies beyond what is tabulated


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("radius", [0.5, 2.0])
def test_a_light_touch_is_read_to_first_order(family: int, radius: float) -> None:
    """The field in a gap that hardly changes is that of its linear kernel, on a grid."""
    table = tables("first order")
    assert not table.strain.size
    atom = np.array([[0.0, 0.0, np.log(1e-4), np.log(radius), 0.0, 0.0]])
    taxels = LINE / H
    expected, slopes = np.empty(len(taxels)), np.empty((1, PARAMETERS, len(taxels)))
    predict(whole(atom), np.array([family]), taxels, table, expected, slopes)
    found = read("capacitance", atom[0], [family], taxels)
    share = 0.04 if family == RING else 0.02
    assert np.abs(found - expected).max() < share * np.abs(expected).max()


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("mechanics", [BondedLayer(), HalfSpace()], ids=["layer", "half-space"])
def test_rings_of_force_stand_for_the_pressure(family: int, mechanics: Mechanics) -> None:
    radius = 2.5e-3
    rings, forces = load_quadrature(LAYER, mechanics, family, radius)
    assert forces.sum() == pytest.approx(1.0)
    assert (forces > 0).all()
    edge = radius + H
    r = edge * np.sin(np.linspace(0.0, np.pi / 2, 40_001))  # dense where a flat end is singular
    if family != RING:
        r = radius * np.sin(np.linspace(0.0, np.pi / 2, 40_001))[:-1]
    pressure = unit_pressure(LAYER, mechanics, family, radius, r)
    for power in (0, 2):
        moment = np.trapezoid(2 * np.pi * r ** (1 + power) * pressure, r)
        assert forces @ rings**power == pytest.approx(moment, rel=5e-3)


def test_on_a_thick_layer_contacts_are_hertz_and_boussinesq() -> None:
    thick, radius = Layer(thickness=0.2, young_modulus=150e3, poisson_ratio=0.5), 2e-3
    reduced = 150e3 / (1 - 0.5**2)
    r = np.linspace(0.0, 0.9 * radius, 10)
    for family, pressure in (
        (BALL, 1.5 / (np.pi * radius**2) * np.sqrt(1 - (r / radius) ** 2)),
        (FLAT, 0.5 / (np.pi * radius**2) / np.sqrt(1 - (r / radius) ** 2)),
    ):
        assert unit_pressure(thick, BondedLayer(), family, radius, r) == pytest.approx(
            pressure, rel=2e-3
        )
    assert curvature_force(thick, radius) == pytest.approx(4 / 3 * reduced * radius**3, rel=0.03)
    depth = unit_indentation(thick, BondedLayer(), FLAT, radius, np.zeros(1))
    assert depth == pytest.approx(1 / (2 * reduced * radius), rel=0.03)


THICKNESS = LAYER.thickness
TAXELS = np.ascontiguousarray(PATCH.plane / THICKNESS)
QUANTITIES: dict[str, Quantity] = {"stress": BaseStress(), "capacitance": Capacitance()}
NAMES = pytest.mark.parametrize("name", list(QUANTITIES))


@lru_cache(maxsize=3)
def tables(name: str) -> Tables:
    quantity = QUANTITIES.get(name, Capacitance(order=1))
    return atom_tables(Physics(LAYER, BondedLayer(), quantity, PATCH.pad_diameter))


def whole(atoms: Floats) -> Floats:
    """Atoms (N, 8): 0 for the parameters that are not given."""
    rows = np.atleast_2d(np.asarray(atoms, dtype=float))
    return np.pad(rows, ((0, 0), (0, PARAMETERS - rows.shape[1])))


def read(name: str, atoms: Floats, family: list[int], taxels: Floats = TAXELS) -> Floats:
    return read_with_slopes(name, atoms, family, taxels)[0]


def read_with_slopes(
    name: str, atoms: Floats, family: list[int], taxels: Floats = TAXELS
) -> tuple[Floats, Floats]:
    atoms = whole(atoms)
    out = np.empty(len(taxels))
    slopes = np.empty((len(atoms), PARAMETERS, len(taxels)))
    predict(atoms, np.array(family), np.ascontiguousarray(taxels), tables(name), out, slopes)
    return out, slopes


def shallow(name: str, log_radius: float) -> float:
    """ln force that a gap of this contact radius bears far from closing."""
    return 2.0 * log_radius - 1.5 if name == "capacitance" else 0.0


LOG_RADIUS = st.floats(float(np.log(0.25)), float(np.log(4.0)))
PLACE = st.floats(-6.0, 6.0)
ANY = {
    "x": PLACE,
    "y": PLACE,
    "lighter": st.floats(0.0, 3.0),
    "log_radius": LOG_RADIUS,
    "half": st.one_of(st.just(0.0), st.floats(0.2, 4.0)),
    "angle": st.floats(0.0, 3.1),
    "push": st.one_of(st.just((0.0, 0.0)), st.tuples(st.floats(0.1, 0.5), st.floats(-0.5, -0.1))),
    "family": st.sampled_from(FAMILIES),
    "name": st.sampled_from(list(QUANTITIES)),
}


@given(**ANY)
def test_derivatives_are_those_of_the_readings(
    x: float, y: float, lighter: float, log_radius: float, half: float, angle: float,
    push: tuple[float, float], family: int, name: str,
) -> None:  # fmt: skip
    force = shallow(name, log_radius) - lighter
    atom = np.array([x, y, force, log_radius, half * np.cos(angle), half * np.sin(angle), *push])
    _, slopes = read_with_slopes(name, atom, [family])
    step = 1e-5
    free = [0, 1, 2, 3, *((4, 5) if half else ()), *((6, 7) if any(push) else ())]
    for index in free:
        up, down = atom.copy(), atom.copy()
        up[index] += step
        down[index] -= step
        numeric = (read(name, up, [family]) - read(name, down, [family])) / (2 * step)
        size = np.abs(slopes[0, index]).max()
        off = np.abs(slopes[0, index] - numeric).max()
        assert off <= 2e-4 * max(size, np.abs(numeric).max()) + 1e-9


@NAMES
def test_atoms_add_up_and_each_has_its_own_derivatives(name: str) -> None:
    first = np.array([0.3, -1.0, -1.0, 0.2, 0.0, 0.0])
    second = np.array([3.1, 2.0, -2.0, 0.0, 1.5, -0.7])
    both, slopes = read_with_slopes(name, np.stack([first, second]), [BALL, FLAT])
    assert both == pytest.approx(read(name, first, [BALL]) + read(name, second, [FLAT]), rel=1e-12)
    assert slopes[0] == pytest.approx(read_with_slopes(name, first, [BALL])[1][0])
    assert slopes[1] == pytest.approx(read_with_slopes(name, second, [FLAT])[1][0])


@given(turn=st.floats(0.0, 6.2), half=st.floats(0.1, 3.0), family=st.sampled_from([BALL, FLAT]))
def test_turning_the_skin_with_what_presses_changes_nothing(
    turn: float, half: float, family: int
) -> None:
    cos, sin = np.cos(turn), np.sin(turn)
    turned = np.array([[cos, sin], [-sin, cos]])
    atom = np.array([1.0, 0.5, -1.0, 0.1, half, 0.4 * half, 0.3, -0.2])
    moved = atom.copy()
    for pair in (slice(2), slice(4, 6), slice(6, 8)):
        moved[pair] = atom[pair] @ turned
    for name in QUANTITIES:
        expected = read(name, atom, [family])
        found = read(name, moved, [family], TAXELS @ turned)
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())


@NAMES
@pytest.mark.parametrize("family", [BALL, FLAT])
def test_a_line_of_no_length_is_round(name: str, family: int) -> None:
    atom = np.array([1.0, 0.5, -1.5, 0.1, 0.0, 0.0])
    nearly = atom + np.array([0, 0, 0, 0, 1e-4, 0])
    assert read(name, nearly, [family]) == pytest.approx(
        read(name, atom, [family]), rel=1e-3, abs=1e-3 * read(name, atom, [family]).max()
    )
    back = atom + np.array([0, 0, 0, 0, 2.0, 1.0])
    forth = atom - np.array([0, 0, 0, 0, 2.0, 1.0])
    assert read(name, back, [family]) == pytest.approx(read(name, forth, [family]), rel=1e-12)


def test_stress_is_proportional_to_force_and_capacitance_grows_faster() -> None:
    atom = np.array([TAXELS[30, 0], TAXELS[30, 1], -3.0, 0.2, 0.0, 0.0])
    ten = atom + np.array([0, 0, np.log(10.0), 0, 0, 0])
    for family in FAMILIES:
        assert read("stress", ten, [family]) == pytest.approx(10.0 * read("stress", atom, [family]))
    change = [read("capacitance", each, [BALL])[30] for each in (atom, ten)]
    assert 1.1 < change[1] / change[0] / 10.0 < 1.5


@NAMES
def test_far_taxels_read_nothing_and_nothing_is_ever_nan(name: str) -> None:
    far = np.array([[60.0, 0.0], [0.0, -1e6]])
    atom = np.array([0.0, 0.0, 0.0, 0.3, 0.0, 0.0])
    assert not read(name, atom, [BALL], far).any()
    for log_force in (-20.0, 12.0):
        for log_radius in (np.log(0.18), np.log(7.0)):
            for half in (0.0, 20.0):
                wild = np.array([0.0, 0.0, log_force, log_radius, half, 0.0])
                for family in (BALL, FLAT, RING):
                    out, slopes = read_with_slopes(name, wild, [family])
                    assert np.isfinite(out).all()
                    assert np.isfinite(slopes).all()


def test_a_vanishing_length_is_none() -> None:
    """Reading by reading, a drawn-out contact may shrink until the square of its length is 0."""
    atom = np.array([0.3, -0.2, 0.0, 0.2, 1e-170, 0.0])
    readings, slopes = read_with_slopes("capacitance", atom, [BALL])
    assert np.isfinite(slopes).all()
    round_one, within = whole(atom), np.array([[-9.0, -9.0], [9.0, 9.0]])
    model = SimpleNamespace(tables=SimpleNamespace(strain=np.zeros((0, 1))), places=within)
    hold.py_func(model, round_one, np.array([BALL]), 1)  # type: ignore[attr-defined]
    assert not round_one[0, 4:].any()
    np.testing.assert_allclose(read("capacitance", round_one, [BALL]), readings, rtol=1e-3)
