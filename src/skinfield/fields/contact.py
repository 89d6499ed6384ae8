"""One pressed region."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats


@dataclass(frozen=True, eq=False)
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
        Of the region's cells.
    peak_pressure : float, Pa
        The highest in the region.
    force_std : float, N
        How far the noise of one reading moves the normal force (its model error comes on top).
    outline : (N, 3) array, m
        Border of the region, closed: the last point is the first.
    axes : (2,) array, m
        Semi-axes of the ellipse of equal second moments, the longer first.
    angle : float, rad
        From the first tangent of the surface to the longer axis, -pi/2 to pi/2.
    cells : (N,) int array
        Nodes of the grid that make up the region.
    """

    position: Floats
    force: Floats
    moment: Floats
    normal: Floats
    area: float
    peak_pressure: float
    force_std: float
    outline: Floats
    axes: Floats
    angle: float
    cells: NDArray[np.int64]

    @property
    def normal_force(self) -> float:
        """Force into the skin along its normal, N; positive in compression."""
        return float(-self.force @ self.normal)
