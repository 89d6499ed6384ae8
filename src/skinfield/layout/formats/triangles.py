"""The triangular boards that skinGui draws, and how large its drawings are."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, Ints
from skinfield.layout.generators.templates import ICUB_TRIANGLE, TEN_PAD_TRIANGLE, ModuleTemplate

PADS = 12  # channels of a board, thermal ones included


@dataclass(frozen=True)
class Board:
    """One type of triangle.

    Parameters
    ----------
    name : str
        Of the type in a drawing.
    template : ModuleTemplate
        As drawn, a drawing unit taken as 1 mm.
    built : float
        Size of the real board over the drawn one.
    lattice : float, mm per drawing unit
        Of the places of boards in a drawing.
    """

    name: str
    template: ModuleTemplate
    built: float
    lattice: float

    @property
    def pads(self) -> Ints:
        """Channels of the board that are taxels, (P,)."""
        return np.array(self.template.channels)

    @property
    def pad_diameter(self) -> float:
        """Of a real pad, m."""
        return self.template.pad_diameter * self.built

    def drawn(self, angle: float, mirrored: bool) -> Floats:
        """Places (P, 2) m of the real pads, mirrored in x first, then turned by `angle` (rad)."""
        cos, sin = np.cos(angle), np.sin(angle)
        places = np.array(self.template.taxels) * self.built
        places *= [-1.0 if mirrored else 1.0, 1.0]
        return np.asarray(places @ np.array([[cos, sin], [-sin, cos]]))


# Drawn in millimetres: 30 mm sides, pads 5.0 mm apart.
TRIANGLE = Board("triangle", ICUB_TRIANGLE, built=1.0, lattice=1.0)
# Drawn too small: on a built foot, pads are 6.533 mm apart (drawn 6.430), and neighbouring boards
# 19.32 mm (drawn 18.475, a lattice of 32 units of side).
TRIANGLE_10PAD = Board("triangle_10pad", TEN_PAD_TRIANGLE, built=1.016, lattice=1.0457)

BOARDS = {board.name: board for board in (TRIANGLE, TRIANGLE_10PAD)}
