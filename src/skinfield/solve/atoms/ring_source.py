"""Ring source: a row of small round contacts, of which fields and contacts of a rim are made."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.solve.atoms.atom_readings import PARAMETERS
from skinfield.solve.atoms.contacts import bodies
from skinfield.solve.atoms.table import BALL, RIM, RING

FEWEST, MOST = 8, 32  # small contacts that a ring becomes
SHARE = 0.5  # thicknesses between them


@dataclass(frozen=True, eq=False)
class Drawable:
    """Atoms without rings, and which of them are one body: those that overlap, or were a ring.

    Attributes
    ----------
    atoms : (N, 6) array
        Of x m, y m, force N, radius m, half-length m and angle rad.
    family : (N,) int array
    covariance : (6 N, 6 N) array
        Of all together.
    groups : list of lists of int
    """

    atoms: Floats
    family: NDArray[np.int64]
    covariance: Floats
    groups: list[list[int]]

    @property
    def each(self) -> Floats:
        """Covariance of each atom alone, (N, 6, 6)."""
        rows = np.arange(len(self.atoms))
        blocks = self.covariance.reshape(len(rows), PARAMETERS, len(rows), PARAMETERS)
        return np.ascontiguousarray(blocks[rows, :, rows, :])


def drawable(
    atoms: Floats, family: NDArray[np.int64], covariance: Floats, thickness: float
) -> Drawable:
    """Atoms (N, 6) in SI with their covariances (N, 6, 6), rings as rows of small balls."""
    from scipy.linalg import block_diag

    whole = np.flatnonzero(family != RING)
    groups = bodies(atoms[whole])
    parts, blocks = [atoms[whole]], list(covariance[whole])
    for row in np.flatnonzero(family == RING):
        small, moves = _pearls(atoms[row], thickness)
        first = sum(len(part) for part in parts)
        groups.append(list(range(first, first + len(small))))
        parts.append(small)
        blocks.append(moves @ covariance[row] @ moves.T)
    every = np.concatenate(parts)
    kinds = np.full(len(every), BALL)
    kinds[: len(whole)] = family[whole]
    return Drawable(every, kinds, np.asarray(block_diag(*blocks)), groups)


def _pearls(ring: Floats, thickness: float) -> tuple[Floats, Floats]:
    """Small balls (N, 6) along a ring, and how all of them move with its parameters (6 N, 6)."""
    number = int(np.clip(np.ceil(2 * np.pi * ring[3] / (SHARE * thickness)), FEWEST, MOST))
    angle = 2 * np.pi * np.arange(number) / number
    small, moves = np.zeros((number, PARAMETERS)), np.zeros((number, PARAMETERS, PARAMETERS))
    small[:, 0] = ring[0] + ring[3] * np.cos(angle)
    small[:, 1] = ring[1] + ring[3] * np.sin(angle)
    small[:, 2] = ring[2] / number
    small[:, 3] = RIM * thickness
    moves[:, 0, 0] = moves[:, 1, 1] = 1.0
    moves[:, 0, 3], moves[:, 1, 3] = np.cos(angle), np.sin(angle)
    moves[:, 2, 2] = 1.0 / number
    return small, moves.reshape(-1, PARAMETERS)
