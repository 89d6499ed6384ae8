"""Inside or outside of the convex hull of the taxels."""

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats


def spans_plane(points: Floats) -> bool:
    """Whether points (M, 2) have an area: three or more, not on one line to 1e-6 of its length."""
    if len(points) < 3:
        return False
    extent = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(extent[1] > max(1e-6 * extent[0], 1e-9))


def inside_hull(points: Floats, queries: Floats) -> NDArray[np.bool_]:
    """Whether each query (N, 2) lies in the convex hull of `points` (M, 2), border included.

    Fewer than three points, or points on one line, have an empty hull.
    """
    from scipy.spatial import ConvexHull

    if not spans_plane(points):
        return np.zeros(len(queries), dtype=np.bool_)
    centre = points.mean(axis=0)
    extent = np.abs(points - centre).max()
    sides = ConvexHull(points - centre).equations  # outward normal and offset of each side
    inside = (queries - centre) @ sides[:, :2].T + sides[:, 2] <= 1e-9 * extent
    return np.asarray(inside.all(axis=1))
