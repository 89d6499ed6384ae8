"""What taxels read of each other's pressure: a sparse symmetric matrix."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Ints
from skinfield.inverse.sheet.placing import Placing
from skinfield.inverse.sheet.stamps import GROUP, Stamp, Stamps

TOO_DENSE = (
    "positions are so dense that what is cut off their responses outweighs the noise, and no "
    "pressure is the best: expected taxels some cells apart; use a smaller cut, such as 1e-4, or a "
    "Reconstructor"
)


@dataclass(frozen=True, eq=False)
class Gram:
    """A Q A^T of the sheet's taxels: its diagonal and, by rows, what lies below it.

    Attributes
    ----------
    start : (L + 1,) int array
        Where each taxel's entries begin; their number is a multiple of `GROUP`, the last are the
        taxel itself with a value of 0.
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
    back = int(np.ceil(reach / placing.height - 1e-9))
    count = np.empty(taxels, dtype=np.int64)
    count_pairs(placing.place, placing.strip, reach, back, count)
    room = -(-count // GROUP) * GROUP
    gram = Gram(
        np.append(0, np.cumsum(room)),
        np.repeat(np.arange(taxels, dtype=np.int32), room),
        np.zeros(room.sum(), dtype=precision),
        np.empty(taxels, dtype=precision),
    )
    ends = placing.strip[
        np.minimum(np.arange(len(placing.strip)) + back + 1, len(placing.strip) - 1)
    ]
    read, spread = parts_of(stamps.read, precision), parts_of(stamps.spread, precision)
    fill_pairs(
        placing.place,
        placing.cell,
        placing.offset.astype(precision),
        placing.strip,
        reach,
        read,
        spread,
        np.empty(back + 1, dtype=np.int64),
        np.empty(count.max(), dtype=np.int64),
        np.empty((int((ends - placing.strip).max()), read[4], read[5]), dtype=precision),
        gram.start,
        gram.other,
        gram.value,
        gram.own,
    )
    return gram


def parts_of(stamp: Stamp, precision: type[Any]) -> tuple[Any, ...]:
    """Take a stamp as the kernels do.

    Returns
    -------
    across, down : (STEPS + 1, N) arrays
        Profiles along x, all cells of a part together, and along y times the parts' signs, all
        `GROUP` parts of a cell together.
    along_x, along_y : (N,) arrays
        Room for those of one taxel.
    rows, width : int
        Cells that are added to; `width` is a multiple of `LANES`, the profiles' last cells are 0.
    """
    steps, parts, rows = stamp.table.shape
    across = np.zeros((steps, parts, stamp.width), dtype=precision)
    across[..., :rows] = stamp.table
    signed = (stamp.table * stamp.sign[:, None]).reshape(steps, -1, GROUP, rows)
    down = np.ascontiguousarray(np.swapaxes(signed, 2, 3), dtype=precision)
    across, down = across.reshape(steps, -1), down.reshape(steps, -1)
    return across, down, np.empty_like(across[0]), np.empty_like(down[0]), rows, stamp.width
