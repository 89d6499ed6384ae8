"""Contacts of rows of numbers: shape, outline, and `Contact` as an estimate has it."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.estimate.contact import Contact
from skinfield.skin import Grid, Patch
from skinfield.skin.flattening import Surface

CONTACT = np.dtype(
    [
        ("track", np.int64),
        ("patch", np.int32),
        ("cells", np.int32),
        ("position", np.float64, (3,)),
        ("normal", np.float64, (3,)),
        ("x", np.float64),
        ("y", np.float64),
        ("normal_force", np.float64),
        ("force_std", np.float64),
        ("place_std", np.float64),
        ("area", np.float64),
        ("peak_pressure", np.float64),
        ("moments", np.float64, (3,)),
        ("age", np.float64),
        ("speed", np.float64),
        ("shape", np.int32),
        ("maybe", np.int32),
        ("radius", np.float64),
        ("covariance", np.float64, (6,)),
        ("area_std", np.float64),
        ("shear", np.float64, (3,)),
        ("shear_covariance", np.float64, (3,)),
    ]
)
SHAPES = ("other", "sphere", "flat", "line")  # what `shape` is an index into
POINTS = 32  # of an outline
PLACES = np.array([[0, 1, 3], [1, 2, 4], [3, 4, 5]])  # of a covariance (3, 3) among a row's numbers
STEP = 1e-4  # m each way, along which the first tangent of a surface is taken
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
    """Border of a row, closed, (POINTS + 1, 3) m in the patch's frame.

    Its `ellipse_of`; of a line what lies as near to a segment as its area and moments say.
    """
    (a, b), angle = ellipse_of(row)
    half = 0.0  # of the segment
    if shape_name(row) == SHAPES[-1] and a > b:
        xx, yy, xy = np.asarray(row["moments"]).tolist()
        half = (6.0 * math.hypot(0.5 * (xx - yy), xy)) ** 0.5
        a = b = (math.sqrt(4.0 * half**2 + math.pi**2 * a * b) - 2.0 * half) / math.pi
    turn = np.linspace(0.0, 2.0 * math.pi, POINTS + 1)
    u, v = a * np.cos(turn) + np.copysign(half, np.cos(turn)), b * np.sin(turn)
    c, s = math.cos(angle), math.sin(angle)
    x, y = float(row["x"]), float(row["y"])
    plane = np.column_stack([x + c * u - s * v, y + s * u + c * v])
    if surface.is_flat:
        return np.asarray(surface.position_from_plane(plane))
    middle = surface.position_from_plane(np.array([[x, y]]))[0]
    height = float((row["position"] - middle) @ row["normal"])  # of where pressure acts
    normals = surface.frame_from_plane(plane)[:, :, 2]
    return np.asarray(surface.position_from_plane(plane) + height * normals)


def covariance_of(row: Any) -> Floats:
    """Of a row's place x, y, m, and force, N: (3, 3). Diagonal where a row has deviations alone."""
    covariance = np.asarray(row["covariance"])[PLACES]
    if np.isfinite(covariance).all():
        return np.array(covariance)
    return np.diag(np.square([row["place_std"], row["place_std"], row["force_std"]]))


def force_of(row: Any) -> Floats:
    """Force (3,) of a row onto the skin, N, in the patch's frame."""
    return np.asarray(row["shear"] - float(row["normal_force"]) * row["normal"])


def force_covariance_of(surface: Surface, row: Any) -> Floats:
    """Covariance (3, 3) of `force_of`, N²; NaN where a row does not say it."""
    normal, axes = np.asarray(row["normal"]), _tangents(surface, row)
    along = axes @ _shear_covariance(row) @ axes.T
    return np.asarray(along + covariance_of(row)[2, 2] * np.outer(normal, normal))


def shear_of(surface: Surface, row: Any) -> tuple[Floats, Floats]:
    """Force along the skin of a row by the plane's x and y, (2,) N, and its covariance, N²."""
    return np.asarray(row["shear"] @ _tangents(surface, row)), _shear_covariance(row)


def _shear_covariance(row: Any) -> Floats:
    xx, xy, yy = np.asarray(row["shear_covariance"]).tolist()
    return np.array([[xx, xy], [xy, yy]])


def _tangents(surface: Surface, row: Any) -> Floats:
    """Unit vectors (3, 2) along the skin at a row's place: by the plane's x, and across it."""
    normal = np.asarray(row["normal"])
    ahead = np.array([[row["x"] - STEP, row["y"]], [row["x"] + STEP, row["y"]]])
    east = np.subtract(*surface.position_from_plane(ahead)[::-1])
    east = east - (east @ normal) * normal
    return np.asarray(np.stack([east, np.cross(normal, east)], axis=1) / np.linalg.norm(east))


