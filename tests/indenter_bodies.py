"""Surfaces of the indenters as points and triangles, from their sizes alone."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
TURN = np.linspace(0.0, 2 * np.pi, 721)[:-1]
FILLET = np.linspace(0.0, np.pi / 2, 61)
HIGH = 20e-3  # how far up the walls go, m


def turned(radius: Floats, height: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Points and triangles of a surface of revolution about z from its meridian."""
    circle, around = np.stack([np.cos(TURN), np.sin(TURN)], axis=1), len(TURN)
    rings = [np.column_stack([r * circle, np.full(around, z)])
             for r, z in zip(radius, height, strict=True)]  # fmt: skip
    ring, step = np.meshgrid(np.arange(len(rings) - 1), np.arange(around), indexing="ij")
    a, b = ring * around + step, ring * around + (step + 1) % around
    quads = np.stack([a, b, b + around, a + around], axis=-1).reshape(-1, 4)
    return np.vstack(rings), np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def filleted(half_width: float, edge: float, slope: float = 0.0) -> tuple:
    """A cylinder, or a cone of a slope, with edges of a radius, up to its wall."""
    core = half_width - edge
    if not slope:
        r = core + edge * np.sin(FILLET)
        z = edge - edge * np.cos(FILLET)
        return turned(np.r_[0.0, r, half_width], np.r_[0.0, z, HIGH])
    flank = np.arctan(slope)  # from the plane
    nose = np.linspace(0.0, flank, 61)
    shoulder = np.linspace(flank, np.pi / 2, 61)
    r = np.concatenate([edge * np.sin(nose), core + edge * np.sin(shoulder), [half_width]])
    z = np.concatenate([edge - edge * np.cos(nose),
                        edge + slope * core - edge * np.cos(shoulder), [HIGH]])  # fmt: skip
    return turned(r, z)


def hull(points: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Triangles of the convex hull."""
    from scipy.spatial import ConvexHull

    return points, ConvexHull(points).simplices.astype(np.int64)


def swept_ring(inner: float, outer: float, edge: float) -> tuple[Floats, NDArray[np.int64]]:
    """Triangles of a tube's end: inner wall, fillets, face, outer wall."""
    r = np.concatenate([[inner], (inner + edge - edge * np.sin(FILLET))[::-1],
                        outer - edge + edge * np.sin(FILLET), [outer]])  # fmt: skip
    z = np.concatenate([[HIGH], (edge - edge * np.cos(FILLET))[::-1],
                        edge - edge * np.cos(FILLET), [HIGH]])  # fmt: skip
    return turned(r, z)


def rounded_box_points(length: float, width: float, edge: float) -> Floats:
    """Corners of a bar's face with edges of a radius, and of its top."""
    polar, turn = np.meshgrid(np.linspace(0, np.pi / 2, 25), np.linspace(0, np.pi / 2, 25))
    x = length / 2 - edge + edge * np.sin(polar) * np.cos(turn)
    y = width / 2 - edge + edge * np.sin(polar) * np.sin(turn)
    z = edge - edge * np.cos(polar)
    corner = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    corner = np.vstack([corner, corner * [1, 1, 0] + [0, 0, HIGH]])
    return np.vstack([corner * [a, b, 1] for a in (1, -1) for b in (1, -1)])


def lying_rod(radius: float, length: float, edge: float) -> tuple[Floats, NDArray[np.int64]]:
    """A cylinder with filleted ends, turned about its axis."""
    along = np.append(length / 2 - edge + edge * np.sin(FILLET), length / 2)
    around = np.append(radius - edge + edge * np.cos(FILLET), 0.0)
    standing, faces = turned(np.r_[around[::-1], around], np.r_[-along[::-1], along])
    return standing[:, [2, 0, 1]] + [0.0, 0.0, radius], faces


def wedge_points(half_angle: float, length: float, width: float) -> Floats:
    """A sharp wedge with walls above its shoulders."""
    shoulder = width / 2 / np.tan(half_angle)
    profile = [(0.0, 0.0), (width / 2, shoulder), (-width / 2, shoulder),
               (width / 2, HIGH), (-width / 2, HIGH)]  # fmt: skip
    return np.array([(s * length / 2, y, z) for s in (1, -1) for y, z in profile])
