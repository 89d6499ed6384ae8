"""Mahalanobis distance of places and forces, and the chance of a larger one, compiled."""

import math
from typing import Any

import numpy as np

from skinfield.compiled import inner

Three = tuple[float, float, float]
Parts = tuple[float, float, float, float, float, float]


@inner
def factors(one: Any, other: Any, floor: float, force: float) -> Parts:
    """Sum of two covariances, and of two variances, as L D L': roots of D, and L's 10, 20, 21."""
    own, its = one.covariance, other.covariance
    first = own[0, 0] + its[0, 0] + floor
    xy, xf = own[0, 1] + its[0, 1], own[0, 2] + its[0, 2]
    a, b = xy / first, xf / first
    second = own[1, 1] + its[1, 1] + floor - a * xy
    yf = own[1, 2] + its[1, 2] - a * xf
    c = yf / second
    third = own[2, 2] + its[2, 2] + force - b * xf - c * yf
    return np.sqrt(first), np.sqrt(second), np.sqrt(third), a, b, c


@inner
def whitened(parts: Parts, off: Three) -> Three:
    """Three numbers in units of their deviations, see `factors`."""
    second = off[1] - parts[3] * off[0]
    third = off[2] - parts[4] * off[0] - parts[5] * second
    return off[0] / parts[0], second / parts[1], third / parts[2]


@inner
def square(parts: Parts, off: Three) -> float:
    """Squared Mahalanobis distance."""
    first, second, third = whitened(parts, off)
    return first * first + second * second + third * third


@inner
def chance_beyond(square: float) -> float:
    """Chance of a larger squared Mahalanobis distance of three numbers, by chi-squared."""
    root = math.sqrt(0.5 * square)
    return math.erfc(root) + 2.0 / math.sqrt(math.pi) * root * math.exp(-0.5 * square)
