"""Functions across the gap, from the pads at zeta = 0 to the surface at zeta = 1.

They expand the potential wherever the gap is not uniform: 1 - zeta is that of plates, and the modes
vanish on both electrodes.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from skinfield.errors import Floats


@dataclass(frozen=True, eq=False)
class Modes:
    """Integrals over zeta; row and column 0 are of 1 - zeta, the rest of the modes.

    Attributes
    ----------
    mass, stiffness, mixed, stretched : (count + 1, count + 1) array
        Of phi phi, phi' phi', phi zeta phi' (the derivative's index is the column) and
        zeta² phi' phi'.
    eigenvalues : (count,) array
        Of the modes' stiffness where their mass is 1.
    """

    mass: Floats
    stiffness: Floats
    mixed: Floats
    stretched: Floats
    eigenvalues: Floats


@lru_cache(maxsize=4)
def gap_modes(count: int) -> Modes:
    """Modes that diagonalise mass (to 1) and stiffness, from integrals of Legendre polynomials."""
    from numpy.polynomial import legendre
    from scipy.linalg import eigh

    node, weight = legendre.leggauss(count + 4)
    zeta, weight = (node + 1) / 2, weight / 2
    values, slopes = [1 - zeta], [-np.ones_like(zeta)]
    for degree in range(2, count + 2):
        unit = np.eye(degree + 1)
        slopes.append(legendre.legval(node, unit[degree - 1]))
        bubble = legendre.legval(node, unit[degree] - unit[degree - 2])
        values.append(bubble / (2 * (2 * degree - 1)))
    value, slope = np.array(values), np.array(slopes)
    mass, stiffness = (value * weight) @ value.T, (slope * weight) @ slope.T
    eigenvalues, turn = eigh(stiffness[1:, 1:], mass[1:, 1:])
    value[1:], slope[1:] = turn.T @ value[1:], turn.T @ slope[1:]
    return Modes(
        (value * weight) @ value.T,
        (slope * weight) @ slope.T,
        (value * weight * zeta) @ slope.T,
        (slope * weight * zeta**2) @ slope.T,
        eigenvalues,
    )
