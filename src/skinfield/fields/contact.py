"""One pressed region."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats


@dataclass(frozen=True, eq=False, kw_only=True)
class Contact:
    """One pressed region of a patch, in the patch's own frame.

    Attributes
    ----------
    position : (3,) array, m
        Centre of pressure, on the skin's undeformed surface.
    force : (3,) array, N
        Resultant of the traction on the skin: it points into the skin in compression.
    moment : (3,) array, N m
        Resultant moment of the traction about `position`.
    normal : (3,) array
        Outward normal of the skin at `position`.
    area : float, m²
        That is pressed.
    peak_pressure : float, Pa
        The highest in the region.
    covariance : (3, 3) array
        Of the place along the surface's two tangents at `position`, m (x and y of a flat patch),
        and of the normal force, N: how sure the solver is of one reading's answer.
    area_std : float, m²
        One standard deviation of `area`.
    radius : float, m
        Of the contact, where it is round; else of the circle of equal area.
    shape : "sphere", "flat", "line" or "other"
        What presses, as far as the readings tell: "other" for all that was not fitted.
    outline : (N, 3) array, m
        Border of the region, closed: the last point is the first.
    axes : (2,) array, m
        Semi-axes of the ellipse of equal second moments, the longer first.
    angle : float, rad
        From the first tangent of the surface to the longer axis, -pi/2 to pi/2.
    cells : (N,) int array
        Nodes of the grid that make up the region.
    track_id : int or None
        The same for one contact as long as it lasts; given by a `Tracker`.
    """

    position: Floats
    force: Floats
    moment: Floats
    normal: Floats
    area: float
    peak_pressure: float
    covariance: Floats
    area_std: float
    radius: float
    shape: str
    outline: Floats
    axes: Floats
    angle: float
    cells: NDArray[np.int64]
    track_id: int | None = None

    @property
    def normal_force(self) -> float:
        """Force into the skin along its normal, N; positive in compression."""
        return float(-self.force @ self.normal)

    @property
    def force_std(self) -> float:
        """One standard deviation of the normal force, N."""
        return float(np.sqrt(self.covariance[2, 2]))

    @property
    def place_std(self) -> float:
        """Root of the summed variances of the place along both tangents, m."""
        return float(np.sqrt(self.covariance[0, 0] + self.covariance[1, 1]))
