"""From a pressure field to contacts: regions that stand out of the noise."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from skinfield.contacts.regions import regions
from skinfield.contacts.resultant import Field, contact_of
from skinfield.errors import Floats, check_range
from skinfield.fields import Contact, ModelError, PressureError, PressureNoise
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

    def __call__(
        self,
        grid: Grid,
        pressure: Floats,
        noise: PressureNoise,
        error: PressureError | None = None,
        model_error: ModelError = EXACT,
    ) -> tuple[Contact, ...]:
        """Contacts of one field.

        Parameters
        ----------
        grid : Grid
        pressure : (K,) array, Pa
        noise : PressureNoise
            Of the pressure: what stands out of it is a contact.
        error : PressureError, optional
            How far the pressure may be from the truth, if the solver states more than its noise.
        model_error : ModelError
            What is wrong with the contacts beside.

        Returns
        -------
        tuple of Contact
            By falling normal force.
        """
        chances = max(int(np.count_nonzero(noise.std)), 1)
        sigmas = _significance(self.false_alarm_rate, chances)
        highest = float(pressure.max())
        needed = np.maximum(sigmas * noise.std, self.relative_height * highest)
        if not (pressure > needed).any():
            return ()
        picture = pressure.reshape(grid.shape)
        drop = np.maximum(self.prominence * picture, sigmas * noise.std.reshape(grid.shape))
        floor = np.full(grid.shape, self.edge * self.relative_height * highest)
        found = regions(picture, drop, floor, self.edge)
        found = [cells for cells in found if (pressure > needed)[cells].any()]
        field = Field(grid, pressure, noise if error is None else error, self.edge)
        contacts = [contact_of(field, cells, model_error) for cells in found]
        return tuple(sorted(contacts, key=lambda contact: -contact.normal_force))
