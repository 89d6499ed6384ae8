"""What rings of point loads do, compiled."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from skinfield.errors import Floats, Ints
from skinfield.inverse.atoms.compiled import inner


class Point(NamedTuple):
    """Response to a point load, as cubics between nodes in two even meshes.

    `mesh` (M,) m, the first `near` of them `near_step` apart, the others `far_step`; `cubics`
    (M - 1, 4), of the distance from the node before, the highest power first.
    """

    mesh: Floats
    cubics: Floats
    near_step: float
    far_step: float
    near: int


@inner
def _response(distance: float, point: Point) -> float:
    """At a distance in m; the last cubic goes on beyond the mesh."""
    border = point.mesh[point.near]
    if distance < border:
        at = int(distance / point.near_step)
    else:
        at = point.near + int((distance - border) / point.far_step)
    at = min(at, len(point.cubics) - 1)
    x = distance - point.mesh[at]
    c = point.cubics[at]
    return float(((c[0] * x + c[1]) * x + c[2]) * x + c[3])


@njit(cache=True, nogil=True)
def ring_sums(r: Floats, radii: Floats, forces: Floats, counts: Ints, point: Point) -> Floats:
    """Response (N,) at distances `r` (N,) m from the axis of rings (M,) that bear `forces`.

    A ring stands for as many point loads on half of it as `counts` says.
    """
    out = np.zeros(len(r))
    for m in range(len(radii)):
        ring, count = radii[m], counts[m]
        cosine = np.empty(count)
        for k in range(count):
            cosine[k] = math.cos((k + 0.5) * math.pi / count)
        for n in range(len(r)):
            total = 0.0
            for k in range(count):
                square = r[n] * r[n] + ring * ring - 2.0 * ring * r[n] * cosine[k]
                total += _response(math.sqrt(max(square, 0.0)), point)
            out[n] += forces[m] * total / count
    return out
