"""One direction of a box of bricks: quadratic and linear elements along a line."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skinfield.errors import Floats, Ints
from skinfield.fem.library import scikit_fem
from skinfield.fem.trace import shapes


@dataclass(frozen=True, eq=False)
class Line:
    """Integrals of products of shape functions; q quadratic, l linear, a prime is a derivative.

    Attributes
    ----------
    nodes : (n,) array
        Of the quadratic functions, in order.
    mass, stiffness, slope : (n, n) arrays
        Of q q, q' q' and q' q, the row's function first.
    pressure_mass : (m, m) array
        Of l l.
    mixed, divergence : (m, n) arrays
        Of l q and l q'.
    """

    nodes: Floats
    mass: Floats
    stiffness: Floats
    slope: Floats
    pressure_mass: Floats
    mixed: Floats
    divergence: Floats

    @classmethod
    def along(cls, vertices: Floats) -> "Line":
        """Elements between the vertices."""
        fem = scikit_fem()
        mesh = fem.MeshLine(vertices)
        fine = fem.Basis(mesh, fem.ElementLineP2(), intorder=4)
        coarse = fem.Basis(mesh, fem.ElementLineP1(), intorder=4)
        sort, sort_coarse = np.argsort(fine.doflocs[0]), np.argsort(coarse.doflocs[0])

        value = fem.BilinearForm(lambda u, v, w: u * v)
        both = fem.BilinearForm(lambda u, v, w: u.grad[0] * v.grad[0])
        row = fem.BilinearForm(lambda u, v, w: u * v.grad[0])
        column = fem.BilinearForm(lambda u, v, w: u.grad[0] * v)

        def dense(form: Any, trial: Any, test: Any, rows: Ints, columns: Ints) -> Floats:
            return np.asarray(form.assemble(trial, test).toarray()[np.ix_(rows, columns)])

        return cls(
            nodes=fine.doflocs[0][sort],
            mass=dense(value, fine, fine, sort, sort),
            stiffness=dense(both, fine, fine, sort, sort),
            slope=dense(row, fine, fine, sort, sort),
            pressure_mass=dense(value, coarse, coarse, sort_coarse, sort_coarse),
            mixed=dense(value, fine, coarse, sort_coarse, sort),
            divergence=dense(column, fine, coarse, sort_coarse, sort),
        )

    def modes(self, free: slice) -> tuple[Floats, Floats]:
        """Eigenvectors (n, k), zero where held, and eigenvalues (k,) of stiffness over mass."""
        from scipy.linalg import eigh

        values, vectors = eigh(self.stiffness[free, free], self.mass[free, free])
        whole = np.zeros((len(self.nodes), len(values)))
        whole[free] = vectors
        return whole, values

    def interpolation(self, at: Floats) -> Floats:
        """Weights (N, n) of the nodes at places (N,), zero outside."""
        corners = self.nodes[::2]
        element = np.clip(np.searchsorted(corners, at, "right") - 1, 0, len(corners) - 2)
        place = (at - corners[element]) / (corners[element + 1] - corners[element])
        weights = np.zeros((len(at), len(self.nodes)))
        rows = np.arange(len(at))[:, None]
        weights[rows, 2 * element[:, None] + np.arange(3)] = shapes(place)
        weights[(at < corners[0] - 1e-12) | (at > corners[-1] + 1e-12)] = 0.0
        return weights
