"""The developed surface of a patch: a flat picture of the skin in metres, and the way back."""

from typing import Protocol

import numpy as np

from skinfield.errors import Floats

OFF_PLANE = 0.01  # of the extent: taxels farther from their plane than this make a curved patch
TILT = np.cos(np.radians(2.0))  # and so do normals that lean more than this


class Surface(Protocol):
    """What a patch's surface offers: taxels in a plane, and points of the plane back in 3D."""

    @property
    def plane(self) -> Floats:
        """Taxel centres in the developed plane, (L, 2) m; seen from outside, x right and y up."""
        ...

    @property
    def is_flat(self) -> bool:
        """Whether the taxels lie in one plane and the way back is a rigid motion."""
        ...

    @property
    def distortion(self) -> float:
        """How far lengths in the plane are from those on the skin, as a part of 1.

        The 99th percentile of abs(length in the plane / length on the skin - 1) over neighbouring
        taxels; 0 where the patch is flat.
        """
        ...

    @property
    def severed(self) -> int:
        """Pairs of neighbouring taxels that lie apart in the plane, because it had to be cut."""
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
    distortion = 0.0
    severed = 0

    def __init__(self, plane: Floats, origin: Floats, frame: Floats) -> None:
        self.plane, self.origin, self.frame = plane, origin, frame

    def position_from_plane(self, plane: Floats) -> Floats:
        """See `Surface.position_from_plane`."""
        return np.asarray(self.origin + plane @ self.frame[:, :2].T, dtype=np.float64)

    def frame_from_plane(self, plane: Floats) -> Floats:
        """See `Surface.frame_from_plane`."""
        return np.broadcast_to(self.frame, (len(plane), 3, 3))


def flat_frames(normals: Floats) -> Floats:
    """Right-handed frames (N, 3, 3) whose third columns are `normals`; the identity for +z.

    The first axis is the patch's x axis laid into the plane (its y axis where x is the normal), so
    that a flat patch keeps its own coordinates.
    """
    helper = np.where(np.abs(normals[:, :1]) < 0.9, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    first = helper - normals * np.einsum("ni,ni->n", helper, normals)[:, None]
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normals, first), normals], axis=2)


def flat_frame(normal: Floats) -> Floats:
    """One of `flat_frames`, (3, 3)."""
    return np.asarray(flat_frames(normal[None])[0])


def mean_normal(normals: Floats) -> Floats:
    """Unit mean (3,) of unit normals (N, 3); the first of them where they cancel out."""
    mean = np.asarray(normals.mean(axis=0))
    length = float(np.linalg.norm(mean))
    return mean / length if length > 1e-6 else np.asarray(normals[0], dtype=np.float64)


def surface_through(positions: Floats, normals: Floats) -> Surface:
    """Surface through taxels (L, 3) m with outward unit normals (L, 3).

    Flat when the taxels lie within 1 % of their extent of one plane and no normal leans more than
    2° from it, or when they lie on one line; else developed.
    """
    normal = _plane_normal(positions, mean_normal(normals))
    centre = positions.mean(axis=0)
    spread = float(np.linalg.norm(np.ptp(positions, axis=0)))
    off_plane = float(np.abs((positions - centre) @ normal).max())
    curved = off_plane > OFF_PLANE * spread or float((normals @ normal).min()) < TILT
    if curved and not _is_line(positions - centre, spread):
        from skinfield.layout.develop import develop

        return develop(positions, normals)
    frame = flat_frame(normal)
    origin = float(centre @ normal) * normal
    plane = (positions - origin) @ frame[:, :2]
    plane.setflags(write=False)
    return FlatSurface(plane, origin, frame)


def _is_line(centred: Floats, spread: float) -> bool:
    if len(centred) < 3 or spread < 2e-7:
        return True
    return float(np.linalg.svd(centred, compute_uv=False)[1]) < 1e-6 * spread


def _plane_normal(positions: Floats, outward: Floats) -> Floats:
    """Unit normal (3,) of the best plane through positions (L, 3), on the side of `outward`.

    Of the planes through a line, the one that faces `outward`; exactly `outward` where the
    positions allow it, so that a flat patch keeps the axes it was given.
    """
    centred = positions - positions.mean(axis=0)
    _, extent, axes = np.linalg.svd(centred, full_matrices=True)
    extent = np.pad(extent, (0, 3 - len(extent)))
    if extent[0] < 1e-9 or np.abs(centred @ outward).max() <= 1e-9 * extent[0]:
        return outward
    if extent[1] < 1e-6 * extent[0]:
        across = outward - axes[0] * (axes[0] @ outward)
        if np.linalg.norm(across) < 1e-6:  # the line runs along its own normal: any side will do
            across = flat_frame(axes[0])[:, 0]
        return np.asarray(across / np.linalg.norm(across))
    return np.asarray(axes[2] if axes[2] @ outward >= 0 else -axes[2])
