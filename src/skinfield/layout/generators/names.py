"""Generators by name, as a command line gives them: the one place where a name selects."""

import inspect
from collections.abc import Callable

import numpy as np

from skinfield.errors import InputError, check_choice
from skinfield.layout.generators import sheets, triangles
from skinfield.layout.patch import Patch


def triangle_lattice(modules: int = 6, side: float = 30e-3) -> Patch:
    """Patch of `modules` 12-taxel triangles around the origin; see `triangles.triangle_lattice`."""
    return triangles.triangle_lattice(modules, side)


GENERATORS: dict[str, Callable[..., Patch]] = {
    "hexagon72": triangles.hexagon72,
    "icub_hexagon": triangles.icub_hexagon,
    "icub_triangle": triangles.icub_triangle,
    "ten_pad_triangle": triangles.ten_pad_triangle,
    "triangle_lattice": triangle_lattice,
    "rectangular": sheets.rectangular,
    "cylinder": sheets.cylinder,
    "sphere_cap": sheets.sphere_cap,
}
Parameter = tuple[
    str, type[int] | type[float], float
]  # name of the argument, type, and size of the flag's unit in SI


def by_name(text: str) -> Patch:
    """Patch from a name and, after a colon, what differs from the defaults.

    Parameters
    ----------
    text : str
        Such as ``"hexagon72"`` or ``"rectangular:rows=8,columns=8,pitch_mm=4"``. Lengths are in
        mm, angles in degrees, and the names end so; `known` lists all.

    Raises
    ------
    InputError
        When the name, an argument or its value is not known; the message lists what is.
    """
    name, _, given = text.strip().partition(":")
    if name not in GENERATORS:
        raise InputError(
            f"generator is {name!r}, expected one of these, each with the arguments that differ "
            f"from the defaults shown: {'; '.join(known())}"
        )
    parameters = _parameters(name)
    values: dict[str, float] = {}
    for entry in filter(None, (part.strip() for part in given.split(","))):
        flag, _, value = (part.strip() for part in entry.partition("="))
        if not parameters:
            raise InputError(f"argument of {name} is {entry!r}, expected none: it has no settings")
        check_choice(f"argument of {name}", flag, parameters, f"it is called as {_usage(name)}")
        argument, kind, unit = parameters[flag]
        if argument in values:
            raise InputError(f"argument {flag} of {name} is given twice, expected once")
        values[argument] = _number(f"{flag} of {name}", value, kind) * unit
    return GENERATORS[name](**values)


def known() -> list[str]:
    """How each generator is called, with its defaults: ``"rectangular:rows=8,…"``."""
    return [_usage(name) for name in GENERATORS]


def _parameters(name: str) -> dict[str, Parameter]:
    """Flags of a generator; whole numbers are counts, ``…_angle`` is in degrees, the rest in mm."""
    flags: dict[str, Parameter] = {}
    for argument, parameter in inspect.signature(GENERATORS[name]).parameters.items():
        if parameter.annotation is int:
            flags[argument] = (argument, int, 1)
        elif argument.endswith("_angle"):
            flags[f"{argument}_deg"] = (argument, float, np.pi / 180)
        else:
            flags[f"{argument}_mm"] = (argument, float, 1e-3)
    return flags


def _usage(name: str) -> str:
    signature = inspect.signature(GENERATORS[name])
    values = [
        f"{flag}={signature.parameters[argument].default / unit:g}"
        for flag, (argument, _, unit) in _parameters(name).items()
    ]
    return name + (":" + ",".join(values) if values else "")


def _number(name: str, text: str, kind: type[int] | type[float]) -> float:
    try:
        return kind(text)
    except ValueError:
        what = "a whole number" if kind is int else "a number"
        raise InputError(f"{name} is {text!r}, expected {what}") from None
