"""The field in the deformed gap: plates, ripples, pads off the axis, and what a press reads."""

import numpy as np
import pytest
from scipy.special import j0, j1

import skinfield as sf
from skinfield.errors import InputError
from skinfield.fem import (
    FlatProfile,
    SphereProfile,
    indent,
    pad_capacitance,
    pad_capacitance_3d,
    press_3d,
)
from skinfield.simulate import Cylinder, Sphere, press

SOFT = sf.Layer(2e-3, 100e3, 0.5)
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
    ball = indent(SOFT, SphereProfile(radius=radius), force=force)
    judge = pad_capacitance(H, ball.indentation, [0.0], PAD, edges=[ball.contact_radius])[0]
    assert judge == pytest.approx(change, rel=2e-3)
    found = press(SOFT, [Sphere(radius=radius, force=force)], extent=16e-3, cell=0.4e-3)
    assert found.capacitance([[0.0, 0.0]], PAD)[0] == pytest.approx(judge, rel=1e-3)
    series = found.capacitance([[0.0, 0.0]], PAD, order=3)[0]
    assert 1 - series / judge == pytest.approx(short, abs=0.004)


def test_pads_off_the_axis_read_as_the_field_says() -> None:
    ball = indent(SOFT, SphereProfile(radius=6e-3), force=0.5)
    away = np.array([2e-3, 3e-3, 4e-3, 5e-3, 8e-3])
    judge = pad_capacitance(H, ball.indentation, away, PAD, edges=[ball.contact_radius])
    found = press(SOFT, [Sphere(radius=6e-3, force=0.5)], extent=16e-3, cell=0.4e-3)
    places = np.column_stack([away, np.zeros(5)])
    assert found.capacitance(places, PAD) == pytest.approx(judge, abs=3e-5)
    assert found.capacitance(places, PAD, order=3) == pytest.approx(judge, abs=6e-4)
    assert judge[3] < 0  # beside the ball the elastomer comes up


@pytest.mark.parametrize(
    ("force", "near"), [(0.5, 0.015), (1.0, 0.025), (1.4, 0.025)]
)  # 0.23, 0.46 and 0.65 of the thickness
def test_a_sharp_edge_costs_some_of_the_fields_accuracy(force: float, near: float) -> None:
    end = indent(SOFT, FlatProfile(radius=1.5e-3), force=force, finest=0.01)
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


def test_the_field_in_bricks_is_that_of_the_round_elements() -> None:
    ball = indent(SOFT, SphereProfile(radius=6e-3), force=1.0)
    pads = np.array([[0.0, 0.0], [2e-3, 2e-3], [5e-3, 0.0]])
    away = np.linalg.norm(pads, axis=1)
    judge = pad_capacitance(H, ball.indentation, away, PAD, edges=[ball.contact_radius])
    found = pad_capacitance_3d(
        H, lambda p: ball.indentation(np.linalg.norm(p, axis=1)), pads, PAD,
        around=[[-5e-3, -5e-3], [5e-3, 5e-3]], cell=0.25,
    )  # fmt: skip
    assert found == pytest.approx(judge, abs=1e-4)


def test_pads_between_two_balls_read_as_the_field_says() -> None:
    """Bricks and Laplace's equation in them, against Green's functions and Fourier's series."""
    balls = [
        Sphere(radius=6e-3, force=0.4, position=(-3e-3, 0.0)),
        Sphere(radius=6e-3, force=0.25, position=(3e-3, 0.0)),
    ]
    pads = np.array([[0.0, 0.0], [-3e-3, 0.0], [0.0, 5e-3], [3e-3, 2e-3]])
    layer = press_3d(SOFT, balls, cell=0.2, mirror=True)
    judge = pad_capacitance_3d(
        H, layer.indentation, pads, PAD, around=[[-7e-3, -4e-3], [7e-3, 4e-3]], cell=0.25
    )
    found = press(SOFT, balls, extent=14e-3, cell=0.4e-3)
    assert found.capacitance(pads, PAD) == pytest.approx(judge, abs=3e-4)
    assert found.capacitance(pads, PAD, order=3) == pytest.approx(judge, abs=1.5e-3)
    assert judge[1] > judge[3] > judge[0] > judge[2]


def test_a_deep_dent_in_bricks_is_refused() -> None:
    with pytest.raises(InputError, match=r"indentation reaches 1\.10 of the thickness"):
        pad_capacitance_3d(
            H, lambda p: np.full(len(p), 1.1 * H), [[0.0, 0.0]], PAD,
            around=[[-1e-3, -1e-3], [1e-3, 1e-3]], cell=0.5,
        )  # fmt: skip
