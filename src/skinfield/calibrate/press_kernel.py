"""Readings of many presses one by one, compiled: each is an atom of its own."""

import numpy as np

from skinfield.compiled import njit
from skinfield.errors import Floats
from skinfield.solve.atoms.atom_readings import PARAMETERS, TableRoom, add_atom
from skinfield.solve.atoms.table import Tables


@njit
def read_each(atoms: Floats, taxels: Floats, tables: Tables, out: Floats, slopes: Floats) -> None:
    """Write readings (N, L) of atoms (N, 8), each alone, and derivatives (N, 8, L).

    `slopes` may be of one atom, (1, 8, L): then they are of the last.
    """
    near = np.arange(len(taxels))
    room = TableRoom(
        np.empty((3, tables.coefficients.shape[3])),
        np.empty((2, tables.coefficients.shape[2])),
        np.empty((2, 4)),
        np.empty((2, tables.shear.shape[2])),
    )
    rows = slopes.reshape(-1, len(taxels))
    last = len(slopes) - 1
    out[:] = 0.0
    for n in range(len(atoms)):
        row = min(n, last)
        its = rows[PARAMETERS * row : PARAMETERS * (row + 1)]
        add_atom(0, atoms[n], 0, taxels, near, tables, room, out[n], its)
