"""Arrays that rendering writes into, made once."""

import numpy as np

from skinfield.inverse.atoms.render_kernels import COUNT, Mesh
from skinfield.inverse.atoms.render_std import SIZE
from skinfield.inverse.atoms.render_tables import TERMS


class Workspace:
    """Scratch of one renderer; it grows with the largest atom, and is for one thread.

    Parameters
    ----------
    nodes : int
        K of the grid.
    """

    def __init__(self, nodes: int) -> None:
        self.pictures = np.zeros((2, nodes))
        self.first = np.zeros(nodes)
        self.boxes = np.zeros((2, 4), dtype=np.int64)
        self.cells = np.empty(1024)
        self.room = np.empty(2 * TERMS)
        self.terms = np.empty((2, COUNT))
        self.small = np.empty((SIZE + 2, SIZE))

    def make_room(self, mesh: Mesh, extent: float) -> None:
        """See that the cells of an atom fit that reaches `extent` m from its middle."""
        side = int(2.0 * extent / mesh.pitch) + 3
        if side * side > len(self.cells):
            self.cells = np.empty(2 * side * side)
