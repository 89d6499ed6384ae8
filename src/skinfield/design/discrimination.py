r"""Discrimination of touches: the Cramér-Rao bound of place and force, and the two-point distance.

With readings y(θ), noise σ and θ = (x, y, ln F, ln a), no unbiased estimate has a smaller
covariance than

.. math:: \Big(J^T \mathrm{diag}(\sigma^{-2}) J + P\Big)^{-1}, \quad J = \partial y/\partial\theta,

P the information on the radius a that there is before any reading (Van Trees, Detection,
Estimation and Modulation Theory I, section 2.4). Values far beyond the distance of two taxels mean
that the readings say next to nothing: any guess inside the patch is better.

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

from skinfield.design.design import Places, SkinDesign, Touch, near_taxels, respond, sight_of
from skinfield.errors import Floats, InputError, check_range

SIZE_PRIOR = 0.6  # standard deviation of ln radius of everyday contacts
SINGULAR = 1e-12  # smallest eigenvalue of a correlation matrix that can be told from 0


@dataclass(frozen=True, eq=False)
class PlaceAccuracy:
    """Smallest standard deviations of one reading's unbiased estimates, place by place.

    Attributes
    ----------
    places : Places
    place_std : (P,) array, m
        Root of the sum of the variances along the plane's axes. Infinite where the readings
        cannot tell.
    force_std : (P,) array, N
    """

    places: Places
    place_std: Floats
    force_std: Floats


def place_accuracy(design: SkinDesign, touch: Touch, places: Places | None = None) -> PlaceAccuracy:
    """Bound of place and force of a touch everywhere on a layout.

    Parameters
    ----------
    design : SkinDesign
    touch : Touch
    places : Places, optional
        Default `Places.over` the patch.
    """
    places = Places.over(design.patch) if places is None else places
    information = respond(design, touch, places.plane).gram[:, 1:, 1:].copy()
    information[:, 3, 3] += SIZE_PRIOR**-2
    place, log_force = bounds(information)
    return PlaceAccuracy(places, place, touch.force * log_force)


def bounds(information: Floats) -> tuple[Floats, Floats]:
    """Deviations of the place m and of ln force from information matrices (P, 3 or 4, same)."""
    scale = np.sqrt(np.einsum("pii->pi", information))
    seen = (scale > 0.0).all(axis=1)
    place, force = np.full(len(scale), np.inf), np.full(len(scale), np.inf)
    scale, rows = scale[seen], np.flatnonzero(seen)
    correlation = information[seen] / (scale[:, :, None] * scale[:, None, :])
    regular = np.linalg.eigvalsh(correlation)[:, 0] > SINGULAR
    variance = np.einsum("pii->pi", np.linalg.inv(correlation[regular])) / scale[regular] ** 2
    place[rows[regular]] = np.sqrt(variance[:, 0] + variance[:, 1])
    force[rows[regular]] = np.sqrt(variance[:, 2])
    return place, force


UNKNOWN = 2  # what a pair has beyond a single touch: the two components of the distance
PITCHES = 6.0  # of the taxels: no farther is sought
DISTANCES = 13  # distances tried
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
    ways : (D,) array, rad
        Directions from the first touch to the second.
    distance : (P, D) array, m
        Infinite where none that was sought is told, NaN where the patch ends before that.
    error_rate : float
        Of taking two for one, and of taking one for two, in one reading.
    """

    places: Places
    ways: Floats
    distance: Floats
    error_rate: float

    @property
    def typical(self) -> Floats:
        """Median over the directions that stay on the patch, (P,) m; infinite if none does."""
        return np.asarray(np.nanquantile(self._known, 0.5, axis=1, method="lower"))

    @property
    def worst(self) -> Floats:
        """Largest over the directions that stay on the patch, (P,) m; infinite if none does."""
        return np.asarray(np.nanmax(self._known, axis=1))

    @property
    def _known(self) -> Floats:
        none = np.isnan(self.distance).all(axis=1, keepdims=True)
        return np.where(none, np.inf, self.distance)


def needed_noncentrality(error_rate: float) -> float:
    """Noncentrality at which both errors of the test occur at `error_rate`."""
    from scipy.optimize import brentq
    from scipy.special import chdtri, chndtr

    check_range("error_rate", error_rate, 1e-9, 0.3, "of one for two, and of two for one")
    level = chdtri(UNKNOWN, error_rate)
    return float(brentq(lambda n: chndtr(level, UNKNOWN, n) - error_rate, 1e-6, 1e4))


def two_point_distance(
    design: SkinDesign,
    touch: Touch,
    places: Places | None = None,
    *,
    error_rate: float = 0.05,
    ways: int = 12,
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

    Raises
    ------
    InputError
        When there is no direction, or the rate is out of range.
    """
    from skinfield.design.kernels import Ground, Pair, smallest_distances
    from skinfield.solve.atoms.table import atom_tables

    if ways < 1:
        raise InputError(f"ways is {ways!r}, expected one direction or more")
    touch.check_on(design.layer)
    design = design.linear
    farthest = PITCHES * design.patch.pitch
    places = few_places(design) if places is None else places
    angles = np.arange(ways) * 2 * np.pi / ways
    around = np.column_stack([np.cos(angles), np.sin(angles)])
    h, sight, grid = design.layer.thickness, sight_of(design, touch.radius), places.grid
    steps = farthest * np.linspace(0.0, 1.0, DISTANCES + 1)[1:] ** 1.5  # finer where two are close
    needed = needed_noncentrality(error_rate)
    pair = Pair(float(np.log(touch.force)), float(np.log(touch.radius / h)), needed)
    left, low = (grid.origin / h).tolist()
    ground = Ground(places.inside, left, low, grid.pitch / h)
    taxels, white = design.patch.plane / h, 1.0 / design.noise
    tables, distance = atom_tables(design.physics), np.empty((len(places), ways))
    for first in range(0, len(places), BLOCK):
        points, out = places.plane[first : first + BLOCK], distance[first : first + BLOCK]
        start, rows = near_taxels(design, points, sight + farthest)
        smallest_distances(
            points / h, around, steps / h, pair, ground, taxels, white, sight / h, start, rows,
            tables, out,
        )  # fmt: skip
    return TwoPointDistance(places, angles, distance * h, error_rate)


def few_places(design: SkinDesign, most: int = MOST_PLACES) -> Places:
    """Places over a patch, a third of a taxel's pitch apart; farther where there were too many."""
    return Places.over(design.patch, per_pitch=PER_PITCH, most=most)
