"""Displacement of the surface by atoms, compiled."""

from typing import Any

import numpy as np
from numba import njit

from skinfield.errors import Floats
from skinfield.inverse.atoms.render_kernels import (
    COUNT,
    MOST,
    NODE,
    WEIGHT,
    Mesh,
    Surface,
    _blend,
    held,
)
from skinfield.inverse.atoms.render_tables import FOLD, INNER, OUTER


@njit(cache=True, nogil=True)
def _points_along(radius: float, half: float, thickness: float) -> int:
    """How many round atoms make up one: fewer than for the pressure, which is not as smooth."""
    if half <= 0.0:
        return 1
    wide = max(radius, 0.5 * thickness)
    return min(max(int(np.ceil(2.0 + 2.0 * half / wide)), 3), MOST)


@njit(cache=True, nogil=True)
def _radial_terms(
    radius: float, force: float, family: int, surface: Surface, terms: Floats, room: Floats
) -> None:
    """Coefficients (2, COUNT) of one radius and force."""
    first = _blend(radius, surface, room)
    scale = force / radius
    b0, b1, b2, b3 = scale * room[0], scale * room[1], scale * room[2], scale * room[3]
    for part in range(2):
        t0 = surface.displacement[family, first, part]
        t1 = surface.displacement[family, first + 1, part]
        t2 = surface.displacement[family, first + 2, part]
        t3 = surface.displacement[family, first + 3, part]
        for j in range(COUNT):
            terms[part, j] = b0 * t0[j] + b1 * t1[j] + b2 * t2[j] + b3 * t3[j]


@njit(cache=True, nogil=True)
def _add_round(
    x: float,
    y: float,
    radius: float,
    share: float,
    terms: Floats,
    surface: Surface,
    mesh: Mesh,
    out: Floats,
) -> None:
    """Add a round atom's displacement along the two axes of the plane and outwards, (K, 3)."""
    far = min(radius + surface.reach, 1e9)
    pitch = mesh.pitch
    first_row = max(int(np.ceil((y - far - mesh.y) / pitch)), 0)
    first_column = max(int(np.ceil((x - far - mesh.x) / pitch)), 0)
    last_row = min(int(np.floor((y + far - mesh.y) / pitch)), mesh.rows - 1)
    last_column = min(int(np.floor((x + far - mesh.x) / pitch)), mesh.columns - 1)
    square, limit, fold = radius * radius, far * far, FOLD * surface.thickness
    normal, radial = terms[0], terms[1]
    for row in range(first_row, last_row + 1):
        away_y = mesh.y + row * pitch - y
        for column in range(first_column, last_column + 1):
            away_x = mesh.x + column * pitch - x
            r2 = away_x * away_x + away_y * away_y
            if r2 > limit:
                continue
            if r2 < square:
                t = np.sqrt(1.0 - r2 / square)
                up, out_by = normal[INNER - 1], radial[INNER - 1]
                for j in range(INNER - 2, -1, -1):
                    up = up * t + normal[j]
                    out_by = out_by * t + radial[j]
            else:
                s = np.sqrt(r2 - square)
                place = OUTER * s / (s + fold)
                i = min(int(place), OUTER - 1)
                t = place - i
                c = INNER + 4 * i
                up = ((normal[c] * t + normal[c + 1]) * t + normal[c + 2]) * t + normal[c + 3]
                out_by = ((radial[c] * t + radial[c + 1]) * t + radial[c + 2]) * t + radial[c + 3]
            k = row * mesh.columns + column
            out[k, 0] += share * out_by * away_x
            out[k, 1] += share * out_by * away_y
            out[k, 2] += share * up


@njit(cache=True, nogil=True)
def displacement(
    atoms: Floats,
    family: Any,
    surface: Surface,
    mesh: Mesh,
    frames: Floats,
    out: Floats,
    terms: Floats,
    room: Floats,
) -> None:
    """Write the displacement of the nodes in the patch's frame, (K, 3) m.

    `frames` (K, 3, 3), or (1, 3, 3) where all are the same.
    """
    out[:] = 0.0
    for n in range(len(atoms)):
        radius = held(atoms[n, 3], surface)
        _radial_terms(radius, atoms[n, 2], family[n], surface, terms, room)
        count = _points_along(radius, atoms[n, 4], surface.thickness)
        east, north = atoms[n, 4] * np.cos(atoms[n, 5]), atoms[n, 4] * np.sin(atoms[n, 5])
        for q in range(count):
            x, y = atoms[n, 0] + NODE[count, q] * east, atoms[n, 1] + NODE[count, q] * north
            _add_round(x, y, radius, WEIGHT[count, q], terms, surface, mesh, out)
    for k in range(len(out)):
        frame = frames[k if len(frames) > 1 else 0]
        u, v, w = out[k, 0], out[k, 1], out[k, 2]
        for i in range(3):
            out[k, i] = frame[i, 0] * u + frame[i, 1] * v + frame[i, 2] * w
