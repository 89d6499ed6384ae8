"""Readings of atoms: derivatives against differences, and what they cannot depend on."""

from functools import lru_cache

import numpy as np
import pytest
from contact_truth import LAYER, PATCH
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from skinfield.elastic import BaseStress, BondedLayer, Capacitance, Physics, Quantity
from skinfield.solve.atoms.fit_kernel import PARAMETERS, Tables, predict, tables_of
from skinfield.solve.atoms.table import BALL, FAMILIES, FLAT, RING, atom_table

Floats = NDArray[np.float64]
THICKNESS = LAYER.thickness
TAXELS = np.ascontiguousarray(PATCH.plane / THICKNESS)
QUANTITIES: dict[str, Quantity] = {"stress": BaseStress(), "capacitance": Capacitance()}
NAMES = pytest.mark.parametrize("name", list(QUANTITIES))


@lru_cache(maxsize=2)
def tables(name: str) -> Tables:
    physics = Physics(LAYER, BondedLayer(), QUANTITIES[name], PATCH.pad_diameter)
    return tables_of(atom_table(physics))


def read(name: str, atoms: Floats, family: list[int], taxels: Floats = TAXELS) -> Floats:
    return read_with_slopes(name, atoms, family, taxels)[0]


def read_with_slopes(
    name: str, atoms: Floats, family: list[int], taxels: Floats = TAXELS
) -> tuple[Floats, Floats]:
    atoms = np.atleast_2d(np.asarray(atoms, dtype=float))
    out = np.empty(len(taxels))
    slopes = np.empty((len(taxels), len(atoms), PARAMETERS))
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
    "family": st.sampled_from(FAMILIES),
    "name": st.sampled_from(list(QUANTITIES)),
}


@given(**ANY)
def test_derivatives_are_those_of_the_readings(
    x: float, y: float, lighter: float, log_radius: float, half: float, angle: float, family: int,
    name: str,
) -> None:  # fmt: skip
    force = shallow(name, log_radius) - lighter
    atom = np.array([x, y, force, log_radius, half * np.cos(angle), half * np.sin(angle)])
    _, slopes = read_with_slopes(name, atom, [family])
    step = 1e-5
    for index in range(PARAMETERS if half else 4):
        up, down = atom.copy(), atom.copy()
        up[index] += step
        down[index] -= step
        numeric = (read(name, up, [family]) - read(name, down, [family])) / (2 * step)
        size = np.abs(slopes[:, 0, index]).max()
        off = np.abs(slopes[:, 0, index] - numeric).max()
        assert off <= 2e-4 * max(size, np.abs(numeric).max()) + 1e-9


@NAMES
def test_atoms_add_up_and_each_has_its_own_derivatives(name: str) -> None:
    first = np.array([0.3, -1.0, -1.0, 0.2, 0.0, 0.0])
    second = np.array([3.1, 2.0, -2.0, 0.0, 1.5, -0.7])
    both, slopes = read_with_slopes(name, np.stack([first, second]), [BALL, FLAT])
    assert both == pytest.approx(read(name, first, [BALL]) + read(name, second, [FLAT]), rel=1e-12)
    assert slopes[:, 0] == pytest.approx(read_with_slopes(name, first, [BALL])[1][:, 0])
    assert slopes[:, 1] == pytest.approx(read_with_slopes(name, second, [FLAT])[1][:, 0])


@given(turn=st.floats(0.0, 6.2), half=st.floats(0.1, 3.0), family=st.sampled_from([BALL, FLAT]))
def test_turning_the_skin_with_what_presses_changes_nothing(
    turn: float, half: float, family: int
) -> None:
    cos, sin = np.cos(turn), np.sin(turn)
    turned = np.array([[cos, sin], [-sin, cos]])
    atom = np.array([1.0, 0.5, -1.0, 0.1, half, 0.4 * half])
    moved = atom.copy()
    moved[:2], moved[4:] = atom[:2] @ turned, atom[4:] @ turned
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
