"""Pressure of atoms on the cells of a grid, and its peak, compiled."""

from typing import Any

import numpy as np
from numba import njit

from skinfield.errors import Floats
from skinfield.inverse.atoms.compiled import inner
from skinfield.inverse.atoms.profiles import FLAT
from skinfield.inverse.atoms.render_kernels import (
    NODE,
    WEIGHT,
    Mesh,
    Surface,
    held,
    points_along,
    pressure,
    pressure_terms,
)
from skinfield.inverse.atoms.render_tables import TERMS


@inner
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
def render(
    atoms: Floats,
    family: Any,
    surface: Surface,
    mesh: Mesh,
    out: Floats,
    box: Any,
    cells: Floats,
    room: Floats,
) -> float:
    """Write the mean pressure of atoms on each cell, (K,) Pa; returns the peak of it, Pa.

    It is the highest on an atom's middle or on a cell: at the edge of a flat end there is none.
    """
    pressure(atoms, family, surface, mesh, out, box, cells, room)
    peak = 0.0
    for k in range(len(out)):
        peak = max(peak, out[k])
    for n in range(len(atoms)):
        peak = max(peak, _pressure_at(atoms, family, surface, atoms[n, 0], atoms[n, 1], room))
    return peak
