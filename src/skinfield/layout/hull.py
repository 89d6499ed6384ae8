"""Inside or outside of the convex hull of the taxels."""

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats


def inside_hull(points: Floats, queries: Floats) -> NDArray[np.bool_]:
    """Whether each query (N, 2) lies in the convex hull of `points` (M, 2), border included.

    Fewer than three points, or points on one line, have an empty hull.
    """
    from scipy.spatial import ConvexHull

    centred = points - points.mean(axis=0)
    extent = np.abs(centred).max(initial=0.0)
    if len(points) < 3 or np.linalg.matrix_rank(centred, tol=1e-9 * max(extent, 1e-9)) < 2:
        return np.zeros(len(queries), dtype=np.bool_)
    sides = ConvexHull(points).equations  # outward normal and offset of each side
    inside = queries @ sides[:, :2].T + sides[:, 2] <= 1e-9 * extent + 1e-15
    return np.asarray(inside.all(axis=1))
