"""The field in the deformed gap: uniform and rippled plates, pads off the axis, and the series."""

import numpy as np
import pytest
from scipy.special import j0, j1

import skinfield as sf
from skinfield.errors import InputError
from skinfield.fem import SphereProfile, indent, pad_capacitance
from skinfield.simulate import Sphere, press

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
    [(6e-3, 0.5, 0.1258, 0.01), (6e-3, 1.0, 0.2389, 0.03), (6e-3, 3.0, 0.6853, 0.11),
     (3e-3, 1.0, 0.4038, 0.08)],
)  # fmt: skip
def test_the_series_is_short_of_the_field_as_another_solution_says(
    radius: float, force: float, change: float, short: float
) -> None:
    """ΔC/C₀ of a centred pad, by two other Laplace solutions; `short` is what the series lacks."""
    ball = indent(SOFT, SphereProfile(radius=radius), force=force)
    field = pad_capacitance(H, ball.indentation, [0.0], PAD, edges=[ball.contact_radius])[0]
    assert field == pytest.approx(change, rel=2e-3)
    body = Sphere(radius=radius, force=force)
    series = press(SOFT, [body], extent=16e-3, cell=0.25e-3).capacitance([[0.0, 0.0]], PAD)[0]
    assert 1 - series / field == pytest.approx(short, abs=0.012)


def test_pads_off_the_axis_read_as_the_series_says() -> None:
    ball = indent(SOFT, SphereProfile(radius=6e-3), force=0.5)
    away = np.array([2e-3, 3e-3, 4e-3, 5e-3, 8e-3])
    field = pad_capacitance(H, ball.indentation, away, PAD, edges=[ball.contact_radius])
    body = Sphere(radius=6e-3, force=0.5)
    places = np.column_stack([away, np.zeros(5)])
    series = press(SOFT, [body], extent=16e-3, cell=0.25e-3).capacitance(places, PAD)
    assert series == pytest.approx(field, abs=6e-4)
    assert field[3] < 0  # beside the ball the elastomer comes up


def test_a_plane_that_touches_the_pads_is_refused() -> None:
    with pytest.raises(InputError, match=r"indentation reaches 1\.20 of the thickness"):
        pad_capacitance(H, lambda r: np.where(r < 1e-3, 1.2 * H, 0.0), [0.0], PAD)
    with pytest.raises(InputError, match="pad_diameter is 0"):
        pad_capacitance(H, np.zeros_like, [0.0], 0.0)
