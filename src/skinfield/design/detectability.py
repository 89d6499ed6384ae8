r"""Detectability of a touch: the smallest force that is found, and blind spots.

A touch of force F at a known place, read once with independent Gaussian noise, is found best by
the matched filter, whose statistic is normal with variance 1 and mean F d, d the signal-to-noise
ratio per newton (Kay, Fundamentals of Statistical Signal Processing II, section 4.3). With the
place unknown, the largest statistic over all places is judged. It exceeds a high level u by noise
alone with the probability

.. math:: P(u) = L_0 \bar\Phi(u) + L_1 \frac{e^{-u^2/2}}{2\pi}
          + L_2 \frac{u\,e^{-u^2/2}}{(2\pi)^{3/2}},

the expected Euler characteristic of the places above u (Adler and Taylor, Random Fields and
Geometry, theorem 12.4.1): L_2 is the patch's area, L_1 half its outline and L_0 its number of
pieces less holes, all measured by how fast the direction of the readings turns from place to
place. P(u) over the normal tail is the number of independent places.

`blind_spots` is where a touch moves no reading enough, however hard one looks.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.design.design import (
    FAINT,
    TRIAL,
    Places,
    Responses,
    SkinDesign,
    Touch,
    largest_force,
    respond,
    snr_per_newton,
)
from skinfield.errors import Floats, InputError, check_range

THRESHOLD = 0.1  # of the best place's response


@dataclass(frozen=True)
class Hole:
    """A connected blind region.

    Attributes
    ----------
    area : float, m²
    middle : (2,) array, m
        Mean of its places, in the patch's plane.
    deepest : float
        Smallest response in it, as a part of the best place's.
    """

    area: float
    middle: Floats
    deepest: float


@dataclass(frozen=True, eq=False)
class BlindSpots:
    """How well a light touch is heard, place by place.

    Attributes
    ----------
    places : Places
    snr : (P,) array, 1/N
        Best signal-to-noise ratio of one reading of all taxels, per newton: the matched filter's.
    threshold : float
        Places with less than this part of the best place's `snr` are blind.
    """

    places: Places
    snr: Floats
    threshold: float

    @property
    def response(self) -> Floats:
        """`snr` as a part of the best place's, (P,)."""
        best = float(self.snr.max())
        return self.snr / best if best > 0.0 else np.zeros_like(self.snr)

    @property
    def blind(self) -> NDArray[np.bool_]:
        """Which places are blind, (P,)."""
        return np.asarray(self.response < self.threshold)

    @property
    def blind_share(self) -> float:
        """Part of the places that is blind."""
        return float(self.blind.mean())

    @property
    def holes(self) -> tuple[Hole, ...]:
        """Connected blind regions, largest first; places that share a corner are connected."""
        from scipy.ndimage import label

        places, blind, response = self.places, self.blind, self.response
        names = label(places.picture(blind.astype(np.float64)) > 0.0, structure=np.ones((3, 3)))[0]
        of_place = names.ravel()[places.nodes]
        parts = [np.flatnonzero(of_place == name) for name in range(1, names.max() + 1)]
        return tuple(
            Hole(
                len(rows) * places.grid.cell_area,
                places.plane[rows].mean(axis=0),
                float(response[rows].min()),
            )
            for rows in sorted(parts, key=len, reverse=True)
        )


def blind_spots(
    design: SkinDesign, touch: Touch, places: Places | None = None, *, threshold: float = THRESHOLD
) -> BlindSpots:
    """Response of a layout to a light touch everywhere.

    Parameters
    ----------
    design : SkinDesign
    touch : Touch
        Whose radius counts; its force does not.
    places : Places, optional
        Default `Places.over` the patch.
    threshold : float
        See `BlindSpots`.
    """
    check_range("threshold", threshold, 0.0, 1.0, "part of the best place's response")
    places = Places.over(design.patch) if places is None else places
    return BlindSpots(places, snr_per_newton(design, touch.radius, places.plane), threshold)


STEPS = 12  # of the search for a force where readings are not proportional to it
SETTLED = 1e-4  # relative


@dataclass(frozen=True)
class SearchedPlaces:
    """The patch as large as a matched filter sees it: Lipschitz-Killing curvatures.

    Attributes
    ----------
    area, half_outline : float, dimensionless
        In units in which the correlation of two templates near each other is 1 - distance²/2.
    pieces : int
        Connected parts less holes.
    """

    area: float
    half_outline: float
    pieces: int

    def false_alarm_rate(self, level: float) -> float:
        """Probability that noise alone exceeds `level` anywhere; good where it is below 0.1."""
        from scipy.special import ndtr

        fall = np.exp(-(level**2) / 2)
        flat = self.pieces * float(ndtr(-level))
        rim = self.half_outline * fall / (2 * np.pi)
        return float(flat + rim + self.area * level * fall / (2 * np.pi) ** 1.5)

    def level(self, false_alarm_rate: float) -> float:
        """Level, in standard deviations, that noise alone exceeds anywhere at this rate."""
        from scipy.optimize import brentq

        lowest = 1.0  # from here on the rate falls with the level
        if self.false_alarm_rate(lowest) <= false_alarm_rate:
            return lowest
        excess = lambda u: np.log(self.false_alarm_rate(u) / false_alarm_rate)  # noqa: E731
        return float(brentq(excess, lowest, 36.0))

    def independent(self, false_alarm_rate: float) -> float:
        """How many places that do not know of each other have the same false alarms together."""
        from scipy.special import ndtr

        return false_alarm_rate / float(ndtr(-self.level(false_alarm_rate)))


