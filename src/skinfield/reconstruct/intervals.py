"""Calibrated intervals of contacts: how far off forces, places and areas are.

Split-conformal prediction (Vovk, Gammerman and Shafer 2005; with normalised errors, Papadopoulos,
Gammerman and Vovk, Proc. AIA 2008): on some presses one learns what error to expect of a contact by
what is stated of it, on the others how many times as large the error was. Whatever the solver, a
further press of the same kind then lies inside as often as asked for. Contacts that the solver is
sure of, and those that it is not, are counted apart, so that intervals hold for both.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from skinfield.errors import (
    Floats,
    InputError,
    check_finite,
    check_positive,
    check_range,
    check_shape,
)
from skinfield.estimate import Contact, Spread
from skinfield.estimate.uncertainty import below, between

NINETY = 1.6448536269514722  # standard deviations, each way, that hold 90 %
NINETY_PLANE = 2.145966026289347  # the same for the radius in the plane: the root of 4.605
SURE = 1e-6  # least relative deviation that counts
LEAST = 40  # presses of a group: fewer have no 95 % interval


@dataclass(frozen=True, eq=False, kw_only=True)
class Ratio:
    """What ln(true / stated) is expected to be of a contact: a centre and a size.

    Attributes
    ----------
    centre : (3,) array
        Of 1, ln(stated deviation / stated force) and ln(stated force / N).
    floor : float
        The size is the root of the squared stated relative deviation and the square of this.
    """

    centre: Floats
    floor: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Group:
    """Errors over their expected size, rising, of presses whose contacts were about as sure.

    Attributes
    ----------
    force, area : (N,) arrays
        Of ln(true / stated), less the centre.
    force_size : (N,) array
        Of abs(true - stated) / stated.
    place : (N,) array
        Root of the squared error in the metric of its covariance.
    distance : (N,) array
        Distance of the place over the root of half the summed variances.
    """

    force: Floats
    area: Floats
    force_size: Floats
    place: Floats
    distance: Floats


@dataclass(frozen=True, eq=False, kw_only=True)
class Intervals:
    """How far a reconstructor's contacts are from the truth.

    Attributes
    ----------
    solver, quantity : str
        For which they hold: name of the solver's class, and symbol of what taxels read.
    taxels : int
        Of the patch.
    noise_std : float, in the quantity's unit
        Mean over the taxels.
    presses, detected : int
        That were simulated, and of which a contact was found.
    force, area : Ratio
    place_floor : float, m
        Added in square to the stated variance along each tangent.
    edges : (G - 1,) array
        Stated deviation over stated force at which the groups are cut, rising.
    groups : tuple of G Group
    """

    solver: str
    quantity: str
    taxels: int
    noise_std: float
    presses: int
    detected: int
    force: Ratio
    area: Ratio
    place_floor: float
    edges: Floats
    groups: tuple[Group, ...]

    def __post_init__(self) -> None:
        check_shape("edges", self.edges, (len(self.groups) - 1,), "one less than groups")
        check_finite("edges", self.edges, "stated relative deviations")
        rising = {"edges": self.edges}
        for number, group in enumerate(self.groups):
            for part in fields(group):
                values = getattr(group, part.name)
                name = f"groups[{number}].{part.name}"
                check_shape(name, values, (len(group.force),), "one per press of the group")
                check_finite(name, values, "errors over their expected size")
                rising[name] = values
            if len(group.force) < LEAST:
                raise InputError(
                    f"groups[{number}] has {len(group.force)} presses, expected {LEAST} or more"
                )
        for name, values in rising.items():
            if (np.diff(values) < 0).any():
                raise InputError(f"{name} is not sorted, expected rising numbers")
        for name, ratio in (("force", self.force), ("area", self.area)):
            check_shape(f"{name}.centre", ratio.centre, (3,), "of three features")
            check_finite(f"{name}.centre", ratio.centre, "of three features")
            check_range(f"{name}.floor", ratio.floor, 0.0, 1e3, "a relative deviation")
        check_range("place_floor", self.place_floor, 1e-12, 1.0, "in metres")
        check_positive("noise_std", self.noise_std, "in the quantity's unit")

    def check(self, solver: str, quantity: str, taxels: int, noise_std: float) -> None:
        """Raise InputError unless the intervals are of such a reconstructor."""
        for name, mine, other in (
            ("solver", self.solver, solver),
            ("quantity", self.quantity, quantity),
            ("number of taxels", self.taxels, taxels),
        ):
            if mine != other:
                raise InputError(
                    f"intervals are of the {name} {mine!r}, expected {other!r}: calibrate this "
                    "reconstructor, with calibrated()"
                )
        if not 0.8 < noise_std / self.noise_std < 1.25:
            raise InputError(
                f"intervals are of noise_std {self.noise_std:g}, expected about {noise_std:g}: "
                "calibrate this reconstructor, with calibrated()"
            )

    def __call__(self, contacts: Sequence[Contact]) -> tuple[Contact, ...]:
        """Contacts with their covariance rescaled and their spread set, when asked for."""
        return tuple(Contact.later(CalibratedContact(self, contact)) for contact in contacts)

    def of(self, contact: Contact) -> dict[str, Any]:
        """Covariance, deviation of the area and spread of a contact, by their names."""
        force, deviation = contact.normal_force, relative_deviation(contact)
        group = self.groups[int(np.searchsorted(self.edges, deviation))]
        features = features_of(deviation, force)
        force_size = np.hypot(deviation, self.force.floor)
        area_size = np.hypot(deviation, self.area.floor)
        block = contact.covariance[:2, :2] + self.place_floor**2 * np.eye(2)
        spread = Spread(
            forces=force * np.exp(features @ self.force.centre + force_size * group.force),
            places=np.sqrt(np.trace(block) / 2) * group.distance,
            areas=contact.area * np.exp(features @ self.area.centre + area_size * group.area),
        )
        wide = below(group.place, 0.9) / NINETY_PLANE
        force_std = below(group.force_size, 0.9) / NINETY * force_size * force
        covariance = np.empty((3, 3))
        covariance[:2, :2] = wide**2 * block
        covariance[2, 2] = force_std**2
        stretch = wide * force_std / max(contact.force_std, 1e-300)  # of place and of force
        covariance[:2, 2] = covariance[2, :2] = contact.covariance[:2, 2] * stretch
        low, high = between(spread.areas, 2 / 3)
        return {"covariance": covariance, "area_std": float(high - low) / 2, "spread": spread}


@dataclass(frozen=True, eq=False)
class CalibratedContact:
    """A contact by what was learnt, worked out when first asked for; see `Contact.later`."""

    intervals: Intervals
    contact: Contact

    @cached_property
    def _worked_out(self) -> dict[str, Any]:
        return self.intervals.of(self.contact)

    def __getattr__(self, name: str) -> Any:
        if name in ("covariance", "area_std", "spread"):
            return self._worked_out[name]
        return getattr(self.__dict__["contact"], name)


def relative_deviation(contact: Contact) -> float:
    """Stated deviation of the normal force over the force."""
    return max(contact.force_std / contact.normal_force, SURE)


def features_of(deviation: float | Floats, force: float | Floats) -> Floats:
    """What the expected error of contacts depends on: (..., 3)."""
    return np.stack([np.ones_like(force), np.log(deviation), np.log(force)], axis=-1)
