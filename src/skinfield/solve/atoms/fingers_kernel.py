"""Number of fingers by discriminant analysis of a touched area, compiled.

Where a skin reads unlike its model, neither evidence nor hills say how many fingers touch: one is
often two hills, and two side by side are one. The touched area does: how large and how long it is,
how far it spreads across and along, in how many islands. The logarithms of these five figures
are normal for a number of fingers in a pose, laid down or on their tips; the number is the one of
the highest posterior (mixture discriminant analysis: Hastie and Tibshirani 1996, Journal of the
Royal Statistical Society B 58, 155-176). `fingers.csv` holds what was learnt, in mm; an area that
is unlike all of them is no hand's. Areas far from each other are counted each by itself.
"""

from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from skinfield.compiled import inner
from skinfield.errors import Floats, Ints

FIGURES = 5  # area, islands, deviation across and along, length
TABLE = Path(__file__).parent / "fingers.csv"  # made by benchmarks/learn_fingers.py
HANDS_APART = 0.06  # m, between touched taxels: those of one hand are nearer
ISLANDS_APART = 1.5  # distances of taxels
UNLIKE = 20.5  # square of the distance from a class, in deviations: one hand in 1,000 is further


class FingerClasses(NamedTuple):
    """Normal distributions of the figures' logarithms, and what figures take.

    Attributes
    ----------
    fingers : (C,) int array
        Of each class.
    means : (C, FIGURES) array
    factors : (C, FIGURES, FIGURES) array
        By which differences from the mean have unit covariance.
    offsets : (C,) array
        Logarithm of the density at the mean, but for what all share.
    unit : float, mm
        Of places.
    pitch : float
        Distance of taxels, in units of places.
    figures : (FIGURES,) array
    parts : (2, most) int array
        Hand and island of each touched taxel.
    """

    fingers: Ints
    means: Floats
    factors: Floats
    offsets: Floats
    unit: float
    pitch: float
    figures: Floats
    parts: Ints

    @classmethod
    def of(cls, unit: float, pitch: float, most: int) -> "FingerClasses":
        """For touched taxels, `most` of them, at places in a unit, mm."""
        figures, parts = np.zeros(FIGURES), np.zeros((2, most), np.int64)
        return cls(*learnt_classes(), unit, pitch, figures, parts)


@lru_cache(1)
def learnt_classes() -> tuple[Ints, Floats, Floats, Floats]:
    """Fingers, means, factors and offsets of the classes in `fingers.csv`.

    A row of it is the number of fingers, means, and the covariance, of logarithms of figures in mm.
    """
    table = np.loadtxt(TABLE, delimiter=",", ndmin=2)
    fingers, means = table[:, 0].astype(np.int64), table[:, 1 : 1 + FIGURES].copy()
    roots = np.linalg.cholesky(table[:, 1 + FIGURES :].reshape(-1, FIGURES, FIGURES))
    offsets = -np.log(np.diagonal(roots, axis1=1, axis2=2)).sum(axis=1)
    return fingers, means, np.linalg.inv(roots), offsets


@inner
def number_parts(places: Floats, taxels: Ints, count: int, apart: float, parts: Ints) -> int:
    """Number the parts of touched taxels that are further than `apart` from each other."""
    found = 0
    for n in range(count):
        parts[n] = -1
    for first in range(count):
        if parts[first] >= 0:
            continue
        parts[first], grown = found, True
        while grown:
            grown = False
            for n in range(first, count):
                for k in range(count):
                    if parts[n] != found or parts[k] >= 0:
                        continue
                    x, y = places[taxels[n]] - places[taxels[k]]
                    if x * x + y * y < apart * apart:
                        parts[k], grown = found, True
        found += 1
    return found


@inner
def measure_hand(
    places: Floats, readings: Floats, offset: float, taxels: Ints, count: int, hand: int,
    known: FingerClasses,
) -> int:  # fmt: skip
    """Write the logarithms of the figures of one hand's touched taxels; how many it touches.

    Deviations are of the places, weighted by what is read there.
    """
    hands, islands, figures = known.parts[0], known.parts[1], known.figures
    touched, seen, weight, x, y = 0, 0, 0.0, 0.0, 0.0
    xx, yy, xy, longest = 0.0, 0.0, 0.0, 0.0
    for n in range(count):
        if hands[n] != hand:
            continue
        touched += 1
        value, place = readings[taxels[n]] - offset, places[taxels[n]]
        weight, x, y = weight + value, x + value * place[0], y + value * place[1]
        is_new = True
        for k in range(count):
            if hands[k] == hand:
                other = places[taxels[k]]
                square = (place[0] - other[0]) ** 2 + (place[1] - other[1]) ** 2
                longest = max(longest, square)
                is_new &= k >= n or islands[k] != islands[n]
        seen += is_new
    x, y = x / weight, y / weight
    for n in range(count):
        if hands[n] == hand:
            value, place = (readings[taxels[n]] - offset) / weight, places[taxels[n]]
            xx += value * (place[0] - x) ** 2
            yy += value * (place[1] - y) ** 2
            xy += value * (place[0] - x) * (place[1] - y)
    half, middle = np.hypot(0.5 * (xx - yy), xy), 0.5 * (xx + yy)
    own, unit = known.pitch**2 / 12.0, known.unit  # a taxel is as wide as the pitch
    figures[0] = np.log(touched * 0.866 * (unit * known.pitch) ** 2)
    figures[1] = np.log(float(seen))
    figures[2] = np.log(unit * np.sqrt(max(middle - half, 0.0) + own))
    figures[3] = np.log(unit * np.sqrt(middle + half + own))
    figures[4] = np.log(unit * (np.sqrt(longest) + known.pitch))
    return touched


@inner
def classify(known: FingerClasses) -> int:
    """Fingers of the highest posterior by `figures`, 0 where no class is like them."""
    best, number, near = -np.inf, 0, np.inf
    for c in range(len(known.fingers)):
        square = 0.0
        for i in range(FIGURES):
            value = 0.0
            for j in range(i + 1):
                value += known.factors[c, i, j] * (known.figures[j] - known.means[c, j])
            square += value * value
        density = known.offsets[c] - 0.5 * square
        near = min(near, square)
        if density > best:
            best, number = density, known.fingers[c]
    return number if near < UNLIKE else 0


@inner
def count_fingers(
    places: Floats, readings: Floats, offset: float, taxels: Ints, count: int, known: FingerClasses
) -> int:
    """How many fingers touch; 0 where that is not as hands touch.

    A lone taxel far from a hand jumped, as taxels do.

    Parameters
    ----------
    places : (L, 2) array
    readings : (L,) array
    offset : float
        That all taxels share.
    taxels : (count or more,) int array
        Those that are touched.
    """
    apart = 1e3 * HANDS_APART / known.unit
    hands, total = number_parts(places, taxels, count, apart, known.parts[0]), 0
    number_parts(places, taxels, count, ISLANDS_APART * known.pitch, known.parts[1])
    for hand in range(hands):
        if measure_hand(places, readings, offset, taxels, count, hand, known) == 1 < hands:
            continue
        fingers = classify(known)
        if fingers == 0:
            return 0
        total += fingers
    return total
