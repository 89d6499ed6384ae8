"""From points on a skin back to its developed plane."""

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.layout import Grid

CLOSE, MOST = 1e-8, 50  # m: a step that ends the search; and steps after which it has failed


class Chart:
    """Ways between a patch's surface and its developed plane.

    Parameters
    ----------
    grid : Grid
        Whose nodes are where a search on a curved surface starts.
    """

    def __init__(self, grid: Grid) -> None:
        from scipy.spatial import cKDTree

        self.patch, self.surface = grid.patch, grid.patch.surface
        self._plane = grid.plane
        zero = np.zeros((1, 2))
        self._flat = bool(self.surface.is_flat)
        self._origin = self.surface.position_from_plane(zero)[0]
        self._axes = self.surface.frame_from_plane(zero)[0][:, :2]
        self._nodes = None if self._flat else cKDTree(grid.positions)

    def plane_from_position(self, positions: Floats) -> Floats:
        """Points (N, 3) m of the surface in its plane, (N, 2) m.

        On a curved surface by Newton's method with the tangents, which are orthonormal while the
        plane is true to lengths up to the surface's `distortion`: so the error shrinks by this
        factor per step.

        Raises
        ------
        InputError
            If a point is so far from the surface that none of it is the nearest.
        """
        if self._nodes is None:
            return np.asarray((positions - self._origin) @ self._axes)
        plane = self._plane[self._nodes.query(positions)[1]]
        for _ in range(MOST):
            off = positions - self.surface.position_from_plane(plane)
            tangents = self.surface.frame_from_plane(plane)[:, :, :2]
            step = np.einsum("nij,ni->nj", tangents, off)
            plane = plane + step
            if np.abs(step).max(initial=0.0) < CLOSE:
                return np.asarray(plane)
        worst = int(np.abs(step).max(axis=1).argmax())
        raise InputError(
            f"a contact's position is {positions[worst]} m, expected a point of the patch's "
            "surface: take contacts of the same patch as the grid"
        )
