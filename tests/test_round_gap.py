"""Laplace's equation in the gap: round and deformed surfaces, against independent solutions."""

import numpy as np
import pytest

from skinfield.elastic import Layer
from skinfield.elastic.axisymmetric import (
    Ball,
    Indentation,
    Paraboloid,
    indent_by_force,
    indent_to_radius,
    punch,
)
from skinfield.elastic.electrostatics import (
    SHALLOW,
    GapStrain,
    _series,
    _Waves,
    capacitance_change,
    charge_below,
)
from skinfield.elastic.hankel import RadialKernel, bessel, electrostatic, gauss_legendre, jinc
from skinfield.elastic.round_gap import RoundGap
from skinfield.errors import Floats, InputError
from skinfield.lab.fem import pad_capacitance

H = 2e-3
LAYER = Layer(H, 100e3, 0.5)
PLACES = np.array([0.0, 0.5, 1.0, 1.7, 2.4, 3.2, 4.5])  # of pads, in thicknesses


def strain_of(body: Indentation, gap: RoundGap) -> Floats:
    return body.indentation(gap.nodes * H) / H


@pytest.mark.parametrize("strain", [-0.5, 0.1, 0.5, 0.9, 0.97])
def test_a_uniform_gap_holds_the_charge_of_plates(strain: float) -> None:
    gap = RoundGap.of(2.0, PLACES)
    uniform = np.full((1, len(gap.nodes)), strain)
    rest = slice(0, 6)  # further out the end of the mesh is felt
    expected = 1 / (1 - strain) - 1
    assert gap.readings(uniform)[0, rest] == pytest.approx(expected, rel=3e-3)


def test_a_slight_indentation_is_smoothed_by_the_field_lines() -> None:
    gap = RoundGap.of(2.0, PLACES)
    wide = 1.2
    dent = 1e-4 * np.exp(-((gap.nodes / wide) ** 2))
    wave, share = gauss_legendre(0.0, 12.0, 20)
    hankel = 1e-4 * wide**2 / 2 * np.exp(-((wave * wide) ** 2) / 4)
    expected = bessel(0, np.outer(PLACES, wave)) @ (
        share * wave * hankel * electrostatic(wave) * jinc(wave, 1.0)
    )
    found = gap.readings(dent[None])[0]
    assert found == pytest.approx(expected, abs=1e-3 * expected.max())


def test_bodies_read_what_three_dimensional_meshes_found() -> None:
    gap = RoundGap.of(2.0, [0.0])
    balls = [(6e-3, 0.5, 0.1258), (6e-3, 1.0, 0.2388), (6e-3, 3.0, 0.6848), (3e-3, 1.0, 0.4039)]
    for radius, force, expected in balls:
        body = indent_by_force(LAYER, Ball(radius=radius), force)
        assert gap.readings(strain_of(body, gap)[None])[0, 0] == pytest.approx(expected, rel=2e-3)
    flat = punch(LAYER, 6e-3, force=3.0)
    gap = RoundGap.of(2.0, [0.0], edges=[3.0])
    assert gap.readings(strain_of(flat, gap)[None])[0, 0] == pytest.approx(0.0547, rel=0.01)


def on_mesh(profile: Floats, radii: Floats, step: float) -> GapStrain:
    """A round surface on a square mesh."""
    half = int(8.5 / step)
    at = np.arange(-half, half + 1) * step
    values = np.interp(np.hypot(at, at[:, None]), radii, profile, right=0.0)
    return GapStrain(values, np.full(2, at[0] * H), step * H)


@pytest.mark.parametrize(("radius", "top"), [(0.8, 0.85), (1.6, 0.5)])
@pytest.mark.parametrize(("pad", "close"), [(0.0, 7e-3), (2.0, 1e-3)])  # h/10 is wide at a point
def test_balls_agree_with_the_field_on_a_square_mesh(
    radius: float, top: float, pad: float, close: float
) -> None:
    unit = indent_to_radius(LAYER, Paraboloid(radius=1.0), radius * H)
    radii = np.linspace(0.0, 13.0, 4000)
    scale = top / unit.indentation([0.0])[0]
    mesh = on_mesh(scale * unit.indentation(radii * H), radii, 0.1)
    places = np.column_stack([PLACES, np.zeros_like(PLACES)]) * H
    expected = capacitance_change(mesh, H, places, pad * H, order=None)
    gap = RoundGap.of(pad, PLACES)
    found = gap.readings(scale * unit.indentation(gap.nodes * H)[None])[0]
    assert found == pytest.approx(expected, abs=close * expected.max())


