"""Kalman filter of contacts and the gains of their assignment, compiled."""

import numpy as np

from skinfield.compiled import inner, njit
from skinfield.errors import Floats


@njit
def predict(mean: Floats, covariance: Floats, step: float, pushes: Floats) -> None:
    """Carry a state (6,) and its covariance on by `step` s, in place.

    Three numbers and their three rates, driven by white noise of intensity `pushes` (3,).
    """
    for i in range(3):
        mean[i] += step * mean[i + 3]
        for j in range(3):
            covariance[i, j] += step * (covariance[i, j + 3] + covariance[i + 3, j])
            covariance[i, j] += step * step * covariance[i + 3, j + 3]
    for i in range(3):
        for j in range(3):
            covariance[i, j + 3] += step * covariance[i + 3, j + 3]
            covariance[j + 3, i] = covariance[i, j + 3]
    for i in range(3):
        covariance[i, i] += pushes[i] * step**3 / 3
        covariance[i, i + 3] += pushes[i] * step**2 / 2
        covariance[i + 3, i] += pushes[i] * step**2 / 2
        covariance[i + 3, i + 3] += pushes[i] * step


@inner
def inverse_of(s: Floats) -> Floats:
    """Of a symmetric 3 x 3 matrix by cofactors, scaled to a unit diagonal first."""
    scale = 1.0 / np.sqrt(np.array([s[0, 0], s[1, 1], s[2, 2]]))
    a = s[0, 1] * scale[0] * scale[1]
    b = s[0, 2] * scale[0] * scale[2]
    c = s[1, 2] * scale[1] * scale[2]
    volume = 1.0 + 2.0 * a * b * c - a * a - b * b - c * c
    out = np.empty((3, 3))
    out[0, 0], out[1, 1], out[2, 2] = 1.0 - c * c, 1.0 - b * b, 1.0 - a * a
    out[0, 1] = out[1, 0] = b * c - a
    out[0, 2] = out[2, 0] = a * c - b
    out[1, 2] = out[2, 1] = a * b - c
    for i in range(3):
        for j in range(3):
            out[i, j] *= scale[i] * scale[j] / volume
    return out


@inner
def squared_distance(off: Floats, precision: Floats) -> float:
    """Mahalanobis's, of an offset (3,)."""
    total = 0.0
    for i in range(3):
        for j in range(3):
            total += off[i] * precision[i, j] * off[j]
    return total


@inner
def correct(mean: Floats, covariance: Floats, seen: Floats, noise: Floats) -> None:
    """Take up what is seen (3,) with covariance `noise` (3, 3), in place."""
    precision = inverse_of(covariance[:3, :3] + noise)
    cross = covariance[:, :3].copy()
    gain = cross @ precision
    mean += gain @ (seen - mean[:3])
    for i in range(6):
        for j in range(i + 1):
            for k in range(3):
                covariance[i, j] -= gain[i, k] * cross[j, k]
            covariance[j, i] = covariance[i, j]


@njit
def update(
    mean: Floats,
    covariance: Floats,
    seen: Floats,
    noise: Floats,
    step: float,
    rates: Floats,
    surprise: float,
) -> bool:
    """`correct`, but where what is seen is a surprise, the rates may have changed at once.

    They did so at the last reading, `step` s ago, by variances `rates` (3,); returns whether.
    """
    precision = inverse_of(covariance[:3, :3] + noise)
    onset = squared_distance(seen - mean[:3], precision) > surprise
    if onset:
        for i in range(3):
            covariance[i, i] += step * step * rates[i]
            covariance[i, i + 3] += step * rates[i]
            covariance[i + 3, i] += step * rates[i]
            covariance[i + 3, i + 3] += rates[i]
    correct(mean, covariance, seen, noise)
    return onset


@njit
def gains(
    mean: Floats,
    covariance: Floats,
    handicap: Floats,
    seen: Floats,
    noise: Floats,
    limits: tuple[float, float, float, float, float],
) -> Floats:
    """What each pair of a track (N) and a contact (M) is worth, (N, M); 0 outside of the gate.

    `limits`: most squared distance of the place, floor of its variance, reach, most that the force
    adds to the cost, and what a pair without any cost is worth.
    """
    gate, floor, reach, force_says, worth = limits
    gain = np.zeros((len(mean), len(seen)))
    for i in range(len(mean)):
        for j in range(len(seen)):
            x, y = seen[j, 0] - mean[i, 0], seen[j, 1] - mean[i, 1]
            if x * x + y * y > reach * reach:
                continue
            a = covariance[i, 0, 0] + noise[j, 0, 0] + floor
            b = covariance[i, 0, 1] + noise[j, 0, 1]
            c = covariance[i, 1, 1] + noise[j, 1, 1] + floor
            area = a * c - b * b
            distance = (c * x * x - 2 * b * x * y + a * y * y) / area
            if distance > gate:
                continue
            force = seen[j, 2] - mean[i, 2]
            force *= force / (covariance[i, 2, 2] + noise[j, 2, 2])
            cost = distance + np.log(area / floor**2) + min(force, force_says) + handicap[i]
            gain[i, j] = max(worth - cost, 0.0)
    return gain
