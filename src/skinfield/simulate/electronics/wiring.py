"""Which converter a taxel hangs on, when in a cycle it is converted, and what it picks up there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints, check_finite, check_range, check_shape
from skinfield.layout import Patch

INPUTS = 12
"""Of a converter that are converted in turn: a module of these skins has up to twelve taxels."""


@dataclass(frozen=True, eq=False)
class Wiring:
    """Converter (L,) and stage (L,) of each taxel: a converter converts its stages in turn."""

    converter: Ints
    stage: Ints

    @property
    def converters(self) -> int:
        """How many there are."""
        return int(self.converter.max()) + 1

    @property
    def neighbours(self) -> NDArray[np.bool_]:
        """Pairs (L, L) at one converter whose stages follow on each other."""
        same = self.converter[:, None] == self.converter
        return np.asarray(same & (np.abs(self.stage[:, None] - self.stage) == 1))


def wiring(patch: Patch) -> Wiring:
    """Wiring of a patch, from its modules and channels.

    Every twelve channels of a module are the stages of one converter. They are counted from
    channel 0 of the port where its width is a multiple of twelve, as on an iCub, where thermal and
    absent channels keep their places; else from the module's first.
    """
    channel = patch.channel.copy()
    if patch.n_channels % INPUTS:
        for module in np.unique(patch.module):
            rows = patch.module == module
            channel[rows] -= channel[rows].min()
    both = np.column_stack([patch.module, channel // INPUTS])
    converter = np.unique(both, axis=0, return_inverse=True)[1].reshape(-1)
    return Wiring(converter.astype(np.int64), (channel % INPUTS).astype(np.int64))


@dataclass(frozen=True, kw_only=True, eq=False)
class CrossTalk:
    """Part of the change of other taxels that a taxel shows in addition to its own.

    Parameters
    ----------
    neighbours : float
        Of those at the stages before and after it at the same converter. 0: none.
    matrix : (L, L) array, optional
        Added to that: row i is what taxel i picks up of each other one.
    """

    neighbours: float = 0.0
    matrix: Floats | None = None

    def __post_init__(self) -> None:
        check_range("neighbours", self.neighbours, 0.0, 0.5, "a part of the neighbour's change")
        if self.matrix is not None:
            check_finite("matrix", np.asarray(self.matrix), "what taxels pick up of each other")

    def mixing(self, patch: Patch) -> Floats | None:
        """Matrix (L, L) from the changes of the taxels to what they show; None for no mixing."""
        if self.neighbours == 0.0 and self.matrix is None:
            return None
        mixing = np.eye(len(patch)) + self.neighbours * wiring(patch).neighbours
        if self.matrix is not None:
            size = (len(patch), len(patch))
            check_shape("matrix", self.matrix, size, "a row and a column per taxel of the patch")
            mixing += self.matrix
        return mixing