def test_a_sharp_rim_is_the_limit_of_rounded_ones() -> None:
    body = punch(LAYER, H, depth=0.6 * H)
    gap = RoundGap.of(2.0, PLACES, edges=[1.0])
    sharp = gap.readings(strain_of(body, gap)[None])[0]
    radii = np.concatenate([np.linspace(0.0, 0.9, 50), np.linspace(0.9, 1.1, 2000)])
    radii = np.unique(np.concatenate([radii, np.linspace(1.1, 13.0, 1500)])) * H
    depths = body.indentation(radii)
    node, weight = np.polynomial.legendre.leggauss(40)
    left = []
    for blunt in (0.1, 0.05):

        def rounded(r: Floats, blunt: float = blunt) -> Floats:
            around = np.abs(r[..., None] + blunt * node * H)  # a mean over radii around
            return np.asarray(np.interp(around, radii, depths) @ weight / 2)

        near = pad_capacitance(H, rounded, PLACES * H, 2 * H, edges=(H,), finest=0.02)
        again = gap.readings(rounded(gap.nodes * H)[None] / H)[0]
        assert again == pytest.approx(near, abs=4e-3 * near.max())
        left.append(float(np.abs(near - sharp).max() / sharp.max()))
    assert left[0] > left[1]
    assert left[1] < 0.03


def test_more_charge_is_below_many_indentations_than_below_one_by_one() -> None:
    gap = RoundGap.of(1.5, PLACES)
    depths = np.array([0.1, 0.4, 0.7])
    each = depths[:, None] * np.exp(-(gap.nodes**2))
    together = gap.readings(each)
    assert together == pytest.approx(np.vstack([gap.readings(v[None]) for v in each]))
    assert (np.diff(together[:, 0] / depths) > 0).all()  # more than in proportion
    assert gap.readings(np.zeros((2, len(gap.nodes)))).tolist() == np.zeros((2, 7)).tolist()
    assert gap.readings(np.zeros((0, len(gap.nodes)))).shape == (0, 7)


def test_the_charge_below_the_whole_surface_is_what_all_pads_read() -> None:
    """Discs that a pad sweeps: integral of readings over the plane = integral of the charge."""
    away = np.linspace(0.0, 8.0, 321)
    gap, point = RoundGap.of(2.0, away), RoundGap.of(0.0, away)
    dent = [0.7 * np.exp(-(each.nodes**2)) for each in (gap, point)]
    sums = [
        np.trapezoid(each.readings(v[None])[0] * away, away)
        for each, v in zip((gap, point), dent, strict=True)
    ]
    assert sums[0] == pytest.approx(sums[1], rel=2e-3)


def test_surfaces_that_touch_the_pads_and_wrong_shapes_are_refused() -> None:
    gap = RoundGap.of(2.0, [0.0])
    with pytest.raises(InputError, match=r"strain reaches 1\.00, expected below 1: the skin"):
        gap.readings(np.exp(-(gap.nodes**2))[None])
    with pytest.raises(InputError, match=r"strain has shape \(3,\), expected \(any, "):
        gap.readings(np.zeros(3))


STEP = 0.2e-3


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
        spectrum = np.fft.rfft2(_series(strain.values, 3, _Waves.of(strain, H)))
        third = np.fft.irfft2(spectrum * electrostatic(_k(121)), (121, 121))
        left.append(np.abs(taken(strain) - third).max())
    assert left[1] / left[0] == pytest.approx(16.0, rel=0.25)
    assert left[0] * (SHALLOW / 0.04) ** 4 < 1e-5


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
        series = _series(strain.values, order, _Waves.of(strain, H))
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
