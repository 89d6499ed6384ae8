"""What taxels anywhere read of a press at the origin; of a round one, by distance alone."""

from collections.abc import Callable

import numpy as np

from skinfield.errors import Floats, check_positive
from skinfield.simulate.indenters import Cone, Cylinder, Ring, Sphere
from skinfield.simulate.pressing.press import Press

Readings = Callable[[Floats], Floats]
SPACING = 0.1e-3  # m: between the distances at which a round press is read
REACH = 14.0  # thicknesses beyond the press where every reading is below 1e-4 of the highest
WIDE = 8.0  # thicknesses around any other press that a table covers


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
    press: Press, pad_diameter: float, quantity: str, spacing: float | None = None
) -> Readings:
    """Function from points (N, 2) m to the readings (N,) of taxels there, without noise.

    Of a round press, a cubic spline over the distance: thousands of taxels cost next to nothing.

    Parameters
    ----------
    press : Press
    pad_diameter : float, m
    quantity : "capacitance", "gap" or "stress"
    spacing : float, m, optional
        Of any other press, a bicubic spline over a table of points so far from each other; it is 0
        beyond eight thicknesses around the press. Without it, every call computes its readings.
    """
    if is_round(press):
        return _by_distance(press, pad_diameter, quantity)
    if spacing is not None:
        check_positive("spacing", spacing, "between the points of the table, in metres")
        return _by_table(press, pad_diameter, quantity, spacing)
    return lambda points: press.readings(points, pad_diameter, quantity)


def _by_distance(press: Press, pad_diameter: float, quantity: str) -> Readings:
    from scipy.interpolate import CubicSpline

    distance = np.arange(0.0, _reach(press, pad_diameter, REACH) + SPACING, SPACING)
    line = np.column_stack([distance, np.zeros_like(distance)])
    values = press.readings(line, pad_diameter, quantity)
    spline = CubicSpline(distance, values, bc_type="clamped")  # flat at both ends

    def readings(points: Floats) -> Floats:
        away = np.hypot(points[:, 0], points[:, 1])
        return np.where(away <= distance[-1], spline(np.minimum(away, distance[-1])), 0.0)

    return readings


def _by_table(press: Press, pad_diameter: float, quantity: str, spacing: float) -> Readings:
    from scipy.interpolate import RectBivariateSpline

    half = int(np.ceil(_reach(press, pad_diameter, WIDE) / spacing))
    axis = np.arange(-half, half + 1) * spacing
    x, y = np.meshgrid(axis, axis, indexing="ij")
    values = press.readings(np.column_stack([x.ravel(), y.ravel()]), pad_diameter, quantity)
    spline = RectBivariateSpline(axis, axis, values.reshape(x.shape))

    def readings(points: Floats) -> Floats:
        inside = (np.abs(points) <= axis[-1]).all(axis=1)
        return np.where(inside, spline.ev(points[:, 0], points[:, 1]), 0.0)

    return readings


def _reach(press: Press, pad_diameter: float, thicknesses: float) -> float:
    loaded = float(np.abs(press.grid.plane[press.pressure > 0]).max(initial=0.0))
    return loaded + pad_diameter + thicknesses * press.layer.thickness
