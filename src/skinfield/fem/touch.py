"""Touch at large strain: nodes that slide along a body, and the equations that hold them to it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bmat, coo_matrix, csc_matrix

from skinfield.errors import Floats, Ints
from skinfield.fem.section import Section
from skinfield.fem.shape import SmoothShape

STIFFNESS = 10.0  # moduli per thickness: weighs a gap against a pressure in the choice of touch


@dataclass(frozen=True, eq=False)
class Touch:
    """Where the surface is, seen from the body, at one state.

    A node is at radius R + u_r and below the body by g = H(R + u_r) - depth - u_z. The body pushes
    with forces -f dg/du: downwards and, on a flank, outwards; it is frictionless.

    Attributes
    ----------
    section : Section
    gap, slope, curvature : (nodes,) arrays
        g, H' and H'' at the nodes.
    """

    section: Section
    gap: Floats
    slope: Floats
    curvature: Floats

    @classmethod
    def of(cls, section: Section, shape: SmoothShape, state: Floats, depth: float) -> "Touch":
        """Look at the surface."""
        radius = section.trace.nodes + state[section.top_r]
        height, slope, curvature = shape.derivatives(radius)
        return cls(section, height - depth - state[section.top_z], slope, curvature)

    def chosen(self, forces: Floats) -> NDArray[np.bool_]:
        """Nodes (nodes,) that touch: pressed more than they are away, or too deep."""
        areas = self.section.trace.mass.sum(axis=1)
        touching = forces > STIFFNESS * self.gap * areas
        touching[0] = touching[1]  # the axis has no area, so its force tells nothing
        touching[-1] = False
        return np.asarray(touching)

    def pushes(self, forces: Floats) -> Floats:
        """Derivative of the body's potential by the unknowns, (unknowns,)."""
        total = np.zeros(self.section.unknowns)
        total[self.section.top_r] = -forces * self.slope
        total[self.section.top_z] = forces
        return total

    def directions(self, touching: Ints) -> csc_matrix:
        """Derivatives -dg/du of the nodes that touch, (unknowns, n)."""
        count = np.arange(len(touching))
        rows = np.concatenate([self.section.top_r[touching], self.section.top_z[touching]])
        values = np.concatenate([-self.slope[touching], np.ones(len(touching))])
        size = (self.section.unknowns, len(touching))
        return csc_matrix(coo_matrix((values, (rows, np.tile(count, 2))), shape=size))

    def bending(self, forces: Floats) -> csc_matrix:
        """What the body's curvature adds to the stiffness."""
        where, n = self.section.top_r, self.section.unknowns
        return csc_matrix(coo_matrix((-forces * self.curvature, (where, where)), shape=(n, n)))


def bordered(stiffness: Any, directions: Any, force: float | None) -> csc_matrix:
    """Equations of displacements, forces and, where the total force is given, depth."""
    n = directions.shape[1]
    if force is None:
        return csc_matrix(bmat([[stiffness, directions], [directions.T, None]]))
    ones = csc_matrix(np.ones((n, 1)))
    rows = [[stiffness, directions, None], [directions.T, None, ones], [None, ones.T, None]]
    return csc_matrix(bmat(rows))
