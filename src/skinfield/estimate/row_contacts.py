"""Contacts of rows of numbers: shape, outline, and `Contact` as an estimate has it."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.estimate.contact import Contact
from skinfield.estimate.live_contacts import SHAPES
from skinfield.skin import Grid
from skinfield.skin.flattening import Surface

POINTS = 32  # of an outline
LONGEST = 10.0  # times the radius of the circle of equal area, of an ellipse


def shape_name(row: Any) -> str:
    """What presses, of a row of `CONTACT`; "other" for a number that is none of `SHAPES`."""
    number = int(row["shape"])
    return SHAPES[number] if 0 <= number < len(SHAPES) else SHAPES[0]


def ellipse_of(row: Any) -> tuple[Floats, float]:
    """Semi-axes (2,) m, the longer first, and the angle to the longer one, rad, of a row.

    Their ratio is that of the row's second moments, and the ellipse has its area.
    """
    area, (xx, yy, xy) = float(row["area"]), np.asarray(row["moments"]).tolist()
    radius = math.sqrt(area / math.pi) if math.isfinite(area) and area > 0.0 else 0.0
    half, mean = math.hypot(0.5 * (xx - yy), xy), 0.5 * (xx + yy)
    if not half < mean < math.inf:  # not known
        return np.full(2, radius), 0.0
    stretch = min(((mean + half) / (mean - half)) ** 0.25, LONGEST)
    return np.array([radius * stretch, radius / stretch]), 0.5 * math.atan2(2.0 * xy, xx - yy)


def outline_of(surface: Surface, row: Any) -> Floats:
    """Border of a row's `ellipse_of`, closed, (POINTS + 1, 3) m in the patch's frame."""
    (a, b), angle = ellipse_of(row)
    turn = np.linspace(0.0, 2.0 * math.pi, POINTS + 1)
    u, v = a * np.cos(turn), b * np.sin(turn)
    c, s = math.cos(angle), math.sin(angle)
    x, y = float(row["x"]), float(row["y"])
    plane = np.column_stack([x + c * u - s * v, y + s * u + c * v])
    return np.asarray(surface.position_from_plane(plane))


def contacts_of_rows(rows: NDArray[np.void], grid: Grid, pressure: Floats) -> tuple[Contact, ...]:
    """Contacts of one patch, as its rows of `CONTACT` state them.

    Parameters
    ----------
    rows : (N,) array of CONTACT
    grid : Grid
    pressure : (K,) array, Pa
        Each node that is pressed belongs to the nearest contact.
    """
    pressed = np.flatnonzero(pressure > 0.0)
    apart = [np.hypot(*(grid.plane[pressed] - [row["x"], row["y"]]).T) for row in rows]
    nearest = np.argmin(apart, axis=0) if len(rows) else pressed
    return tuple(_contact(grid, row, pressed[nearest == place]) for place, row in enumerate(rows))


def _contact(grid: Grid, row: Any, cells: NDArray[np.int64]) -> Contact:
    place, force = float(row["place_std"]) ** 2, float(row["force_std"]) ** 2
    area, radius = float(row["area"]), float(row["radius"])
    axes, angle = ellipse_of(row)
    return Contact(
        position=np.array(row["position"]),
        force=0.0 - float(row["normal_force"]) * np.array(row["normal"]),
        moment=np.zeros(3),
        normal=np.array(row["normal"]),
        area=area,
        peak_pressure=float(row["peak_pressure"]),
        covariance=np.diag([place, place, force]),
        area_std=math.nan,
        radius=radius if math.isfinite(radius) else math.sqrt(max(area, 0.0) / math.pi),
        shape=shape_name(row),
        outline=outline_of(grid.patch.surface, row),
        axes=axes,
        angle=angle,
        cells=cells,
        track_id=int(row["track"]),
    )
