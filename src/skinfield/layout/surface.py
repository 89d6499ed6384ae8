"""The developed surface of a patch: a flat picture of the skin in metres, and the way back."""

from typing import Protocol

import numpy as np

from skinfield.errors import Floats


class Surface(Protocol):
    """What a patch's surface offers: taxels in a plane, and points of the plane back in 3D."""

    @property
    def plane(self) -> Floats:
        """Taxel centres in the developed plane, (L, 2) m."""
        ...

    @property
    def is_flat(self) -> bool:
        """Whether the taxels lie in one plane and the way back is a rigid motion."""
        ...

    def position_from_plane(self, plane: Floats) -> Floats:
        """Points of the developed plane (N, 2) m, as points in the patch's frame (N, 3) m."""
        ...

    def frame_from_plane(self, plane: Floats) -> Floats:
        """Local frames (N, 3, 3) at points of the plane (N, 2) m: columns tangent, tangent, normal.

        The tangents are the images of the plane's two axes, orthonormalised; the normal points
        out of the skin; right-handed.
        """
        ...


class FlatSurface:
    """A rigid plane: an orthonormal frame and an origin."""

    is_flat = True

    def __init__(self, plane: Floats, origin: Floats, frame: Floats) -> None:
        self.plane, self.origin, self.frame = plane, origin, frame

    def position_from_plane(self, plane: Floats) -> Floats:
        """See `Surface.position_from_plane`."""
        return np.asarray(self.origin + plane @ self.frame[:, :2].T, dtype=np.float64)

    def frame_from_plane(self, plane: Floats) -> Floats:
        """See `Surface.frame_from_plane`."""
        return np.broadcast_to(self.frame, (len(plane), 3, 3))


def flat_frame(normal: Floats) -> Floats:
    """Right-handed frame (3, 3) whose third column is `normal`; the identity for +z.

    The first axis is the patch's x axis laid into the plane (its y axis where x is the normal), so
    that a flat patch keeps its own coordinates.
    """
    helper = np.eye(3)[0] if abs(normal[0]) < 0.9 else np.eye(3)[1]
    first = helper - normal * (helper @ normal)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(normal, first), normal])


def surface_through(positions: Floats, normals: Floats) -> Surface:
    """Surface through taxels (L, 3) m with outward normals (L, 3).

    Flat when the taxels lie within 1 % of their extent of one plane; else developed.
    """
    mean = normals.mean(axis=0)
    if np.linalg.norm(mean) < 1e-6:
        mean = normals[0]
    centre = positions.mean(axis=0)
    _, extent, axes = np.linalg.svd(positions - centre, full_matrices=True)
    normal = mean / np.linalg.norm(mean)
    spread = np.linalg.norm(np.ptp(positions, axis=0))
    if len(positions) >= 3 and len(extent) == 3 and extent[1] > 1e-9:
        candidate = axes[2] * (1.0 if axes[2] @ normal >= 0 else -1.0)
        off_plane = np.abs((positions - centre) @ candidate).max()
        if off_plane <= 0.01 * spread:
            normal = candidate if candidate @ normal < 1 - 1e-12 else normal
        else:
            from skinfield.layout.develop import develop

            return develop(positions, normals)
    frame = flat_frame(normal)
    height = float(centre @ normal)
    origin = height * normal
    return FlatSurface((positions - origin) @ frame[:, :2], origin, frame)
