"""What a region of pressure amounts to, and how sure that is."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.contacts.area import area_moves
from skinfield.contacts.regions import border
from skinfield.errors import Floats
from skinfield.fields import Contact, ModelError, PressureError
from skinfield.layout import Grid


@dataclass(frozen=True, eq=False)
class Field:
    """A pressure field with what is known of its error.

    Attributes
    ----------
    grid : Grid
    pressure : (K,) array, Pa
    error : PressureError
    edge : float
        Fraction of a region's peak at which the region ends.
    """

    grid: Grid
    pressure: Floats
    error: PressureError
    edge: float


def contact_of(field: Field, cells: NDArray[np.int64], model_error: ModelError) -> Contact:
    """Contact of a region.

    Its covariance is that of sums over the region's cells: of the pressure for the force and, to
    first order, of the pressure's first moments about the centre for the place. Which cells make up
    the region is taken as given.
    """
    grid = field.grid
    weight = field.pressure[cells] * grid.cell_area
    total = float(weight.sum())
    centre = weight @ grid.plane[cells] / total
    surface = grid.patch.surface
    position = surface.position_from_plane(centre[None])[0]
    normal = surface.frame_from_plane(centre[None])[0, :, 2]
    forces = -weight[:, None] * grid.normals[cells]
    lever = grid.positions[cells] - position
    away = grid.plane[cells] - centre
    axes, angle = _ellipse(away, weight / total, grid.cell_area)
    corners = grid.origin + border(cells, grid.shape) * grid.pitch
    area = len(cells) * grid.cell_area
    moves = np.stack([*(away / total).T, np.ones(len(cells))]) * grid.cell_area
    return Contact(
        position=position,
        force=forces.sum(axis=0),
        moment=np.cross(lever, forces).sum(axis=0),
        normal=normal,
        area=area,
        peak_pressure=float(field.pressure[cells].max()),
        covariance=field.error.covariance_of_sums(cells, moves) + model_error.covariance(total),
        area_std=_area_std(field, cells, area * model_error.area),
        radius=float(np.sqrt(area / np.pi)),
        shape="other",
        outline=surface.position_from_plane(corners),
        axes=axes,
        angle=angle,
        cells=cells,
    )


def _ellipse(away: Floats, share: Floats, cell_area: float) -> tuple[Floats, float]:
    """Semi-axes and angle of the uniform ellipse with the moments of shares (N,) at (N, 2) m."""
    spread = (away * share[:, None]).T @ away + np.eye(2) * cell_area / 12
    variance, direction = np.linalg.eigh(spread)
    angle = float(np.arctan2(direction[1, 1], direction[0, 1]))
    return 2.0 * np.sqrt(variance[::-1]), (angle + np.pi / 2) % np.pi - np.pi / 2


def _area_std(field: Field, cells: NDArray[np.int64], beside: float) -> float:
    around, moves, rounding = area_moves(field.grid, field.pressure, cells, field.edge)
    variance = field.error.covariance_of_sums(around, moves[None])[0, 0]
    return float(np.sqrt(max(variance, 0.0) + rounding**2 + beside**2))
