"""The pointed profile that a cone turns about its axis and a wedge draws along its edge."""

import numpy as np

from skinfield.errors import Floats, InputError


def check_half_angle(half_angle: float, shape: str) -> None:
    """Raise InputError unless the angle from axis to flank is between 0 and 90 degrees."""
    if not 0.0 < half_angle < np.pi / 2:
        raise InputError(
            f"half_angle is {half_angle!r} rad, expected more than 0 and less than pi/2: between "
            f"the axis and the flank of the {shape}; a flat face is another shape"
        )


def nearest_in_profile(
    across: Floats, along: Floats, half_width: float, tip: float, rise: float
) -> tuple[Floats, Floats]:
    """Nearest points of {0 <= r <= half_width, z >= tip + rise r} to (r, z), r >= 0; all in m."""
    shoulder = tip + rise * half_width
    length = np.hypot(half_width, rise * half_width)
    share = (across * half_width + (along - tip) * rise * half_width) / max(length**2, 1e-300)
    share = np.clip(share, 0.0, 1.0)
    flank = share * half_width, tip + share * (shoulder - tip)
    wall = np.full_like(across, half_width), np.maximum(along, shoulder)
    to_flank = np.hypot(across - flank[0], along - flank[1])
    to_wall = np.hypot(across - wall[0], along - wall[1])
    at_wall = (to_wall < to_flank) & (across > half_width)
    inside = (across <= half_width) & (along >= tip + rise * across)
    return (
        np.where(inside, across, np.where(at_wall, wall[0], flank[0])),
        np.where(inside, along, np.where(at_wall, wall[1], flank[1])),
    )


def lowest_of_profile(
    sideways: float, up: float, half_width: float, tip: float, rise: float
) -> tuple[float, float]:
    """Point (r, z) of that profile, r of either sign, lowest along the direction (sideways, up)."""
    shoulder = tip + rise * half_width
    if up * shoulder - abs(sideways) * half_width < up * tip:
        return -float(np.sign(sideways)) * half_width, shoulder
    return 0.0, tip
