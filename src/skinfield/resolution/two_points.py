r"""The smallest distance at which two touches are told from one.

Two equal touches are taken for one where a single one of any place, force and size reads nearly
the same. Let :math:`\lambda` be the squared distance between the readings of the two and those of
the best single touch, in units of the noise. At the best fit the difference is at right angles to
everything a single touch can change, so the log-likelihood ratio of two touches against one is
chi-squared with two degrees of freedom (how far apart they are, and along which line), central if
there is one touch and with the noncentrality :math:`\lambda` if there are two (Wilks 1938; Kay,
Fundamentals of Statistical Signal Processing II, section 6.5). Both errors, two for one and one
for two, occur at the same rate where :math:`\lambda` is as large as that rate demands.
"""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, InputError, check_positive, check_range
from skinfield.resolution.design import Places, SkinDesign, Touch
from skinfield.resolution.response import near_taxels, sight_of, tables_of_design

UNKNOWN = 2  # what a pair has beyond a single touch: the two components of the distance
PITCHES = 6.0  # of the taxels: no farther is sought
STEPS = 13  # distances tried
PER_PITCH = 3.0  # places in the distance of two taxels
MOST_PLACES = 600
BLOCK = 256


@dataclass(frozen=True, eq=False)
class TwoPointDistance:
    """Smallest distance of two equal touches that are told from one, place by place.

    Attributes
    ----------
    places : Places
        Of the first touch.
    touch : Touch
        Each of the two.
    ways : (D,) array, rad
        Directions from the first touch to the second.
    distance : (P, D) array, m
        Infinite where none up to `farthest` is told, NaN where the patch ends before that.
    error_rate : float
        Of taking two for one, and of taking one for two, in one reading.
    farthest : float, m
    """

    places: Places
    touch: Touch
    ways: Floats
    distance: Floats
    error_rate: float
    farthest: float

    @property
    def typical(self) -> Floats:
        """Median over the directions that stay on the patch, (P,) m; infinite if none does."""
        ordered, count = self._ordered()
        return np.asarray(ordered[np.arange(len(ordered)), np.maximum(count - 1, 0) // 2])

    @property
    def worst(self) -> Floats:
        """Largest over the directions that stay on the patch, (P,) m; infinite if none does."""
        ordered, count = self._ordered()
        return np.asarray(ordered[np.arange(len(ordered)), np.maximum(count - 1, 0)])

    def _ordered(self) -> tuple[Floats, Floats]:
        known = ~np.isnan(self.distance)
        return np.sort(np.where(known, self.distance, np.inf), axis=1), known.sum(axis=1)


def needed_noncentrality(error_rate: float) -> float:
    """Noncentrality at which both errors of the test occur at `error_rate`."""
    from scipy.optimize import brentq
    from scipy.stats import chi2, ncx2

    check_range("error_rate", error_rate, 1e-9, 0.3, "of one for two, and of two for one")
    level = chi2.isf(error_rate, UNKNOWN)
    return float(brentq(lambda n: ncx2.cdf(level, UNKNOWN, n) - error_rate, 1e-6, 1e4))


def two_point_distance(
    design: SkinDesign,
    touch: Touch,
    places: Places | None = None,
    *,
    error_rate: float = 0.05,
    ways: int = 12,
    farthest: float | None = None,
) -> TwoPointDistance:
    """Distance at which two touches are told from one, everywhere on a layout.

    Readings are taken as proportional to the force, so those of two touches add up. Where touches
    are deep, they are heard better than that.

    Parameters
    ----------
    design : SkinDesign
    touch : Touch
        Each of the two: both press with its force.
    places : Places, optional
        Default some hundred over the patch, no closer than a third of the distance of two taxels.
    error_rate : float
    ways : int
        Directions, around the whole circle.
    farthest : float, m, optional
        Distance up to which is sought. Default six times that of two taxels.

    Raises
    ------
    InputError
        When there is no direction, or a rate or length is out of range.
    """
    if ways < 1:
        raise InputError(f"ways is {ways!r}, expected one direction or more")
    touch.check_on(design.layer)
    design = design.linear
    farthest = PITCHES * design.patch.pitch if farthest is None else farthest
    check_positive("farthest", farthest, "distance of two touches, in metres")
    places = few_places(design) if places is None else places
    angles = np.arange(ways) * 2 * np.pi / ways
    distance = np.empty((len(places), ways))
    needed = needed_noncentrality(error_rate)
    for first in range(0, len(places), BLOCK):
        part = slice(first, first + BLOCK)
        _search(design, touch, places, part, angles, needed, farthest, distance[part])
    return TwoPointDistance(places, touch, angles, distance, error_rate, farthest)


def few_places(design: SkinDesign, most: int = MOST_PLACES) -> Places:
    """Places over a patch, a third of a taxel's pitch apart; farther where there were too many."""
    pitch = design.patch.pitch / PER_PITCH
    places = Places.over(design.patch, pitch)
    while len(places) > most:
        pitch *= max(1.05, np.sqrt(len(places) / most))
        places = Places.over(design.patch, pitch)
    return places


def _search(
    design: SkinDesign,
    touch: Touch,
    places: Places,
    part: slice,
    angles: Floats,
    needed: float,
    farthest: float,
    out: Floats,
) -> None:
    from skinfield.resolution.two_point_kernel import Ground, Pair, distances_told

    h, points, grid = design.layer.thickness, places.plane[part], places.grid
    sight = sight_of(design, touch.radius)
    start, rows = near_taxels(design, points, sight + farthest)
    steps = farthest * np.linspace(0.0, 1.0, STEPS + 1)[1:] ** 1.5  # finer where two are close
    pair = Pair(float(np.log(touch.force)), float(np.log(touch.radius / h)), needed)
    left, low = grid.origin / h
    ground = Ground(places.inside, float(left), float(low), grid.pitch / h)
    ways = np.column_stack([np.cos(angles), np.sin(angles)])
    plane, white = design.patch.plane / h, 1.0 / design.noise
    tables = tables_of_design(design)
    distances_told(
        points / h, ways, steps / h, pair, ground, plane, white, sight / h, start, rows, tables, out
    )
    out *= h
