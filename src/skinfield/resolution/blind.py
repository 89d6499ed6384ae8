"""Blind spots: where a touch moves no reading enough, however hard one looks."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints, check_range
from skinfield.resolution.design import Places, SkinDesign, Touch
from skinfield.resolution.response import snr_per_newton

if TYPE_CHECKING:
    pass

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
    touch : Touch
        Whose radius counts; its force does not.
    snr : (P,) array, 1/N
        Best signal-to-noise ratio of one reading of all taxels, per newton: the matched filter's.
    threshold : float
        Places with less than this part of the best place's `snr` are blind.
    """

    places: Places
    touch: Touch
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
        """Connected blind regions, largest first."""
        return tuple(self._hole(rows) for rows in self.places.parts(self.blind))

    def _hole(self, rows: Ints) -> Hole:
        area = len(rows) * self.places.grid.cell_area
        middle = self.places.plane[rows].mean(axis=0)
        return Hole(area, middle, float(self.response[rows].min()))


def blind_spots(
    design: SkinDesign,
    touch: Touch,
    places: Places | None = None,
    *,
    threshold: float = THRESHOLD,
) -> BlindSpots:
    """Response of a layout to a light touch everywhere.

    Parameters
    ----------
    design : SkinDesign
    touch : Touch
    places : Places, optional
        Default `Places.over` the patch.
    threshold : float
        See `BlindSpots`.
    """
    check_range("threshold", threshold, 0.0, 1.0, "part of the best place's response")
    places = Places.over(design.patch) if places is None else places
    return BlindSpots(places, touch, snr_per_newton(design, touch.radius, places.plane), threshold)
