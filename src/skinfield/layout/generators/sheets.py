"""Patches without modules: flat arrays, cylinders and spheres."""

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_positive, check_range
from skinfield.layout.patch import Patch

MOST = 100_000  # taxels; the largest skins of today have some thousands


def rectangular(
    rows: int = 8, columns: int = 8, pitch: float = 4e-3, pad_diameter: float = 3e-3
) -> Patch:
    """Flat array, centred; taxel row * columns + column, x to the right, y up.

    Parameters
    ----------
    rows, columns : int
    pitch : float, m
        Between neighbours in a row and in a column.
    pad_diameter : float, m
    """
    for name, value in (("rows", rows), ("columns", columns)):
        if value < 1:
            raise InputError(f"{name} is {value!r}, expected 1 or more taxels")
    check_positive("pitch", pitch, "between neighbouring taxels, in metres")
    _check_count(rows * columns)
    x, y = np.meshgrid(_centred(columns) * pitch, _centred(rows) * pitch)
    positions = np.column_stack([x.ravel(), y.ravel()])
    return Patch(positions, pad_diameter, uid=_uids(rows * columns), name="rectangular")


def cylinder(
    radius: float = 40e-3,
    length: float = 80e-3,
    arc_angle: float = np.pi,
    pitch: float = 5e-3,
    pad_diameter: float = 4e-3,
) -> Patch:
    """Outside of a cylinder about the y axis, its middle at +z; rows run around it.

    Parameters
    ----------
    radius, length : float, m
    arc_angle : float, rad
        Covered part of the circle, up to 2π; there the taxels close the ring evenly.
    pitch : float, m
        Along the axis and around it; whole pitches fit into `length` and the arc.
    pad_diameter : float, m
    """
    check_positive("radius", radius, "of the cylinder, in metres")
    check_positive("length", length, "of the cylinder, in metres")
    check_positive("pitch", pitch, "between neighbouring taxels, in metres")
    check_range("arc_angle", arc_angle, 0.0, 2 * np.pi + 1e-9, "radians around the cylinder")
    _check_count((1 + radius * arc_angle / pitch) * (1 + length / pitch))
    fit = int(radius * arc_angle / pitch + 1e-9)
    closed = 2 * np.pi * radius - fit * pitch < pitch * (1 - 1e-9)
    around = _centred(max(fit, 1)) * 2 * np.pi / max(fit, 1)
    around = around if closed else _centred(fit + 1) * pitch / radius
    along = _centred(int(length / pitch + 1e-9) + 1) * pitch
    angle, y = (a.ravel() for a in np.meshgrid(around, along))
    normals = np.column_stack([np.sin(angle), np.zeros(len(y)), np.cos(angle)])
    positions = radius * normals + y[:, None] * [0.0, 1.0, 0.0]
    return Patch(
        positions, pad_diameter, normals=normals, uid=_uids(len(positions)), name="cylinder"
    )


def sphere_cap(
    radius: float = 50e-3,
    cap_angle: float = np.pi / 6,
    pitch: float = 5e-3,
    pad_diameter: float = 4e-3,
) -> Patch:
    """Outside of a cap of a sphere about the origin, its pole at +z; taxels lie on rings.

    Parameters
    ----------
    radius : float, m
    cap_angle : float, rad
        From the pole to the rim, up to π.
    pitch : float, m
        From ring to ring along the sphere, and within a ring as nearly as a whole number allows.
    pad_diameter : float, m
    """
    check_positive("radius", radius, "of the sphere, in metres")
    check_positive("pitch", pitch, "between neighbouring taxels, in metres")
    check_range("cap_angle", cap_angle, 0.0, np.pi + 1e-9, "radians from the pole to the rim")
    _check_count(2 * np.pi * (radius / pitch) ** 2 * (1 - np.cos(cap_angle)))
    polar = np.arange(int(radius * cap_angle / pitch + 1e-9) + 1) * pitch / radius
    rings = [_ring(angle, radius / pitch, shift=k % 2 / 2) for k, angle in enumerate(polar)]
    normals = np.concatenate(rings)
    return Patch(
        radius * normals, pad_diameter, normals=normals, uid=_uids(len(normals)), name="sphere_cap"
    )


def _ring(polar: float, radius: float, shift: float) -> Floats:
    """Directions (n, 3) at one angle from the pole on a sphere of `radius` pitches."""
    count = max(int(np.round(2 * np.pi * radius * np.sin(polar))), 1)
    around = 2 * np.pi * (np.arange(count) + shift) / count
    return np.column_stack(
        [
            np.sin(polar) * np.cos(around),
            np.sin(polar) * np.sin(around),
            np.full(count, np.cos(polar)),
        ]
    )


def _check_count(taxels: float) -> None:
    if taxels > MOST:
        raise InputError(
            f"the patch would have about {taxels:.3g} taxels, expected at most {MOST}: "
            "check the units, lengths are in metres"
        )


def _centred(count: int) -> Floats:
    return np.asarray(np.arange(count) - (count - 1) / 2, dtype=np.float64)


def _uids(count: int) -> NDArray[np.uint64]:
    """Numbers that no importer takes for a missing taxel (0) or a thermometer (low four bits 0)."""
    row = np.arange(count)
    return np.asarray(row // 12 << 4 | row % 12 + 1, dtype=np.uint64)
