"""A ladder whose taxels do not all answer, against a reconstructor of the same readings."""

from typing import Any

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import Floats, InputError
from skinfield.reconstruct.multigrid_levels import Restriction
from skinfield.skin import generators

NOISE = 0.002
PATCH = generators.hexagon72()
LAYER = sf.Layer()
FINEST = sf.Grid.square(PATCH, 24)
SOLVERS: dict[str, Any] = {
    "gaussian": sf.GaussianField(),
    "white": sf.Tikhonov(),
    "exact": sf.PseudoInverse(),
}
FIELDS = ("pressure", "displacement", "traction", "pressure_std", "residual")


def readings_lacking(missing: int) -> Floats:
    """A ball's readings with noise, some taxels missing, those below the ball among them."""
    ball = sf.simulate.Sphere(radius=8e-3, force=3.0)
    press = sf.simulate.press(LAYER, [ball], cell=1e-3)
    readings = press.readings(PATCH.plane - PATCH.plane[30], PATCH.pad_diameter, "capacitance")
    rng = np.random.default_rng(missing)
    readings = np.asarray(readings + rng.normal(0.0, NOISE, len(PATCH)))
    readings[rng.choice(len(PATCH), missing, replace=False)] = np.nan
    return readings


@pytest.fixture(scope="module", params=SOLVERS)
def pair(request: Any) -> tuple[sf.Ladder, sf.Reconstructor]:
    solver = SOLVERS[request.param]
    ladder = sf.Ladder(PATCH, LAYER, (8, 24), solver=solver, noise_std=NOISE)
    return ladder, sf.Reconstructor(PATCH, LAYER, FINEST, solver=solver, noise_std=NOISE)


def near(found: Floats, expected: Floats) -> None:
    size = np.nanmax(np.abs(expected))  # 1e-13: a residual of readings that are met exactly
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-8 * size + 1e-13)


@pytest.mark.parametrize("missing", [1, 12, 60])
def test_all_is_that_of_a_reconstructor(
    pair: tuple[sf.Ladder, sf.Reconstructor], missing: int
) -> None:
    ladder, rec = pair
    ladder.rung = 24
    readings = readings_lacking(missing)
    ours, alone = ladder(readings), rec(readings)
    for name in FIELDS:
        near(getattr(ours, name), getattr(alone, name))
    assert len(ours.contacts) == len(alone.contacts)
    for one, other in zip(ours.contacts, alone.contacts, strict=True):
        assert one.normal_force == pytest.approx(other.normal_force, rel=1e-7)
        near(one.covariance, other.covariance)
    assert ours.notes == (f"{missing} taxels left out",)


def test_a_coarse_rung_and_a_window_are_parts_of_it(
    pair: tuple[sf.Ladder, sf.Reconstructor],
) -> None:
    ladder, rec = pair
    readings = readings_lacking(12)
    whole = rec(readings)
    ladder.rung = 8
    coarse = ladder(readings)
    near(coarse.pressure, Restriction.between(FINEST, ladder.grid)(whole.pressure))
    near(coarse.residual, whole.residual)
    ladder.focus(PATCH.plane[30] - 5e-3, PATCH.plane[30] + 5e-3)
    part = ladder(readings)
    inside = np.abs(FINEST.plane - PATCH.plane[30]).max(axis=1) <= 5e-3
    assert 4 < len(part.grid) == inside.sum()
    for name in FIELDS[:-1]:
        near(getattr(part, name), getattr(whole, name)[inside])


def test_what_stands_in_place_of_a_missing_reading_does_not_count() -> None:
    ladder = sf.Ladder(PATCH, LAYER, (24,), noise_std=NOISE)
    lacking = readings_lacking(5)
    valid = ~np.isnan(lacking)
    wild = np.where(valid, lacking, 7.0)
    near(ladder(wild, valid=valid).pressure, ladder(lacking).pressure)
    empty = np.full(len(PATCH), np.nan)
    with pytest.raises(InputError, match="no valid taxel"):
        ladder(empty)


def test_a_searchs_deviations_are_those_without_the_missing() -> None:
    solver = sf.NonNegative(tolerance=1e-6, precision=np.float64)
    ladder = sf.Ladder(PATCH, LAYER, (24,), solver=solver, noise_std=NOISE)
    rec = sf.Reconstructor(PATCH, LAYER, FINEST, solver=solver, noise_std=NOISE)
    readings = readings_lacking(30)
    ours, alone = ladder(readings), rec(readings)
    near(ours.pressure_std, alone.pressure_std)
    away = np.linalg.norm(ours.pressure - alone.pressure) / np.linalg.norm(alone.pressure)
    assert away < 1e-2  # both to the tolerance
