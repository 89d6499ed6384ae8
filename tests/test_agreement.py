"""Lattice, exact solution and finite elements agree about the same presses."""

import pytest

from skinfield.errors import InputError
from skinfield.experiments.agreement import BODIES, agree, agreement_table
from skinfield.mechanics import Layer
from skinfield.simulate import Cylinder, Sphere

SOFT = Layer(2e-3, 100e3, 0.5)


@pytest.mark.parametrize("nu", [0.5, 0.4])
def test_a_ball_is_the_same_three_ways(nu: float) -> None:
    row = agree(Layer(2e-3, 100e3, nu), "ball", Sphere(radius=6e-3), 0.5, 0.4e-3, finest=0.03)
    assert row.exact.depth == pytest.approx(row.depth, rel=3e-4)
    assert row.lattice.depth == pytest.approx(row.depth, rel=5e-4)
    assert row.exact.base_error < 1.5e-3
    assert row.exact.surface_error < 1e-3
    assert 1e-5 < row.lattice.base_error < 8e-4
    assert 1e-5 < row.lattice.surface_error < 2e-3
    assert row.field == pytest.approx(row.reading, rel=1e-3)
    assert row.series == pytest.approx(row.reading, rel=0.03)


def test_a_sharp_flat_end_is_the_same_but_for_its_edge() -> None:
    row = agree(SOFT, "punch", Cylinder(radius=3e-3), 0.5, 0.3e-3)
    assert row.exact.depth == pytest.approx(row.depth, rel=3e-3)
    assert row.exact.base_error < 2e-3
    assert row.lattice.base_error < 4e-3
    assert row.lattice.depth == pytest.approx(row.depth, rel=4e-3)


def test_rows_become_a_table() -> None:
    row = agree(SOFT, *BODIES[1], 0.2, 0.5e-3, finest=0.05)
    table = agreement_table([row])
    assert len(table.rows[0]) == len(table.columns)
    assert table.rows[0][2] == pytest.approx(0.427, abs=2e-3)
    with pytest.raises(InputError, match="expected the origin"):
        agree(SOFT, "ball", Sphere(radius=6e-3, position=(1e-3, 0.0)), 0.2)


def test_the_page_on_finite_elements_runs(capsys: pytest.CaptureFixture[str]) -> None:
    from test_readme import ROOT, follow

    assert follow(ROOT / "docs" / "finite-elements.md") == (1, 0)
    assert "True" in capsys.readouterr().out
