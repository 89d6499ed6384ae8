"""Contacts as an engine elsewhere tells them: those of its fit, which estimates do not hold."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.bridges.zenoh.messages import MOST_STATUS, object_of
from skinfield.contacts.live import CONTACT
from skinfield.errors import InputError
from skinfield.layout import Skin

RECENT_NS = 250_000_000  # that contacts may be of another time than an estimate
FINDERS = ("engine", "fit")
VECTORS = ("position", "normal")
SURE = ("x", "y", "normal_force")  # what every contact has; the rest may be unknown
PERHAPS = ("force_std", "place_std", "area", "peak_pressure", "age", "speed")
MOST = 4096  # contacts
FAR, LARGE = 1e3, 1e12  # m or N, and anything


class Contacts(NamedTuple):
    """Contacts of one cycle.

    Attributes
    ----------
    stamp_ns : int, ns
    rows : (N,) array of CONTACT
        In the order in which they came; NaN where something is not known.
    by : list of str
        Who found each: "engine" or "fit".
    """

    stamp_ns: int
    rows: NDArray[Any]
    by: list[str]


def contacts_from(data: bytes, skin: Skin) -> Contacts:
    """Read the `contacts` of an engine with this skin.

    Raises
    ------
    InputError
        If they make no sense.
    """
    plain = object_of(data, MOST_STATUS)
    stamp, told = plain.get("stamp_ns"), plain.get("contacts")
    if type(stamp) is not int or not 0 <= stamp < 1 << 62:
        raise InputError(f"stamp_ns of contacts is {stamp!r:.40}, expected ns since the epoch")
    if not isinstance(told, list) or len(told) > MOST or not all(type(x) is dict for x in told):
        raise InputError(f"contacts are no list of at most {MOST} objects, expected that")
    places = {patch.name: place for place, patch in enumerate(skin)}
    rows, by = np.zeros(len(told), CONTACT), []
    for row, each in zip(rows, told, strict=True):
        _fill(row, each, places)
        if each.get("by") not in FINDERS:
            raise InputError(f"a contact is by {each.get('by')!r:.40}, expected engine or fit")
        by.append(str(each["by"]))
    return Contacts(stamp, rows, by)


def _fill(row: Any, plain: Mapping[str, Any], places: Mapping[str, int]) -> None:
    patch, track = plain.get("patch"), plain.get("track")
    if not isinstance(patch, str) or patch not in places:
        raise InputError(f"a contact is on patch {patch!r:.40}, expected one of the skin")
    if type(track) is not int or not 0 <= track < 1 << 62:
        raise InputError(f"a contact is numbered {track!r:.40}, expected a whole number")
    row["patch"], row["track"] = places[patch], track
    for name in VECTORS:
        values = plain.get(name)
        if not isinstance(values, list) or len(values) != 3:
            raise InputError(f"{name} of a contact is {values!r:.40}, expected three numbers")
        row[name] = [_number(name, each, FAR) for each in values]
    moments = plain.get("moments")
    if not isinstance(moments, list) or len(moments) != 3:
        raise InputError(f"moments of a contact are {moments!r:.40}, expected three numbers")
    row["moments"] = [_perhaps("moments", each) for each in moments]
    for name in SURE:
        row[name] = _number(name, plain.get(name), FAR)
    for name in PERHAPS:
        row[name] = _perhaps(name, plain.get(name))


def _number(name: str, value: Any, most: float) -> float:
    good = type(value) in (int, float) and abs(value) <= most
    if not good:
        raise InputError(f"{name} of a contact is {value!r:.40}, expected at most {most:g}")
    return float(value)


def _perhaps(name: str, value: Any) -> float:
    return math.nan if value is None else _number(name, value, LARGE)
