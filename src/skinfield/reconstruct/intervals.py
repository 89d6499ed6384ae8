"""Calibrated intervals of contacts: how far off forces, places and areas are, and their files.

Split-conformal prediction (Vovk, Gammerman and Shafer 2005; with normalised errors, Papadopoulos,
Gammerman and Vovk, Proc. AIA 2008): on some presses one learns what error to expect of a contact by
what is stated of it, on the others how many times as large the error was. Whatever the solver, a
further press of the same kind then lies inside as often as asked for. Contacts that the solver is
sure of, and those that it is not, are counted apart, so that intervals hold for both.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import (
    FileError,
    Floats,
    InputError,
    check_finite,
    check_positive,
    check_range,
    check_shape,
)
from skinfield.estimate import Contact, Spread
from skinfield.estimate.uncertainty import below

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
    presses, found : int
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
    found: int
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

    def of(self, contact: Contact) -> tuple[Floats, float, Spread]:
        """Covariance, deviation of the area and spread of a contact."""
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
        low, high = spread.area_interval(2 / 3)
        return covariance, float(high - low) / 2, spread


@dataclass(frozen=True, eq=False)
class CalibratedContact:
    """A contact by what was learnt, worked out when first asked for; see `Contact.later`."""

    intervals: Intervals
    contact: Contact

    @cached_property
    def _told(self) -> tuple[Floats, float, Spread]:
        return self.intervals.of(self.contact)

    @property
    def covariance(self) -> Floats:
        """Of place and force, rescaled."""
        return self._told[0]

    @property
    def area_std(self) -> float:
        """Of the spread of the area."""
        return self._told[1]

    @property
    def spread(self) -> Spread:
        """Truths of presses like this one."""
        return self._told[2]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.__dict__["contact"], name)


def relative_deviation(contact: Contact) -> float:
    """Stated deviation of the normal force over the force."""
    return max(contact.force_std / contact.normal_force, SURE)


def features_of(deviation: float, force: float) -> Floats:
    """What the expected error of a contact depends on: (3,)."""
    return np.array([1.0, np.log(deviation), np.log(force)])


FORMAT = "skinfield-intervals"
VERSION = 1
_TEXTS = ("solver", "quantity")
_COUNTS = ("taxels", "presses", "found")
_LONGEST = 100_000_000  # bytes


def save_intervals(intervals: Intervals, path: Path | str) -> None:
    """Write intervals as JSON.

    Raises
    ------
    FileError
        If the file cannot be written.
    """
    content: dict[str, Any] = {"format": FORMAT, "version": VERSION}
    content |= {name: getattr(intervals, name) for name in (*_TEXTS, *_COUNTS)}
    content |= {"noise_std": intervals.noise_std, "place_floor_m": intervals.place_floor}
    for name in ("force", "area"):
        ratio: Ratio = getattr(intervals, name)
        content[name] = {"centre": ratio.centre.tolist(), "floor": ratio.floor}
    content["edges"] = intervals.edges.tolist()
    content["groups"] = [
        {part.name: getattr(group, part.name).tolist() for part in fields(group)}
        for group in intervals.groups
    ]
    try:
        Path(path).write_text(json.dumps(content), encoding="utf-8")
    except OSError as error:
        raise FileError(f"{path} cannot be written: {error.strerror or error}") from error


def load_intervals(path: Path | str) -> Intervals:
    """Read intervals that `save_intervals` wrote.

    Raises
    ------
    FileError
        If the file is missing, of another format or version, or broken.
    """
    try:
        if Path(path).stat().st_size > _LONGEST:
            raise FileError(f"{path} has more than {_LONGEST:_} bytes, expected intervals")
        text = Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise FileError(f"{path} is no text, expected JSON of save_intervals: {error}") from error
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise FileError(f"{path} is no JSON, expected that of save_intervals: {error}") from error
    head = (content.get("format"), content.get("version")) if isinstance(content, dict) else None
    if head != (FORMAT, VERSION):
        raise FileError(f"{path} has head {head!r}, expected {(FORMAT, VERSION)!r}: save it anew")
    try:
        return _intervals(content)
    except InputError as error:
        raise FileError(f"{path}: {error}") from error


def _intervals(content: dict[str, Any]) -> Intervals:
    groups = _entry(content, "groups", list)
    if not groups:
        raise InputError("groups is empty, expected at least one")
    return Intervals(
        **{name: _entry(content, name, str) for name in _TEXTS},
        **{name: _entry(content, name, int) for name in _COUNTS},
        noise_std=_number(content, "noise_std"),
        force=_ratio(content, "force"),
        area=_ratio(content, "area"),
        place_floor=_number(content, "place_floor_m"),
        edges=_numbers(content, "edges"),
        groups=tuple(_group(number, each) for number, each in enumerate(groups)),
    )


def _group(number: int, content: Any) -> Group:
    if not isinstance(content, dict):
        raise InputError(f"groups[{number}] is {type(content).__name__}, expected an object")
    return Group(**{part.name: _numbers(content, part.name) for part in fields(Group)})


def _ratio(content: dict[str, Any], name: str) -> Ratio:
    inner = _entry(content, name, dict)
    return Ratio(centre=_numbers(inner, "centre"), floor=_number(inner, "floor"))


def _entry(content: dict[str, Any], name: str, kind: type) -> Any:
    value = content.get(name)
    if not isinstance(value, kind) or isinstance(value, bool):
        raise InputError(f"{name} is {str(value)[:40]!r}, expected {kind.__name__}")
    return value


def _number(content: dict[str, Any], name: str) -> float:
    value = content.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{name} is {str(value)[:40]!r}, expected a number")
    return float(_floats(name, [value])[0])


def _numbers(content: dict[str, Any], name: str) -> Floats:
    values = _entry(content, name, list)
    if not all(isinstance(each, int | float) and not isinstance(each, bool) for each in values):
        raise InputError(f"{name} holds what is no number, expected numbers alone")
    return _floats(name, values)


def _floats(name: str, values: list[int | float]) -> Floats:
    try:
        return np.array(values, dtype=np.float64)
    except OverflowError as error:
        raise InputError(f"{name} holds a number that no float can: {error}") from error
