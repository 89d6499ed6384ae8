"""Patches from numbers: hexagon, triangular modules, arrays, cylinders, spheres; by name too."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_choice,
    check_count,
    check_finite,
    check_positive,
    check_range,
    check_shape,
)
from skinfield.skin.patch import Patch

Points = tuple[tuple[float, float], ...]


@dataclass(frozen=True, kw_only=True)
class ModuleTemplate:
    """One board with its taxels, about its centroid.

    Parameters
    ----------
    taxels : sequence of (x, y), m
        Centres of the pads, in the order of their numbers on the board.
    pad_diameter : float, m
    apex : +1 or -1
        Whether a corner of the triangle points to +y or to -y.
    side : float, m
        Of the triangle.
    channels : sequence of int, optional
        Number of each taxel on the board. Default 0, 1, 2, …
    n_channels : int, optional
        Numbers of the board, those of its thermal pads included. Default the number of taxels.
    """

    taxels: Points
    pad_diameter: float
    apex: int = 1
    side: float = 30e-3
    channels: tuple[int, ...] = ()
    n_channels: int = 0

    def __post_init__(self) -> None:
        check_positive("pad_diameter", self.pad_diameter, "of a round pad, in metres")
        check_positive("side", self.side, "of the triangle, in metres")
        if not self.taxels:
            raise InputError("taxels is empty, expected one (x, y) in metres or more per module")
        if self.apex not in (1, -1):
            raise InputError(f"apex is {self.apex!r}, expected 1 for a corner at +y or -1 at -y")
        channels = tuple(self.channels) or tuple(range(len(self.taxels)))
        if len(channels) != len(self.taxels) or len(set(channels)) < len(channels):
            raise InputError(
                f"channels is {channels}, expected {len(self.taxels)} different numbers: "
                "one per taxel of the module"
            )
        count = self.n_channels or max(channels) + 1
        if min(channels) < 0 or max(channels) >= count:
            raise InputError(f"channels is {channels}, expected numbers from 0 to {count - 1}")
        object.__setattr__(self, "channels", channels)
        object.__setattr__(self, "n_channels", count)


def _millimetres(*taxels: tuple[float, float]) -> Points:
    return tuple((x * 1e-3, y * 1e-3) for x, y in taxels)


def _lattice(pitch: float, *taxels: tuple[int, int]) -> Points:
    """Pads of a triangular lattice, in steps of half a pitch to the right and of pitch / √12 up."""
    return tuple((x * pitch / 2, y * pitch / 12**0.5) for x, y in taxels)


# The module of the patch in "Real-Time Reconstruction of Contact Shapes for Large Area Robot
# Skin": triples of pads at 5.5 mm, one in the middle and one at 15 mm / √3 towards each corner.
PAPER_TRIANGLE = ModuleTemplate(
    taxels=_millimetres(
        (4.75, 5.9178),
        (10.25, 5.9178),
        (7.5, 1.1547),
        (2.75, -1.5877),
        (2.75, -7.0725),
        (0.0, -11.8357),
        (-2.75, -7.0725),
        (-2.75, -1.5877),
        (-7.5, 1.1547),
        (-10.25, 5.9178),
        (-4.75, 5.9178),
        (0.0, 3.1754),
    ),
    pad_diameter=4e-3,
    apex=-1,
)
# The numbers and places of `Triangle.h` of iCubSkinGui: every second gap of the lattice is free,
# and the nearest pads are 5.0 mm apart.
ICUB_TRIANGLE = ModuleTemplate(
    taxels=_lattice(
        5e-3,
        (3, -1),
        (4, -4),
        (2, -4),
        (0, -2),
        (-2, -4),
        (-4, -4),
        (-3, -1),
        (-1, 1),
        (-1, 5),
        (0, 8),
        (1, 5),
        (1, 1),
    ),
    pad_diameter=4e-3,
)
# `Triangle_10pad.h`: rows of 4, 3, 2 and 1 pads; 6 and 10 are thermal pads and no taxels. Its
# drawing makes the pads 1.1 times as large as those of the older board.
TEN_PAD_TRIANGLE = ModuleTemplate(
    taxels=_lattice(
        6.43e-3,
        (2, 0),
        (3, -3),
        (1, -3),
        (0, 0),
        (-1, -3),
        (-3, -3),
        (-2, 0),
        (-1, 3),
        (0, 6),
        (1, 3),
    ),
    pad_diameter=4.4e-3,
    channels=(0, 1, 2, 3, 4, 5, 7, 8, 9, 11),
    n_channels=12,
)


MAX_MODULES = 16  # of the reference skin: four I²C buses of four modules at one microcontroller
RADIUS72 = 33.464e-3 / 3**0.5  # from the middle of hexagon72 to its modules


def triangle_modules(
    template: ModuleTemplate,
    centroids: ArrayLike,
    rotations: ArrayLike,
    *,
    name: str = "triangles",
    max_modules: int = MAX_MODULES,
) -> Patch:
    """Flat patch of modules, each laid at its own centroid, turned by its own angle.

    Module m hangs on bus m // 4. Taxel t of module m has channel m * n_channels + channels[t] and
    uid m << 4 | channels[t] + 1, the numbering of CySkin, whose sensor 0 is a thermometer.

    Parameters
    ----------
    template : ModuleTemplate
    centroids : (M, 2) array, m
    rotations : (M,) array, rad
        Counter-clockwise.
    name : str
        Of the patch.
    max_modules : int
        What the electronics carry: 16 for the reference skin.

    Raises
    ------
    InputError
        When there are more than `max_modules` modules, or none.
    """
    centroids, rotations = as_floats("centroids", centroids), as_floats("rotations", rotations)
    check_shape("centroids", centroids, (None, 2), "x and y of each module, in metres")
    check_shape("rotations", rotations, (len(centroids),), "one angle per module, in radians")
    check_finite("centroids", centroids, "each module has a place")
    check_finite("rotations", rotations, "each module has an angle")
    modules = len(centroids)
    if not 1 <= modules <= max_modules:
        raise InputError(
            f"centroids has {modules} modules, expected 1 to {max_modules}: one microcontroller "
            "carries four I²C buses of four modules; split the skin into more patches, or raise "
            "max_modules where your electronics carry more"
        )
    cosine, sine = np.cos(rotations), np.sin(rotations)
    turn = np.stack([np.stack([cosine, -sine], axis=1), np.stack([sine, cosine], axis=1)], axis=1)
    positions = centroids[:, None] + np.einsum("mij,tj->mti", turn, np.array(template.taxels))
    channel = np.array(template.channels)
    module = np.repeat(np.arange(modules), len(channel))
    return Patch(
        positions.reshape(-1, 2),
        template.pad_diameter,
        module=module,
        uid=(module << 4 | np.tile(channel + 1, modules)).astype(np.uint64),
        channel=module * template.n_channels + np.tile(channel, modules),
        n_channels=modules * template.n_channels,
        name=name,
    )


def triangle_lattice(
    modules: int = 6,
    side: float = 30e-3,
    *,
    template: ModuleTemplate = ICUB_TRIANGLE,
    name: str = "triangles",
    max_modules: int = MAX_MODULES,
) -> Patch:
    """Flat patch of the modules nearest to the origin in a lattice of triangles: 6 are a hexagon.

    Cell (column, row) is the triangle between x = (column - 1) side / 2 and (column + 1) side / 2
    in the strip between y = row h and (row + 1) h, h = √3/2 side. It stands on its base where
    column + row is odd, and hangs from it where even, so that six cells meet at the origin.

    Parameters
    ----------
    modules : int
    side : float, m
        Of a cell.
    template : ModuleTemplate
        What fills each cell, turned so that its corners fall on the cell's.
    name, max_modules
        See `triangle_modules`.
    """
    check_positive("side", side, "of a triangle of the lattice, in metres")
    places = _nearest_cells(modules)
    stands = (places.sum(axis=1) % 2).astype(bool)
    height = side * 0.75**0.5
    y = (places[:, 1] + np.where(stands, 1 / 3, 2 / 3)) * height
    rotations = np.where(stands == (template.apex == 1), 0.0, np.pi)
    centroids = np.column_stack([places[:, 0] * side / 2, y])
    return triangle_modules(template, centroids, rotations, name=name, max_modules=max_modules)


def hexagon72() -> Patch:
    """The patch of the paper: a hexagon of 6 modules of 12 taxels, 54 x 50 mm, pads of 4 mm.

    As its makers calibrated it, about the middle of the hexagon and seen from outside, z up.
    """
    bearings = np.radians([90.0, -30.0, -90.0, -150.0, 150.0, 30.0])
    rotations = np.radians([0.0, -120.0, -60.0, 0.0, -60.0, -60.0])
    return triangle_modules(PAPER_TRIANGLE, _ring(RADIUS72, bearings), rotations, name="hexagon72")


def icub_hexagon() -> Patch:
    """Hexagon of six 12-taxel triangles of the iCub, corners in the middle, pitch 5.0 mm."""
    bearings = np.radians(30.0 + 60.0 * np.arange(6))
    centroids = _ring(ICUB_TRIANGLE.side / 3**0.5, bearings)
    return triangle_modules(ICUB_TRIANGLE, centroids, bearings + np.pi / 2, name="icub_hexagon")


def icub_triangle() -> Patch:
    """One 12-taxel triangle of the iCub, corner at +y."""
    return triangle_modules(ICUB_TRIANGLE, [[0.0, 0.0]], [0.0], name="icub_triangle")


def ten_pad_triangle() -> Patch:
    """One triangle of the newer iCub boards: 10 taxels on 12 channels, pitch 6.43 mm."""
    return triangle_modules(TEN_PAD_TRIANGLE, [[0.0, 0.0]], [0.0], name="ten_pad_triangle")


def _ring(radius: float, bearings: Floats) -> Floats:
    return radius * np.column_stack([np.cos(bearings), np.sin(bearings)])


def _nearest_cells(count: int) -> Floats:
    """`count` cells nearest to the origin, counter-clockwise from +x among those as near."""
    reach = int(abs(count) ** 0.5) + 3
    lattice = np.meshgrid(np.arange(-2 * reach, 2 * reach + 1), np.arange(-reach, reach))
    column, row = (axis.ravel() for axis in lattice)
    x = column / 2
    y = (row + np.where((column + row) % 2 == 1, 1 / 3, 2 / 3)) * 0.75**0.5
    distance = np.round(np.hypot(x, y), 9)
    order = np.lexsort([np.mod(np.arctan2(y, x), 2 * np.pi), distance])
    return np.column_stack([column, row])[order[: max(count, 0)]].astype(np.float64)


MOST = 100_000  # taxels; the largest skins of today have some thousands


def rectangular(
    rows: int = 8, columns: int = 8, pitch: float = 4e-3, pad_diameter: float = 3e-3
) -> Patch:
    """Flat array, centred; taxel row * columns + column, x to the right, y up.

    Parameters
    ----------
    rows, columns : int
    pitch : float, m
        Between neighbours in a row and in a column.
    pad_diameter : float, m
    """
    check_count("rows", rows, 1, MOST, "of taxels")
    check_count("columns", columns, 1, MOST, "of taxels")
    check_positive("pitch", pitch, "between neighbouring taxels, in metres")
    _check_count(rows * columns)
    x, y = np.meshgrid(_centred(columns) * pitch, _centred(rows) * pitch)
    positions = np.column_stack([x.ravel(), y.ravel()])
    return Patch(positions, pad_diameter, uid=_uids(rows * columns), name="rectangular")


def cylinder(
    radius: float = 40e-3,
    length: float = 80e-3,
    arc_angle: float = np.pi,
    pitch: float = 5e-3,
    pad_diameter: float = 4e-3,
) -> Patch:
    """Outside of a cylinder about the y axis, its middle at +z; rows run around it.

    Parameters
    ----------
    radius, length : float, m
    arc_angle : float, rad
        Covered part of the circle, up to 2π; there the taxels close the ring evenly.
    pitch : float, m
        Along the axis and around it; whole pitches fit into `length` and the arc.
    pad_diameter : float, m
    """
    check_positive("radius", radius, "of the cylinder, in metres")
    check_positive("length", length, "of the cylinder, in metres")
    check_positive("pitch", pitch, "between neighbouring taxels, in metres")
    check_range("arc_angle", arc_angle, 0.0, 2 * np.pi + 1e-9, "radians around the cylinder")
    _check_count((1 + radius * arc_angle / pitch) * (1 + length / pitch))
    fit = int(radius * arc_angle / pitch + 1e-9)
    closed = 2 * np.pi * radius - fit * pitch < pitch * (1 - 1e-9)
    around = _centred(max(fit, 1)) * 2 * np.pi / max(fit, 1)
    around = around if closed else _centred(fit + 1) * pitch / radius
    along = _centred(int(length / pitch + 1e-9) + 1) * pitch
    angle, y = (a.ravel() for a in np.meshgrid(around, along))
    normals = np.column_stack([np.sin(angle), np.zeros(len(y)), np.cos(angle)])
    positions = radius * normals + y[:, None] * [0.0, 1.0, 0.0]
    return Patch(
        positions, pad_diameter, normals=normals, uid=_uids(len(positions)), name="cylinder"
    )


def sphere_cap(
    radius: float = 50e-3,
    cap_angle: float = np.pi / 6,
    pitch: float = 5e-3,
    pad_diameter: float = 4e-3,
) -> Patch:
    """Outside of a cap of a sphere about the origin, its pole at +z; taxels lie on rings.

    Parameters
    ----------
    radius : float, m
    cap_angle : float, rad
        From the pole to the rim, up to π.
    pitch : float, m
        From ring to ring along the sphere, and within a ring as nearly as a whole number allows.
    pad_diameter : float, m
    """
    check_positive("radius", radius, "of the sphere, in metres")
    check_positive("pitch", pitch, "between neighbouring taxels, in metres")
    check_range("cap_angle", cap_angle, 0.0, np.pi + 1e-9, "radians from the pole to the rim")
    _check_count(2 * np.pi * (radius / pitch) ** 2 * (1 - np.cos(cap_angle)))
    polar = np.arange(int(radius * cap_angle / pitch + 1e-9) + 1) * pitch / radius
    rings = [
        _ring_positions(angle, radius / pitch, shift=k % 2 / 2) for k, angle in enumerate(polar)
    ]
    normals = np.concatenate(rings)
    return Patch(
        radius * normals, pad_diameter, normals=normals, uid=_uids(len(normals)), name="sphere_cap"
    )


def _ring_positions(polar: float, radius: float, shift: float) -> Floats:
    """Directions (n, 3) at one angle from the pole on a sphere of `radius` pitches."""
    count = max(int(np.round(2 * np.pi * radius * np.sin(polar))), 1)
    around = 2 * np.pi * (np.arange(count) + shift) / count
    return np.column_stack(
        [
            np.sin(polar) * np.cos(around),
            np.sin(polar) * np.sin(around),
            np.full(count, np.cos(polar)),
        ]
    )


def _check_count(taxels: float) -> None:
    if taxels > MOST:
        raise InputError(
            f"the patch would have about {taxels:.3g} taxels, expected at most {MOST}: "
            "check the units, lengths are in metres"
        )


def _centred(count: int) -> Floats:
    return np.asarray(np.arange(count) - (count - 1) / 2, dtype=np.float64)


def _uids(count: int) -> NDArray[np.uint64]:
    """Numbers that no importer takes for a missing taxel (0) or a thermometer (low four bits 0)."""
    row = np.arange(count)
    return np.asarray(row // 12 << 4 | row % 12 + 1, dtype=np.uint64)


GENERATORS: dict[str, Callable[..., Patch]] = {
    "hexagon72": hexagon72,
    "icub_hexagon": icub_hexagon,
    "icub_triangle": icub_triangle,
    "ten_pad_triangle": ten_pad_triangle,
    "triangle_lattice": triangle_lattice,
    "rectangular": rectangular,
    "cylinder": cylinder,
    "sphere_cap": sphere_cap,
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
        if parameter.kind is parameter.KEYWORD_ONLY:
            continue
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
