"""What taxels anywhere read of a press at the origin; of a round one, by distance alone."""

from collections.abc import Callable

import numpy as np

from skinfield.errors import Floats
from skinfield.simulate import Cone, Cylinder, Press, Ring, Sphere

SPACING = 0.1e-3  # m: between the distances at which a round press is read
REACH = 14.0  # thicknesses beyond the press where every reading is below 1e-4 of the highest


def is_round(press: Press) -> bool:
    """Whether a press is the same all around the origin."""
    body = press.indenters[0]
    return (
        len(press.indenters) == 1
        and isinstance(body, Sphere | Cylinder | Cone | Ring)
        and tuple(body.position) == (0.0, 0.0)
        and (isinstance(body, Sphere) or tuple(body.tilt) == (0.0, 0.0))
        and tuple(body.shear) == (0.0, 0.0)
    )


def readings_anywhere(
    press: Press, pad_diameter: float, quantity: str
) -> Callable[[Floats], Floats]:
    """Function from points (N, 2) m to the readings (N,) of taxels there, without noise.

    Of a round press, a cubic spline over the distance: thousands of taxels cost next to nothing.
    """
    if not is_round(press):
        return lambda points: press.readings(points, pad_diameter, quantity)
    from scipy.interpolate import CubicSpline

    loaded = np.abs(press.grid.plane[press.pressure > 0]).max(initial=0.0)
    reach = float(loaded) + pad_diameter + REACH * press.layer.thickness
    distance = np.arange(0.0, reach + SPACING, SPACING)
    line = np.column_stack([distance, np.zeros_like(distance)])
    values = press.readings(line, pad_diameter, quantity)
    spline = CubicSpline(distance, values, bc_type="clamped")  # flat at both ends

    def readings(points: Floats) -> Floats:
        away = np.hypot(points[:, 0], points[:, 1])
        return np.where(away <= distance[-1], spline(np.minimum(away, distance[-1])), 0.0)

    return readings
