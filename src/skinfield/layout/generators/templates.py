"""Modules: the triangular boards that skins are tiled from."""

from dataclasses import dataclass

from skinfield.errors import InputError, check_positive

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