@dataclass(frozen=True, eq=False)
class DetectableForce:
    """Smallest force that is found, place by place.

    Attributes
    ----------
    places : Places
    unknown_place : (P,) array, N
        Found at `detection_rate` by one who searches all places. Infinite where no taxel hears
        the touch.
    false_alarm_rate, detection_rate : float
        Per reading of all taxels.
    searched : SearchedPlaces
    """

    places: Places
    unknown_place: Floats
    false_alarm_rate: float
    detection_rate: float
    searched: SearchedPlaces


def detectable_force(
    design: SkinDesign,
    touch: Touch,
    places: Places | None = None,
    *,
    false_alarm_rate: float = 1e-3,
    detection_rate: float = 0.9,
) -> DetectableForce:
    """Smallest force that is found everywhere on a layout.

    With the place unknown the detection rate is a lower bound: the largest statistic is at least
    that of the true place.

    Parameters
    ----------
    design : SkinDesign
    touch : Touch
        Whose radius counts; its force does not.
    places : Places, optional
        Default `Places.over` the patch.
    false_alarm_rate, detection_rate : float
        Per reading of all taxels. To judge a mean of n readings with white noise, divide the
        design's noise by the root of n.
    """
    from scipy.special import ndtri

    check_range("false_alarm_rate", false_alarm_rate, 1e-12, 0.1, "beyond it touch means nothing")
    check_range("detection_rate", detection_rate, 0.5, 1 - 1e-9, "beyond it is no detection")
    places = Places.over(design.patch) if places is None else places
    light = respond(design, Touch(TRIAL, touch.radius), places.plane)
    searched = searched_places(places, light)
    needed = searched.level(false_alarm_rate) + float(ndtri(detection_rate))
    forces = force_for_snr(design, touch, places.plane, light.snr / TRIAL, needed)
    return DetectableForce(places, forces, false_alarm_rate, detection_rate, searched)


def searched_places(places: Places, responses: Responses) -> SearchedPlaces:
    """Measure a patch by the turning of its readings; places that nothing hears are left out."""
    heard = responses.snr > FAINT * responses.snr.max()
    if not heard.any():
        raise InputError("no taxel hears a touch anywhere, expected a patch that feels something")
    metric = np.where(heard[:, None, None], responses.turn, 0.0)
    cell = places.grid.pitch
    area = np.sqrt(np.maximum(np.linalg.det(metric), 0.0)).sum() * cell**2
    mask = places.inside.copy()
    mask.ravel()[places.nodes[~heard]] = False
    turning = np.sqrt(np.maximum(metric[:, (0, 1), (0, 1)], 0.0))  # rounding may take it below 0
    along = [places.picture(turning[:, axis]) for axis in (0, 1)]
    # A side of a cell stands for pi/4 of its length of a border that runs in any direction.
    outline = sum(_border(mask, lengths, axis) for axis, lengths in enumerate(along)) * cell
    return SearchedPlaces(float(area), float(np.pi / 4 * outline / 2), _euler_number(mask))


def _border(mask: NDArray[np.bool_], lengths: Floats, axis: int) -> float:
    """Sum of `lengths` over the sides along x (axis 0) or y (1) that part inside from outside."""
    turned = (mask, lengths) if axis == 0 else (mask.T, lengths.T)
    inside, length = (np.pad(part, ((1, 1), (0, 0))) for part in turned)
    length = np.where(inside, length, 0.0)
    changes = inside[1:] != inside[:-1]
    return float(np.sum(np.add(length[1:], length[:-1])[changes]))


def _euler_number(mask: NDArray[np.bool_]) -> int:
    """Connected parts less holes: corners - sides + cells of the union of the closed cells."""
    padded = np.pad(mask, 1)
    rows, columns = padded[1:] | padded[:-1], padded[:, 1:] | padded[:, :-1]
    corners = rows[:, 1:] | rows[:, :-1]
    return int(corners.sum()) - int(rows.sum()) - int(columns.sum()) + int(mask.sum())


def force_for_snr(
    design: SkinDesign, touch: Touch, points: Floats, per_newton: Floats, snr: float
) -> Floats:
    """Force in N, (P,), at which the readings of a touch at (P, 2) m have a signal-to-noise ratio.

    `per_newton` (P,) is the ratio of a light touch over its force. Where readings are not
    proportional to the force, the search starts from there; forces above what a contact of this
    radius can carry are those of a light touch in proportion.
    """
    heard = per_newton > FAINT * per_newton.max()
    forces = np.full(len(points), np.inf)
    forces[heard] = snr / per_newton[heard]
    most = largest_force(design, touch.radius)
    bent = np.flatnonzero(forces < most)  # a wider contact is needed for more: in proportion
    if most == np.inf or not len(bent):
        return forces
    sought = forces[bent]
    for _ in range(STEPS):
        gram = respond(design, touch, points[bent], sought).gram
        slope = np.maximum(gram[:, 0, 3] / gram[:, 0, 0], 0.3)  # of ln ratio by ln force
        step = np.log(snr / np.sqrt(gram[:, 0, 0])) / slope
        sought = np.minimum(sought * np.exp(np.clip(step, -1.0, 1.0)), most)
        if np.abs(step[sought < most]).max(initial=0.0) < SETTLED:
            break
    forces[bent] = sought
    return forces
