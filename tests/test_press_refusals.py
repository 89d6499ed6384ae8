"""What a press cannot hold or solve is refused by name, before it costs memory or misleads."""

import pytest

import skinfield as sf
from skinfield.errors import InputError
from skinfield.simulate import Sphere, press

LAYER = sf.Layer(2e-3, 100e3, 0.5)


def test_pads_in_millimetres_do_not_fill_the_memory() -> None:
    """The field in the gap is solved on a mesh over all pads."""
    pressed = press(LAYER, [Sphere(radius=6e-3, force=0.5)], extent=12e-3, cell=1e-3)
    with pytest.raises(InputError, match=r"positions lie up to 25 m .* give positions in metres"):
        pressed.capacitance([[25.0, -10.0], [0.0, 0.0]], 4e-3)


def test_a_ball_beside_the_skin_hears_of_the_border_not_of_its_depth() -> None:
    with pytest.raises(InputError, match=r"touches the border of the 0\.02 m of skin"):
        press(LAYER, [Sphere(radius=6e-3, position=(14e-3, 0.0))], extent=20e-3, cell=1e-3)


@pytest.mark.parametrize("order", [0, 4, 2.5])
def test_a_series_of_other_orders_is_refused(order: int) -> None:
    pressed = press(LAYER, [Sphere(radius=6e-3, force=0.5)], extent=12e-3, cell=1e-3)
    with pytest.raises(InputError, match=r"order is .*, expected 1, 2 or 3 terms"):
        pressed.capacitance([[0.0, 0.0]], 4e-3, order)
