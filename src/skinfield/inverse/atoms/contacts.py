"""Contacts of fitted atoms."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.fields import Contact
from skinfield.inverse.atoms import outline
from skinfield.inverse.atoms.body import body_of
from skinfield.inverse.atoms.profiles import FLAT
from skinfield.inverse.atoms.render_kernels import Mesh, Surface, mesh_of
from skinfield.inverse.atoms.render_pressure import render
from skinfield.inverse.atoms.render_std import SIZE
from skinfield.inverse.atoms.render_workspace import Workspace
from skinfield.layout import Grid

LINE = 0.5  # half-length over radius from which an atom is drawn out, not round


def _inside(atoms: Floats, mesh: Mesh) -> NDArray[np.int64]:
    """Nodes in any of the atoms, sorted; else the nearest one."""
    reach = np.abs(atoms[:, 4] * np.sin(atoms[:, 5])) + atoms[:, 3]
    low, high = (atoms[:, 1] - reach).min(), (atoms[:, 1] + reach).max()
    first = max(math.ceil((low - mesh.y) / mesh.pitch), 0)
    last = min(math.floor((high - mesh.y) / mesh.pitch), mesh.rows - 1)
    y = mesh.y + np.arange(first, last + 1)[:, None] * mesh.pitch
    x = mesh.x + np.arange(mesh.columns) * mesh.pitch
    covered = np.zeros((len(y), mesh.columns), dtype=np.bool_)
    for at_x, at_y, _, radius, half, angle in atoms.tolist():
        east, north = math.cos(angle), math.sin(angle)
        away_x, away_y = x - at_x, y - at_y
        along = np.clip(away_x * east + away_y * north, -half, half)
        covered |= (away_x - along * east) ** 2 + (away_y - along * north) ** 2 <= radius * radius
    if covered.any():
        return np.asarray(np.flatnonzero(covered) + first * mesh.columns)
    row, column = (
        round((atoms[0, 1] - mesh.y) / mesh.pitch),
        round((atoms[0, 0] - mesh.x) / mesh.pitch),
    )
    row, column = min(max(row, 0), mesh.rows - 1), min(max(column, 0), mesh.columns - 1)
    return np.array([row * mesh.columns + column])


@dataclass(frozen=True, eq=False)
class ContactBuilder:
    """From atoms to contacts on a grid.

    Parameters
    ----------
    grid : Grid
    surface : Surface
        What round contacts look like.
    workspace : Workspace
    """

    grid: Grid
    surface: Surface
    workspace: Workspace

    @cached_property
    def _flat(self) -> tuple[Floats, Floats] | None:
        """Origin (3,) and frame (3, 3) of a flat patch; None of a curved one."""
        shape, zero = self.grid.patch.surface, np.zeros((1, 2))
        if not shape.is_flat:
            return None
        return shape.position_from_plane(zero)[0], np.array(shape.frame_from_plane(zero)[0])

    def contact(self, atoms: Floats, family: NDArray[np.int64], covariance: Floats) -> Contact:
        """Contact of atoms (N, 6) that are one body, with the covariance (6 N, 6 N) of them all."""
        force = atoms[:, 2]
        total = float(force.sum())
        share = force / total if total > 0.0 else np.full(len(atoms), 1.0 / len(atoms))
        centre = share @ atoms[:, :2]
        moves = _moves(atoms, share, centre, total)
        space, surface, mesh = self.workspace, self.surface, mesh_of(self.grid)
        peak = render(
            atoms, family, surface, mesh, space.first, space.boxes[0], space.cells, space.room
        )
        cells = _inside(atoms, mesh)
        shape = _shape_of(atoms, int(family[0]))
        places = self._position(np.vstack([centre, shape.outline]))  # at once: it is slow if curved
        normal, push, moment = self._resultant(places[0], centre, total, space.first)
        return Contact(
            position=places[0],
            force=push,
            moment=moment,
            normal=normal,
            area=shape.area,
            peak_pressure=peak,
            covariance=moves @ covariance @ moves.T,
            area_std=_area_std(shape.moves, covariance),
            radius=shape.radius,
            shape=shape.name,
            outline=places[1:],
            axes=shape.axes,
            angle=shape.angle,
            cells=cells,
        )

    def _position(self, plane: Floats) -> Floats:
        if self._flat is None:
            return self.grid.patch.surface.position_from_plane(plane)
        return np.asarray(self._flat[0] + plane @ self._flat[1][:, :2].T)

    def _resultant(
        self, position: Floats, centre: Floats, total: float, pressure: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Outward normal, force and moment about the position, (3,) each.

        On a curved patch the force is the sum over the cells, less what lies off the grid.
        """
        if self._flat is not None:
            normal = self._flat[1][:, 2]
            return normal, 0.0 - total * normal, np.zeros(3)
        normal = self.grid.patch.surface.frame_from_plane(centre[None])[0, :, 2]
        cells = np.flatnonzero(pressure)
        weight = pressure[cells] * self.grid.cell_area
        forces = -weight[:, None] * self.grid.normals[cells]
        lever = self.grid.positions[cells] - position
        return normal, forces.sum(axis=0), np.cross(lever, forces).sum(axis=0)


def _moves(atoms: Floats, share: Floats, centre: Floats, total: float) -> Floats:
    """How the place and force of a body move with all parameters of its atoms, (3, 6 N)."""
    out = np.zeros((3, len(atoms), SIZE))
    out[0, :, 0] = out[1, :, 1] = share
    out[2, :, 2] = 1.0
    if len(atoms) > 1 and total > 0.0:
        out[:2, :, 2] = (atoms[:, :2] - centre).T / total
    return out.reshape(3, -1)


@dataclass(frozen=True, eq=False)
class _Shape:
    outline: Floats
    area: float
    axes: Floats
    angle: float
    radius: float
    name: str
    moves: Floats


def _shape_of(atoms: Floats, family: int) -> _Shape:
    """How a body of atoms looks in the plane."""
    if len(atoms) > 1:
        body = body_of(atoms)
        radius = float(np.sqrt(body.area / np.pi))
        return _Shape(body.outline, body.area, body.axes, body.angle, radius, "other", body.moves)
    atom = atoms[0]
    radius, half = float(atom[3]), float(atom[4])
    drawn_out = half > LINE * radius
    area = outline.area(atom)
    return _Shape(
        outline=outline.outline(atom),
        area=area,
        axes=np.array(outline.semi_axes(atom)),
        angle=float((atom[5] + np.pi / 2) % np.pi - np.pi / 2) if half > 0.0 else 0.0,
        radius=radius if half == 0.0 else float(np.sqrt(area / np.pi)),
        name="line" if drawn_out else "flat" if family == FLAT else "sphere",
        moves=np.array([[2.0 * np.pi * radius + 4.0 * half, 4.0 * radius]]),
    )


def _area_std(moves: Floats, covariance: Floats) -> float:
    """Standard deviation of an area that grows by `moves` (N, 2) with radius and half-length."""
    by_all = np.zeros((len(moves), SIZE))
    by_all[:, 3:5] = moves
    variance = float(by_all.ravel() @ covariance @ by_all.ravel())
    return float(np.sqrt(max(variance, 0.0)))
