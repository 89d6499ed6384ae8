"""Settings as text: what JSON holds of layouts, elastomers, solvers and calibrations, exactly."""

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from skinfield.errors import FileError, InputError


@lru_cache(maxsize=1)
def _kinds() -> Mapping[str, type]:
    """What a file may name; nothing else is ever made from one."""
    from skinfield.conditioning import Calibration, CySkinCount, ICubByte, PlainCount
    from skinfield.contacts import ContactFinder
    from skinfield.inverse import (
        ContactFit,
        GaussianField,
        Inverse,
        NonNegative,
        PseudoInverse,
        Tikhonov,
    )
    from skinfield.layout import Patch
    from skinfield.mechanics import BondedLayer, HalfSpace, Layer
    from skinfield.observation import BaseStress, Capacitance, Gap
    from skinfield.pipeline.intervals import Group, Intervals, Ratio

    known = (
        *(Patch, Layer, BondedLayer, HalfSpace, Capacitance, BaseStress, Gap, ContactFinder),
        *(GaussianField, Tikhonov, PseudoInverse, Inverse, NonNegative, ContactFit),
        *(Calibration, ICubByte, CySkinCount, PlainCount, Intervals, Group, Ratio),
    )
    return {kind.__name__: kind for kind in known}


def plain_from_value(name: str, value: Any) -> Any:
    """A value in what JSON knows; `value_from_plain` makes an equal one of it.

    Parameters
    ----------
    name : str
        Of the value, for messages.
    value : object
        None, a truth, number, text, array, tuple, or one of skinfield's own settings.

    Raises
    ------
    InputError
        For anything else, such as a solver or a function of one's own.
    """
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else {"float": repr(value)}
    if isinstance(value, type) and value in (np.float32, np.float64):
        return {"type": value.__name__}
    if isinstance(value, np.generic):
        return plain_from_value(name, value.item())
    if isinstance(value, np.ndarray) and value.dtype.kind in "fiub":
        values = [plain_from_value(name, item) for item in value.ravel().tolist()]
        return {"array": value.dtype.str, "shape": list(value.shape), "values": values}
    if isinstance(value, tuple):
        return [plain_from_value(f"{name}[{k}]", item) for k, item in enumerate(value)]
    if is_dataclass(value) and _kinds().get(type(value).__name__) is type(value):
        parts = {
            each.name: plain_from_value(f"{name}.{each.name}", getattr(value, each.name))
            for each in fields(value)
            if each.init
        }
        return {"is": type(value).__name__, **parts}
    raise InputError(
        f"{name} is a {type(value).__name__}, which results cannot hold, expected one of "
        f"{', '.join(_kinds())}: a file names only what skinfield itself can make again"
    )


def value_from_plain(name: str, plain: Any) -> Any:
    """Undo `plain_from_value`; raises FileError for what it never writes."""
    if isinstance(plain, list):
        return tuple(value_from_plain(f"{name}[{k}]", item) for k, item in enumerate(plain))
    if not isinstance(plain, dict):
        return plain
    if "float" in plain:
        return _made(name, float, plain["float"])
    if "type" in plain:
        return {"float32": np.float32, "float64": np.float64}.get(str(plain["type"]))
    if "array" in plain:
        return _made(name, _array, plain)
    kind = _kinds().get(str(plain.get("is")))
    if kind is None:
        raise FileError(
            f"{name} is a {str(plain.get('is'))[:40]!r}, expected one of {', '.join(_kinds())}: "
            "written by a newer skinfield?"
        )
    parts = {key: value_from_plain(f"{name}.{key}", item) for key, item in plain.items()}
    del parts["is"]
    known = {each.name for each in fields(kind) if each.init}
    if parts.keys() != known:
        odd = ", ".join(sorted(str(key)[:40] for key in parts.keys() ^ known))
        raise FileError(
            f"{name} is a {kind.__name__} with other settings than this skinfield's ({odd}), "
            "expected the same: open it with the version that wrote it"
        )
    return _made(name, kind, parts)


def _array(plain: Mapping[str, Any]) -> Any:
    if plain["array"][1:] not in ("f8", "f4", "i8", "i4", "u8", "b1"):
        raise ValueError(f"{plain['array']!r} is no type of an array here")
    values = [value_from_plain("values", item) for item in plain["values"]]
    return np.array(values, dtype=plain["array"]).reshape(plain["shape"])


def _made(name: str, make: Any, plain: Any) -> Any:
    """What a maker makes; whatever it raises is the file's fault."""
    try:
        return make(**plain) if isinstance(make, type) and make is not float else make(plain)
    except Exception as error:
        raise FileError(f"{name} cannot be made: {str(error)[:300]}; is the file whole?") from error