def moved_rows(rows: NDArray[np.void], grid: Grid, shift: Floats) -> NDArray[np.void]:
    """Copy of rows of `CONTACT`, moved in the plane by a shift (2,), m, onto another patch."""
    from skinfield.estimate.live_contacts_kernel import move_rows

    out = rows.copy()
    if np.any(shift):
        numbers = np.array([grid.shape[1], grid.pitch, *grid.origin])
        places = np.array(grid.positions, order="C"), np.array(grid.normals, order="C")
        move_rows(out, shift, *places, numbers)
    return out


def pressure_std_of_rows(rows: NDArray[np.void], grid: Grid, pressure: Floats) -> Floats:
    """One standard deviation of the pressure of contacts, (K,) Pa, as their rows state them.

    To first order in the place, the force and the area of the contact that is nearest to a node;
    at most its peak pressure.
    """
    if not len(rows):
        return np.zeros(len(grid))
    nearest = _nearest(rows, grid.plane)
    by_y, by_x = np.gradient(pressure.reshape(grid.shape), grid.pitch)
    force = np.where(rows["normal_force"] > 0.0, rows["normal_force"], np.inf)[nearest]
    moves = np.stack([-by_x.ravel(), -by_y.ravel(), pressure / force], axis=1)
    known = np.stack([covariance_of(row) for row in rows])[nearest]
    variance = np.einsum("ki,kij,kj->k", moves, known, moves)
    area = np.nan_to_num(rows["area_std"] / rows["area"])[nearest]
    variance = np.maximum(variance, 0.0) + np.square(area * pressure)
    return np.asarray(np.minimum(np.sqrt(variance), rows["peak_pressure"][nearest]))


def _nearest(rows: NDArray[np.void], plane: Floats) -> NDArray[np.int64]:
    """Which of the rows is nearest to each of some places (K, 2), m."""
    apart = [np.hypot(*(plane - [row["x"], row["y"]]).T) for row in rows]
    return np.asarray(np.argmin(apart, axis=0))


def contacts_of_rows(
    rows: NDArray[np.void],
    grid: Grid,
    pressure: Floats,
    cells: Sequence[NDArray[np.int64]] | None = None,
) -> tuple[Contact, ...]:
    """Contacts of one patch, as its rows of `CONTACT` state them.

    Parameters
    ----------
    rows : (N,) array of CONTACT
    grid : Grid
    pressure : (K,) array, Pa
    cells : N int arrays, optional
        Nodes of each. Default those that are pressed, each of the nearest contact.
    """
    if cells is None:
        pressed = np.flatnonzero(pressure > 0.0)
        nearest = _nearest(rows, grid.plane[pressed]) if len(rows) else pressed
        cells = [pressed[nearest == place] for place in range(len(rows))]
    patch = grid.patch
    return tuple(contact_of_row(patch, row, its) for row, its in zip(rows, cells, strict=True))


def contact_of_row(patch: Patch, row: Any, cells: NDArray[np.int64]) -> Contact:
    """Contact of a patch, as its row of `CONTACT` states it; with its nodes of a grid."""
    area, radius = float(row["area"]), float(row["radius"])
    axes, angle = ellipse_of(row)
    return Contact.later(
        Outline(patch.surface, row),
        position=np.array(row["position"]),
        force=0.0 + force_of(row),
        moment=np.zeros(3),
        normal=np.array(row["normal"]),
        area=area,
        peak_pressure=float(row["peak_pressure"]),
        covariance=covariance_of(row),
        area_std=float(row["area_std"]),
        radius=radius if math.isfinite(radius) else math.sqrt(max(area, 0.0) / math.pi),
        shape=shape_name(row),
        axes=axes,
        angle=angle,
        cells=cells,
        maybe=int(row["maybe"]),
        track_id=int(row["track"]) or None,
        link=patch.link,
    )


class Outline(NamedTuple):
    """What of a row's contact is dear, worked out when asked for; see `Contact.later`."""

    surface: Surface
    row: Any

    @property
    def force_covariance(self) -> Floats:
        """See `force_covariance_of`."""
        return force_covariance_of(self.surface, self.row)

    @property
    def tangents(self) -> Floats:
        """See `_tangents`."""
        return _tangents(self.surface, self.row)

    @property
    def outline(self) -> Floats:
        """See `outline_of`."""
        return outline_of(self.surface, self.row)
