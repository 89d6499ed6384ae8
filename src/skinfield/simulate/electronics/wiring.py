"""Which converter a taxel hangs on, when in a cycle it is converted, and what it picks up there."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, Ints, as_floats, check_finite, check_range, check_shape
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
    def neighbours(self) -> Ints:
        """Pairs (P, 2) of rows at one converter whose stages follow on each other."""
        order = np.lexsort([self.stage, self.converter])
        before, after = order[:-1], order[1:]
        same = self.converter[before] == self.converter[after]
        next_ = self.stage[after] - self.stage[before] == 1
        pairs = np.column_stack([before, after])[same & next_]
        return np.asarray(pairs, dtype=np.int64)


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


@dataclass(frozen=True, kw_only=True)
class CrossTalk:
    """Part of the change of other taxels that a taxel shows in addition to its own.

    Parameters
    ----------
    neighbours : float
        Of those at the stages before and after it at the same converter. 0: none.
    matrix : (L, L) array, optional
        Added to that: row i is what taxel i picks up of each other one. Kept as rows of a tuple,
        so that settings can be compared.
    """

    neighbours: float = 0.0
    matrix: ArrayLike | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        check_range("neighbours", self.neighbours, 0.0, 0.5, "a part of the neighbour's change")
        if self.matrix is not None:
            matrix = np.array(as_floats("matrix", self.matrix))
            check_finite("matrix", matrix, "what taxels pick up of each other")
            check_shape("matrix", matrix, (None, None), "a row and a column per taxel")
            object.__setattr__(self, "matrix", tuple(map(tuple, matrix.tolist())))

    def check_patch(self, patch: Patch) -> None:
        """Raise InputError unless the matrix is one of the patch's taxels."""
        if self.matrix is not None:
            size = (len(patch), len(patch))
            check_shape(
                "matrix", np.asarray(self.matrix), size, "a row and a column per taxel of the patch"
            )

    def shown(self, change: Floats, wiring: Wiring) -> Floats:
        """What taxels show, (T, L), of changes (T, L)."""
        shown = change.copy()
        if self.neighbours:
            before, after = wiring.neighbours.T
            shown[:, before] += self.neighbours * change[:, after]
            shown[:, after] += self.neighbours * change[:, before]
        if self.matrix is not None:
            shown += change @ np.asarray(self.matrix).T
        return shown
