"""What taxels read of each other's pressure: a sparse symmetric matrix."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Ints
from skinfield.inverse.sheet.placing import Placing
from skinfield.inverse.sheet.stamps import Stamp, Stamps


@dataclass(frozen=True, eq=False)
class Gram:
    """A Q A^T of the sheet's taxels: its diagonal and, by rows, what lies below it.

    Attributes
    ----------
    start : (L + 1,) int array
        Where each taxel's entries begin.
    other : (N,) int32 array
        Earlier neighbour of each entry.
    value : (N,) array
    own : (L,) array
        The diagonal.
    """

    start: Ints
    other: NDArray[np.int32]
    value: NDArray[Any]
    own: NDArray[Any]

    @property
    def nbytes(self) -> int:
        """Memory of the matrix."""
        return sum(part.nbytes for part in (self.start, self.other, self.value, self.own))


def gram_of(placing: Placing, stamps: Stamps, precision: type[Any]) -> Gram:
    """Sum the products of the stamps of all taxels that are neighbours."""
    from skinfield.inverse.sheet.gram_kernel import count_pairs, fill_pairs

    taxels, reach = len(placing.order), stamps.neighbours
    start = np.empty(taxels + 1, dtype=np.int64)
    count_pairs(placing.place, placing.strip, reach, start)
    gram = Gram(
        start,
        np.empty(start[-1], dtype=np.int32),
        np.empty(start[-1], dtype=precision),
        np.empty(taxels, dtype=precision),
    )
    most = int(np.diff(placing.strip).max())
    ring = np.empty((2, most, 2 * stamps.read.reach, 2 * stamps.read.reach), dtype=precision)
    fill_pairs(
        placing.place,
        placing.cell,
        placing.offset.astype(precision),
        placing.strip,
        reach,
        parts_of(stamps.read, precision),
        parts_of(stamps.spread, precision),
        ring,
        start,
        gram.other,
        gram.value,
        gram.own,
    )
    return gram


def parts_of(stamp: Stamp, precision: type[Any]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Table, signs and room for one taxel's profiles, as the kernels take them."""
    table = stamp.table.astype(precision)
    return table, stamp.sign.astype(precision), np.empty((2, *table.shape[1:]), dtype=precision)
