"""What a sheet makes of one reading."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.fields import Contact
from skinfield.inverse.sheet.search import contacts_on
from skinfield.inverse.sheet.windows import Finder

if TYPE_CHECKING:
    from skinfield.inverse.sheet.sheet import Sheet


@dataclass(frozen=True, eq=False)
class SheetEstimate:
    """Pressure on all cells of a sheet; what follows from it is computed when asked for.

    Attributes
    ----------
    sheet : Sheet
        That made it.
    readings : (L,) array
        Linearised, in the quantity's unit; NaN for taxels that were left out.
    pressure : (rows, columns) array, Pa
        Positive in compression.
    weights : (L,) array
        What each taxel adds: the solution in taxel space, times what whitens it.
    iterations : int
        Of conjugate gradients.
    relative_residual : float
        That they left, as a share of the whitened readings.
    latency : float, s
        From the reading to the pressure.
    deadline_met : bool
        True where none was set.
    """

    sheet: "Sheet"
    readings: Floats
    pressure: NDArray[Any]
    weights: NDArray[Any]
    iterations: int
    relative_residual: float
    latency: float
    deadline_met: bool = True

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Taxels that were used, (L,)."""
        return ~np.isnan(self.readings)

    @property
    def normal_force(self) -> float:
        """Sum of the pressure over the sheet, N."""
        return float(self.pressure.sum(dtype=np.float64)) * self.sheet.pitch**2

    @cached_property
    def displacement(self) -> NDArray[Any]:
        """Displacement of the surface, (rows, columns, 3) m: along x, along y and outwards."""
        return self.sheet.deformation(self.pressure)

    @cached_property
    def indentation(self) -> NDArray[Any]:
        """Displacement into the skin, (rows, columns) m."""
        if "displacement" in self.__dict__:
            return np.asarray(-self.displacement[..., 2])
        return np.asarray(-self.sheet.deformation(self.pressure, (2,))[..., 0])

    def contacts(self, finder: Finder) -> tuple[Contact, ...]:
        """Pressed regions, by falling normal force.

        The sheet is searched where the pressure exceeds what noise alone reaches on it (on all but
        1 % of its cells), and each such window is given to the finder as a patch of its own: two
        contacts far from each other do not know of each other, and no finder sees a million taxels.

        Parameters
        ----------
        finder : Finder
            Such as `skinfield.ContactFinder()`. Its rate of false alarms is that of the sheet.

        Returns
        -------
        tuple of Contact
            In the sheet's plane, z = 0; `cells` are flat indices of `pressure`. Their covariance is
            that of the readings' noise.
        """
        return contacts_on(self, finder)

    @cached_property
    def residual(self) -> Floats:
        """Linearised reading less what the pressure predicts, (L,) in the quantity's unit."""
        return np.asarray(self.readings - self.sheet.predict(self.pressure))

    @property
    def defect(self) -> float:
        """How far the answer is from the exact one's condition, as a share of the readings.

        At the exact solution the residual over the noise's variance is the taxels' weights. This
        holds the iterations' residual and what was cut off the matrix, measured on all cells.
        """
        white = np.where(self.valid, self.residual, 0.0) / self.sheet.noise_std
        weights = self.weights * self.sheet.noise_std
        whole = np.linalg.norm(np.where(self.valid, self.readings, 0.0) / self.sheet.noise_std)
        return float(np.linalg.norm(white - weights) / whole) if whole > 0.0 else 0.0
