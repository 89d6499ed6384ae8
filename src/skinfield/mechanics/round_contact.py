"""What every closed form of a round contact on a half-space shares."""

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, as_floats, check_positive


class RoundContact(ABC):
    """What every round contact on a half-space has."""

    contact_radius: float

    @property
    @abstractmethod
    def depth(self) -> float:
        """Of the body's lowest point below the undeformed surface, m."""

    @property
    @abstractmethod
    def force(self) -> float:
        """Into the surface, N."""

    @property
    def mean_pressure(self) -> float:
        """Over the contact, Pa."""
        return self.force / (np.pi * self.contact_radius**2)

    def pressure(self, r: ArrayLike) -> Floats:
        """Pressure, Pa, at distances r in m from the axis, any shape; zero outside the contact."""
        share = np.abs(as_floats("r", r)) / self.contact_radius
        return np.where(share <= 1.0, self._pressure(np.minimum(share, 1.0)), 0.0)

    def indentation(self, r: ArrayLike) -> Floats:
        """Displacement of the surface into the half-space, m, at r in m, inside and outside."""
        r = np.abs(as_floats("r", r))
        far = np.maximum(r, self.contact_radius)
        below = self.depth - self._height(np.minimum(r, self.contact_radius))
        return np.where(r <= self.contact_radius, below, self._outside(far))

    @abstractmethod
    def _pressure(self, share: Floats) -> Floats: ...

    @abstractmethod
    def _height(self, r: Floats) -> Floats: ...

    @abstractmethod
    def _outside(self, r: Floats) -> Floats: ...


def check_contact(modulus: float, contact_radius: float) -> None:
    """Raise InputError unless both are above zero."""
    check_positive("modulus", modulus, "effective, in Pa")
    check_positive("contact_radius", contact_radius, "in metres")
