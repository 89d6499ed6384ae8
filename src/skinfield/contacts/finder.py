"""From a pressure field to contacts: regions that stand out of the noise."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from skinfield.contacts.regions import compiled
from skinfield.contacts.resultant import Found
from skinfield.errors import Floats, check_range, check_shape
from skinfield.fields import Contact, ModelError, PressureError
from skinfield.layout import Grid

EXACT = ModelError()


@lru_cache(maxsize=256)
def _significance(false_alarm_rate: float, chances: int) -> float:
    """Standard deviations that one of `chances` normal numbers exceeds at the given rate."""
    from scipy.special import ndtri

    return float(-ndtri(false_alarm_rate / chances))


@dataclass(frozen=True, kw_only=True)
class ContactFinder:
    """Connected regions of pressure above the noise.

    Parameters
    ----------
    false_alarm_rate : float
        Readings of an idle patch in which a contact may be seen. A peak must exceed the noise's
        quantile at this rate over as many chances as there are cells that feel it.
    relative_height : float
        A peak must reach this fraction of the highest: linear solvers ring beside a press.
    prominence : float
        Two peaks are two contacts if the lower stands out of the saddle by this fraction of
        itself; else one.
    edge : float
        A region ends where the pressure falls to this fraction of its peak.
    """

    false_alarm_rate: float = 1e-3
    relative_height: float = 0.2
    prominence: float = 0.3
    edge: float = 0.2

    def __post_init__(self) -> None:
        check_range("false_alarm_rate", self.false_alarm_rate, 1e-12, 0.5, "a share of readings")
        for name in ("relative_height", "prominence", "edge"):
            check_range(name, getattr(self, name), 0.0, 1.0, "a fraction of a peak")

    def sigmas(self, noise: PressureError) -> float:
        """Standard deviations by which a peak must exceed the noise of the cells that feel it."""
        return _significance(self.false_alarm_rate, max(noise.felt, 1))

    def __call__(
        self,
        grid: Grid,
        pressure: Floats,
        noise: PressureError,
        error: PressureError | None = None,
        model_error: ModelError = EXACT,
    ) -> tuple[Contact, ...]:
        """Contacts of one field.

        Parameters
        ----------
        grid : Grid
        pressure : (K,) array, Pa
        noise : PressureError
            Of the pressure: what stands out of it is a contact.
        error : PressureError, optional
            How far the pressure may be from the truth, if the solver states more than its noise.
        model_error : ModelError
            What is wrong with the contacts beside.

        Returns
        -------
        tuple of Contact
            By falling normal force. Their covariance, deviation of the area and outline are worked
            out when they are first asked for.

        Raises
        ------
        InputError
            If the pressure or the noise is not one number for each node.
        """
        flood = compiled()
        sigmas = self.sigmas(noise)
        flat = np.require(pressure, np.float64, ("C", "W"))  # others would be compiled for anew
        if not flat.shape == noise.std.shape == (len(grid),):
            check_shape("pressure", flat, (len(grid),), "one per node of the grid")
            check_shape("noise.std", noise.std, (len(grid),), "one per node of the grid")
        if not flood.stands_out(flat, noise.std, sigmas):
            return ()
        heights = sigmas, self.relative_height, self.prominence, self.edge
        regions = flood.find(flat, noise.std, grid.shape[1], *heights)
        if not len(regions[1]):
            return ()
        stated = noise if error is None else error
        found = Found.of(grid, flat, stated, model_error, regions, self.edge)
        return tuple(found.contacts())
