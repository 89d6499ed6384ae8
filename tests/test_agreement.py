"""Lattice, exact solution and finite elements agree about the same presses."""

import pytest

from skinfield.elastic import Layer
from skinfield.lab.paper import TIPS
from skinfield.lab.sections.agreement import agree, agreement_table, half_space_error
from skinfield.simulate import Cylinder, Sphere

SOFT = Layer(2e-3, 100e3, 0.5)


@pytest.mark.parametrize("nu", [0.5, 0.4])
def test_a_ball_is_the_same_three_ways(nu: float) -> None:
    row = agree(Layer(2e-3, 100e3, nu), "ball", Sphere(radius=6e-3), 0.5, 0.4e-3, finest=0.03)
    assert row["exact_depth"] == pytest.approx(row["depth"], rel=3e-4)
    assert row["lattice_depth"] == pytest.approx(row["depth"], rel=5e-4)
    assert row["exact_base"] < 1.5e-3
    assert row["exact_surface"] < 1e-3
    assert 1e-5 < row["lattice_base"] < 8e-4
    assert 1e-5 < row["lattice_surface"] < 2e-3
    assert row["field"] == pytest.approx(row["reading"], rel=1e-3)
    assert row["series"] == pytest.approx(row["reading"], rel=0.03)
    table = agreement_table([row])
    assert (table.columns[2], table.cells[0][2]) == ("depth, elements (mm)", row["depth"])
    assert len(table.columns) == len(row)


def test_a_sharp_flat_end_is_the_same_but_for_its_edge() -> None:
    row = agree(SOFT, "punch", Cylinder(radius=3e-3), 0.5, 0.3e-3)
    assert row["exact_depth"] == pytest.approx(row["depth"], rel=3e-3)
    assert row["exact_base"] < 2e-3
    assert row["lattice_base"] < 4e-3
    assert row["lattice_depth"] == pytest.approx(row["depth"], rel=4e-3)


def test_half_space_error_is_that_of_narrow_and_wide_contacts() -> None:
    """Stress suffers under narrow contacts, displacement under wide ones; brackets of both."""
    ball, flat = (
        half_space_error(TIPS[index].pressed(SOFT, 0.5, 0.4e-3))  # 1.2 cm: half-sphere, cylinder
        for index in (1, 3)
    )
    assert 0.19 < ball["point_stress"] < 0.23
    assert 0.10 < ball["displacement"] < 0.13
    assert 0.04 < flat["point_stress"] < 0.08
    assert 0.30 < flat["displacement"] < 0.40
    thick = Layer(20e-3, 100e3, 0.5)  # nearly a half-space
    assert half_space_error(TIPS[2].pressed(thick, 0.2, 0.3e-3))["displacement"] < 0.08
