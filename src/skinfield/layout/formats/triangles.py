"""The triangular boards that skinGui draws, in the units of their drawings."""

from dataclasses import dataclass, field

import numpy as np

from skinfield.errors import Floats
from skinfield.layout.patch import Ints

PADS = 12  # channels of a board, thermal ones included


def _local(*places: tuple[float, float]) -> Floats:
    return np.array(places, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Board:
    """One type of triangle.

    Parameters
    ----------
    pads : (P,) int array
        Channels of the board that are taxels, 0 to 11.
    places : (P, 2) array, mm
        Of these pads about the board's centre.
    lattice : float, mm per drawing unit
        Of the places of the boards in a drawing.
    pad_diameter : float, m
    """

    name: str
    pads: Ints
    places: Floats
    lattice: float
    pad_diameter: float = field(default=4e-3)


TRIANGLE = Board(
    "triangle",
    np.arange(12),
    _local(
        (7.5, -1.443), (10.0, -5.774), (5.0, -5.774), (0.0, -2.887), (-5.0, -5.774),
        (-10.0, -5.774), (-7.5, -1.443), (-2.5, 1.443), (-2.5, 7.217), (0.0, 11.547),
        (2.5, 7.217), (2.5, 1.443),
    ),
    lattice=1.0,
)  # fmt: skip
"""Drawn in millimetres: 30 mm sides, pads 5.0 mm apart."""

TRIANGLE_10PAD = Board(
    "triangle_10pad",
    np.array([0, 1, 2, 3, 4, 5, 7, 8, 9, 11]),
    1.016
    * _local(
        (6.430, 0.0), (9.646, -5.571), (3.216, -5.571), (0.0, 0.0), (-3.216, -5.571),
        (-9.646, -5.571), (-6.430, 0.0), (-3.216, 5.571), (0.0, 11.139), (3.216, 5.571),
    ),
    lattice=1.0457,
)  # fmt: skip
"""Drawn 1.6 % too small: the pads of a built foot are 6.533 mm apart, not 6.430; its boards are
19.32 mm apart where the drawing's lattice (32 units of side) has 18.475. Pads 6 and 10 are thermal.
"""

BOARDS = {board.name: board for board in (TRIANGLE, TRIANGLE_10PAD)}


def drawn(board: Board, angle: float, mirrored: bool) -> Floats:
    """Places (P, 2) mm of a board's pads, mirrored in x first, then turned by `angle` (rad)."""
    cos, sin = np.cos(angle), np.sin(angle)
    places = board.places * ([-1.0, 1.0] if mirrored else [1.0, 1.0])
    return np.asarray(places @ np.array([[cos, sin], [-sin, cos]]))
