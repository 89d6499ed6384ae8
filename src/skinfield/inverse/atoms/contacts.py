"""Contacts of fitted atoms."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.fields import Contact
from skinfield.inverse.atoms import outline
from skinfield.inverse.atoms.body import body_of
from skinfield.inverse.atoms.profiles import FLAT
from skinfield.inverse.atoms.render_kernels import (
    NODE,
    WEIGHT,
    Mesh,
    Surface,
    held,
    mesh_of,
    points_along,
    pressure,
    pressure_terms,
)
from skinfield.inverse.atoms.render_std import SIZE
from skinfield.inverse.atoms.render_tables import TERMS
from skinfield.inverse.atoms.render_workspace import Workspace
from skinfield.layout import Grid

LINE = 0.5  # half-length over radius from which an atom is drawn out, not round


@njit(cache=True, nogil=True)
def _pressure_at(
    atoms: Floats, family: Any, surface: Surface, x: float, y: float, room: Floats
) -> float:
    """Pressure of atoms at a place, Pa; at the edge of a flat end that of its middle."""
    total = 0.0
    for n in range(len(atoms)):
        radius = held(atoms[n, 3], surface)
        pressure_terms(radius, family[n], surface, room)
        count = points_along(radius, atoms[n, 4])
        east, north = atoms[n, 4] * np.cos(atoms[n, 5]), atoms[n, 4] * np.sin(atoms[n, 5])
        for q in range(count):
            away_x = x - atoms[n, 0] - NODE[count, q] * east
            away_y = y - atoms[n, 1] - NODE[count, q] * north
            square = 1.0 - (away_x * away_x + away_y * away_y) / (radius * radius)
            if square <= 0.0:
                continue
            value = 0.0
            for j in range(TERMS - 1, -1, -1):
                value = value * square + room[j]
            root = np.sqrt(square)
            value = value / max(root, 0.5) if family[n] == FLAT else value * root
            total += WEIGHT[count, q] * atoms[n, 2] * value / (np.pi * radius * radius)
    return total


@njit(cache=True, nogil=True)
def _inside(atoms: Floats, mesh: Mesh, found: Any) -> int:
    """Write the nodes in any of the atoms, else the nearest one; returns their number, sorted."""
    count = 0
    low, high = np.inf, -np.inf
    for n in range(len(atoms)):
        reach = abs(atoms[n, 4] * np.sin(atoms[n, 5])) + atoms[n, 3]
        low, high = min(low, atoms[n, 1] - reach), max(high, atoms[n, 1] + reach)
    first = max(int(np.ceil((low - mesh.y) / mesh.pitch)), 0)
    last = min(int(np.floor((high - mesh.y) / mesh.pitch)), mesh.rows - 1)
    for row in range(first, last + 1):
        y = mesh.y + row * mesh.pitch
        for column in range(mesh.columns):
            x = mesh.x + column * mesh.pitch
            for n in range(len(atoms)):
                east, north = np.cos(atoms[n, 5]), np.sin(atoms[n, 5])
                away_x, away_y = x - atoms[n, 0], y - atoms[n, 1]
                half = atoms[n, 4]
                along = min(max(away_x * east + away_y * north, -half), half)
                away_x, away_y = away_x - along * east, away_y - along * north
                if away_x * away_x + away_y * away_y <= atoms[n, 3] * atoms[n, 3]:
                    found[count] = row * mesh.columns + column
                    count += 1
                    break
    if count == 0:
        row = int(np.round((atoms[0, 1] - mesh.y) / mesh.pitch))
        column = int(np.round((atoms[0, 0] - mesh.x) / mesh.pitch))
        row, column = min(max(row, 0), mesh.rows - 1), min(max(column, 0), mesh.columns - 1)
        found[0] = row * mesh.columns + column
        count = 1
    return count


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
        peak = _render(
            atoms, family, surface, mesh, space.first, space.boxes[0], space.cells, space.room
        )
        cells = space.found[: _inside(atoms, mesh, space.found)].copy()
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


@njit(cache=True, nogil=True)
def _render(
    atoms: Floats,
    family: Any,
    surface: Surface,
    mesh: Mesh,
    out: Floats,
    box: Any,
    cells: Floats,
    room: Floats,
) -> float:
    """Write the pressure of a body, (K,) Pa; returns its peak, Pa.

    That is the highest on an atom's middle or on a cell: at the edge of a flat end there is none.
    """
    pressure(atoms, family, surface, mesh, out, box, cells, room)
    peak = float(out.max())
    for n in range(len(atoms)):
        peak = max(peak, _pressure_at(atoms, family, surface, atoms[n, 0], atoms[n, 1], room))
    return peak
