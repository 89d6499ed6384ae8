"""Dictionary of templates of single contacts all over a patch: where a search starts."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import njit
from skinfield.errors import Floats, Ints
from skinfield.solve.atoms.fit_kernel import PARAMETERS, predict
from skinfield.solve.atoms.table import Tables

SPACING = 0.5  # thicknesses between places
RADII = (0.4, 0.8, 1.5, 2.6)  # thicknesses
MARGIN = 1.5  # thicknesses beyond the outermost pads
SHALLOW = 0.15  # strain of the gap at the axis at which templates are made
SAME = 1e-5  # part of a score: what single precision cannot tell is the same, and the first counts
FAINTEST = 0.02  # of the strongest template: below, a place is not seen


@dataclass(frozen=True, eq=False)
class BallTemplates:
    """Whitened templates of balls.

    Attributes
    ----------
    templates : (T, L) float32 array
        Of norm 1.
    norms : (T,) array
        Before that, per newton.
    atoms : (T, 6) array
        Parameters of each, with the force at which it was made.
    """

    templates: NDArray[np.float32]
    norms: Floats
    atoms: Floats

    def starts(self, residual: Floats, most: int, least: float = 0.0) -> Floats:
        """Atoms (S, 6) at the best places, each with the force that explains most.

        None if no template agrees with the whitened residual (L,) by more than `least` standard
        deviations.
        """
        scores = np.asarray(self.templates @ residual.astype(np.float32))
        if not float(scores.max(initial=0.0)) > least:
            return np.empty((0, PARAMETERS))
        best = np.empty(most, np.int64)
        best = best[: best_of(scores, self.atoms, 1.2 * SPACING, best)]
        atoms = self.atoms[best]
        atoms[:, 2] = np.log(np.maximum(scores[best] / self.norms[best], 1e-9))
        return atoms


@njit
def best_of(scores: Any, atoms: Floats, near: float, found: Ints) -> int:
    """Write into `found` (S,) the best templates, none beside a better one; how many there are."""
    for count in range(len(found)):
        best, value = -1, 0.0
        for t in range(len(scores)):
            if scores[t] <= (1.0 + SAME) * value:
                continue
            beside = False
            for k in range(count):
                other = atoms[found[k]]
                if (
                    abs(atoms[t, 0] - other[0]) < near
                    and abs(atoms[t, 1] - other[1]) < near
                    and abs(atoms[t, 3] - other[3]) < 1.0
                ):
                    beside = True
                    break
            if not beside:
                best, value = t, scores[t]
        if best < 0:
            return count
        found[count] = best
    return len(found)


def make_bank(taxels: Floats, white: Floats, tables: Tables) -> BallTemplates:
    """Templates on a lattice over the taxels (L, 2), in thicknesses; `white` is 1/noise (L,)."""
    low, high = taxels.min(axis=0) - MARGIN, taxels.max(axis=0) + MARGIN
    columns, rows = (np.ceil((high - low) / SPACING).astype(int) + 1).tolist()
    x, y = np.meshgrid(low[0] + SPACING * np.arange(columns), low[1] + SPACING * np.arange(rows))
    places = np.column_stack([x.ravel(), y.ravel()])
    every = []
    for radius in RADII:
        atoms = np.zeros((len(places), PARAMETERS))
        atoms[:, :2] = places
        atoms[:, 3] = np.log(radius)
        atoms[:, 2] = _shallow_log_force(tables, float(np.log(radius)))
        every.append(atoms)
    atoms = np.concatenate(every)
    templates = np.empty((len(atoms), len(taxels)))
    family, jacobian = np.zeros(1, dtype=np.int64), np.empty((len(taxels), 1, PARAMETERS))
    for index, atom in enumerate(atoms):
        predict(atom[None], family, taxels, tables, templates[index], jacobian)
    templates *= white
    norms = np.linalg.norm(templates, axis=1)
    seen = norms * np.exp(-atoms[:, 2])
    kept = seen > FAINTEST * seen.max()
    return BallTemplates(
        np.ascontiguousarray(templates[kept] / norms[kept, None], dtype=np.float32),
        norms[kept] * np.exp(-atoms[kept, 2]),
        atoms[kept],
    )


def _shallow_log_force(tables: Tables, log_radius: float) -> float:
    if not tables.strain.size:
        return 0.0
    from scipy.ndimage import map_coordinates

    place = (log_radius - tables.first_log) / tables.log_step
    log_strain = map_coordinates(tables.strain[0], [[place]], order=3, prefilter=False)[0]
    return float(np.log(SHALLOW) - log_strain)
