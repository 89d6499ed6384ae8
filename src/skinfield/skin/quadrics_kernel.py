"""Blended quadrics at points of the plane, compiled: contacts ask for one place at a time.

`parts` are plane (M, 2), position and normal (M, 3), slope (M, 3, 2), bend (M, 3, 3) and turn
(M, 3, 2) of the taxels; see `Quadrics`.
"""

import math

import numpy as np

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints

TINY = 1e-12  # m
SHORT = 1e-6  # blended normals that nearly cancel have no direction


@njit
def places_and_frames(
    points: Floats, parts: tuple[Floats, ...], blended: int, flex: float
) -> tuple[Floats, Floats]:
    """Points (N, 3) m in space, and there tangent, tangent and outward normal (N, 3, 3) as columns.

    Quadrics bend up to `flex` m from their taxel.
    """
    plane, place, normals, slope, bend, turn = parts
    rows, weights = np.empty(blended + 1, np.int64), np.empty(blended + 1)
    out, frames = np.zeros((len(points), 3)), np.zeros((len(points), 3, 3))
    for n in range(len(points)):
        mine = frames[n]
        count = weigh(points[n], plane, blended, rows, weights)
        for k in range(count):
            row, weight = rows[k], weights[k]
            x, y = points[n, 0] - plane[row, 0], points[n, 1] - plane[row, 1]
            part = bending_part(x, y, flex)
            u, v = x * part, y * part
            for i in range(3):
                along_x = slope[row, i, 0] + bend[row, i, 0] * u + bend[row, i, 1] * v
                along_y = slope[row, i, 1] + bend[row, i, 1] * u + bend[row, i, 2] * v
                bent = bend[row, i, 0] * u * u + bend[row, i, 2] * v * v
                bent = 0.5 * bent + bend[row, i, 1] * u * v
                straight = along_x * (x - u) + along_y * (y - v)
                flat = slope[row, i, 0] * u + slope[row, i, 1] * v
                out[n, i] += weight * (place[row, i] + flat + bent + straight)
                mine[i, 0] += weight * along_x
                mine[i, 1] += weight * along_y
                mine[i, 2] += weight * (normals[row, i] + turn[row, i, 0] * u + turn[row, i, 1] * v)
        if not math.sqrt(mine[0, 2] ** 2 + mine[1, 2] ** 2 + mine[2, 2] ** 2) > SHORT:
            mine[:, 2] = normals[rows[0]]
        stand_upright(mine)
    return out, frames


@inner
def weigh(point: Floats, plane: Floats, blended: int, rows: Ints, weights: Floats) -> int:
    """Nearest taxels, the nearest first, and their Shepard weights; returns how many there are."""
    count, most = 0, min(blended + 1, len(plane))
    for row in range(len(plane)):  # `weights` are squared distances for now
        square = (point[0] - plane[row, 0]) ** 2 + (point[1] - plane[row, 1]) ** 2
        if count == most and square >= weights[count - 1]:
            continue
        count = min(count + 1, most)
        k = count - 1
        while k > 0 and weights[k - 1] > square:
            weights[k], rows[k] = weights[k - 1], rows[k - 1]
            k -= 1
        weights[k], rows[k] = square, row
    edge = math.sqrt(weights[count - 1]) * (1.0 if count > blended else 1.5) + TINY
    total = 0.0
    for k in range(count):
        distance = max(math.sqrt(weights[k]), TINY)
        weights[k] = (max(edge - distance, 0.0) / (edge * distance)) ** 2
        total += weights[k]
    for k in range(count):
        weights[k] /= total
    return count


@inner
def bending_part(x: float, y: float, flex: float) -> float:
    """Part of an offset over which a quadric bends."""
    return min(1.0, flex / max(math.sqrt(x * x + y * y), TINY))


@inner
def stand_upright(frame: Floats) -> None:
    """Make the tangents orthonormal about the normal, as near to what they are as can be.

    As `flat_frames`, turned by the angle at which the tangents stand in that frame.
    """
    n0, n1, n2 = frame[0, 2], frame[1, 2], frame[2, 2]
    length = math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    n0, n1, n2 = n0 / length, n1 / length, n2 / length
    along_x = 1.0 if abs(n0) < 0.9 else 0.0
    along_y = 1.0 - along_x
    lean = along_x * n0 + along_y * n1
    a0, a1, a2 = along_x - n0 * lean, along_y - n1 * lean, -n2 * lean
    length = math.sqrt(a0 * a0 + a1 * a1 + a2 * a2)
    a0, a1, a2 = a0 / length, a1 / length, a2 / length
    b0, b1, b2 = n1 * a2 - n2 * a1, n2 * a0 - n0 * a2, n0 * a1 - n1 * a0
    across = b0 * frame[0, 0] + b1 * frame[1, 0] + b2 * frame[2, 0]
    across -= a0 * frame[0, 1] + a1 * frame[1, 1] + a2 * frame[2, 1]
    along = a0 * frame[0, 0] + a1 * frame[1, 0] + a2 * frame[2, 0]
    along += b0 * frame[0, 1] + b1 * frame[1, 1] + b2 * frame[2, 1]
    angle = math.atan2(across, along)
    cosine, sine = math.cos(angle), math.sin(angle)
    a0, a1, a2 = cosine * a0 + sine * b0, cosine * a1 + sine * b1, cosine * a2 + sine * b2
    frame[0, 0], frame[1, 0], frame[2, 0] = a0, a1, a2
    frame[0, 1], frame[1, 1] = n1 * a2 - n2 * a1, n2 * a0 - n0 * a2
    frame[2, 1] = n0 * a1 - n1 * a0
    frame[0, 2], frame[1, 2], frame[2, 2] = n0, n1, n2
