"""The field in the gap below any surface, against plates, perturbation theory and direct sums."""

import numpy as np
import pytest

from skinfield.errors import Floats, InputError
from skinfield.mechanics.radial import RadialKernel, electrostatic, jinc
from skinfield.observation.deformed_gap import SHALLOW, charge_below
from skinfield.observation.electrostatics import GapStrain, capacitance_change, charge_series

H, STEP = 2e-3, 0.2e-3


def dent(depth: float, count: int = 121, width: float = 2.0) -> GapStrain:
    """A round dent, in the middle of a mesh of h/10, with a bulge around it."""
    at = (np.arange(count) - count // 2) * STEP / H
    square = (at[:, None] ** 2 + at**2) / width**2
    return GapStrain(
        depth * (1 - 0.4 * square) * np.exp(-square), np.full(2, -(count // 2) * STEP), STEP
    )


def taken(strain: GapStrain) -> Floats:
    return charge_below(strain.values, strain.step / H)


@pytest.mark.parametrize("strain", [-0.3, 0.3, 0.8])
def test_a_wide_plateau_holds_the_charge_of_plates(strain: float) -> None:
    at = np.abs(np.arange(160) - 80) * STEP / H
    edge = 1 / (1 + np.exp(4 * (at - 5)))
    charge = charge_below(strain * edge[:, None] * edge, STEP / H)
    assert charge[80, 80] == pytest.approx(1 / (1 - strain) - 1, rel=1e-4)
    assert abs(charge[0, 0]) < 1e-5


def test_what_the_third_order_leaves_falls_with_the_fourth_power() -> None:
    left = []
    for depth in (0.04, 0.08):
        strain = dent(depth)
        spectrum = np.fft.rfft2(charge_series(strain, H, 3))
        k = (
            2
            * np.pi
            * np.hypot(np.fft.rfftfreq(121, STEP / H), np.fft.fftfreq(121, STEP / H)[:, None])
        )
        third = np.fft.irfft2(spectrum * electrostatic(k), (121, 121))
        left.append(np.abs(taken(strain) - third).max())
    assert left[1] / left[0] == pytest.approx(16.0, rel=0.25)
    assert left[0] * (SHALLOW / 0.04) ** 4 < 1e-5


def test_a_ripple_is_one_long_wall_whichever_way_it_runs() -> None:
    wave = 0.6 * np.cos(2 * np.pi * np.arange(60) / 60)
    rows = charge_below(np.tile(wave, (20, 1)), 0.1)
    columns = charge_below(np.tile(wave[:, None], (1, 20)), 0.1)
    assert rows == pytest.approx(columns.T, abs=1e-6)
    assert rows.max() - rows.min() > 1.0


def test_the_least_capacitance_of_a_mean_gap_is_that_of_plates() -> None:
    """A plane that dents one way and bulges the other holds more than a flat one (Jensen)."""
    assert taken(dent(0.5)).mean() > dent(0.5).values.mean()
    ripple = charge_below(0.5 * np.cos(2 * np.pi * np.arange(200) / 200)[None] * np.ones((4, 1)), 1)
    assert ripple.mean() == pytest.approx(1 / np.sqrt(1 - 0.25) - 1, rel=2e-3)  # long waves


def test_a_reading_is_the_sum_of_the_pads_kernel_over_the_surface() -> None:
    strain = dent(0.3, count=181)
    places = np.random.default_rng(3).uniform(-5e-3, 5e-3, (12, 2))
    kernel = RadialKernel(
        lambda alpha: alpha * electrostatic(alpha) * jinc(alpha, 1.0) / (2 * np.pi),
        order=0, cutoff=46.0, reach=10.0, width=1.0,
    )  # fmt: skip
    axis = (np.arange(181) - 90) * STEP
    for order in (1, 2, 3):
        found = capacitance_change(strain, H, places, 4e-3, order)
        series = charge_series(strain, H, order)
        for (x, y), reading in zip(places, found, strict=True):
            weight = kernel(np.hypot(axis - x, (axis - y)[:, None]) / H)
            assert reading == pytest.approx(np.sum(weight * series) * (STEP / H) ** 2, abs=1e-7)


def test_the_field_is_found_around_deep_places_and_the_series_elsewhere() -> None:
    strain = dent(0.5, count=181)
    places = np.array([[0.0, 0.0], [3e-3, 0.0], [0.0, 6e-3], [-1.2e-2, 0.0]])
    whole = taken(strain)
    charge = np.fft.irfft2(np.fft.rfft2(whole) * jinc(_k(181), 1.0), whole.shape)
    index = np.rint((places - strain.origin) / STEP).astype(int)
    found = capacitance_change(strain, H, places, 4e-3, order=None)
    assert found == pytest.approx(charge[index[:, 1], index[:, 0]], abs=2e-5)


def _k(count: int) -> Floats:
    step = STEP / H
    return np.asarray(
        2 * np.pi * np.hypot(np.fft.rfftfreq(count, step), np.fft.fftfreq(count, step)[:, None])
    )


def test_pads_beyond_the_mesh_and_ragged_surfaces_are_refused() -> None:
    with pytest.raises(InputError, match=r"pad at \(11\.0, 0\.0\) mm lies beyond the mesh"):
        capacitance_change(dent(0.1), H, np.array([[0.0, 0.0], [11e-3, 0.0]]), 4e-3)
    ragged = np.random.default_rng(0).choice([0.0, 0.9999], (40, 40))
    with pytest.raises(InputError, match=r"indentation of 1\.00 of the thickness is too steep"):
        charge_below(ragged, 0.05)
