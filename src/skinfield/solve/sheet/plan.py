"""Plan of a sheet: the ordering of taxels, their Gram matrix, and the profiles that fit."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import Physics
from skinfield.errors import Floats, InputError, Ints, check_range
from skinfield.skin import Grid, Patch
from skinfield.solve.linear import PITCHES, GaussianField, Tikhonov
from skinfield.solve.sheet.response import GROUP, WIDEST, Stamp, Stamps, stamps_on


def lattice_of(patch: Patch, pitch: float, before: int, after: int) -> Grid:
    """Cells over a patch's taxels and what stamps reach beyond.

    Stamps begin `before` - 1 cells before that of a taxel; their last column is `after` cells
    behind it. The outermost taxels stand half a cell away from where that would not hold, as
    nothing is checked when stamps are written.
    """
    places = patch.positions[:, :2]
    low, high = places.min(axis=0), places.max(axis=0)
    columns, rows = np.floor((high - low) / pitch).astype(int).tolist()
    shape = (rows + 2 * before + 1, columns + before + after + 1)
    return Grid(patch, shape, pitch, low - (before - 0.5) * pitch)


@dataclass(frozen=True, eq=False)
class Placing:
    """Taxels in strips of cells, from left to right in each: neighbours lie close in memory.

    Attributes
    ----------
    order : (L,) int32 array
        Row of each taxel in what the caller hands in.
    place : (L, 2) array
        In cells from the lattice's origin, in that order.
    strip : (N + 1,) int array
        Where each strip begins.
    height : float
        Of a strip, in cells.
    """

    order: NDArray[np.int32]
    place: Floats
    strip: Ints
    height: float

    @classmethod
    def of(cls, place: Floats, height: float) -> "Placing":
        """Sort places (L, 2) into strips of some height in cells."""
        row = (place[:, 1] / height).astype(np.int64)
        width = float(place[:, 0].max()) + 1.0
        order = np.argsort(row * width + place[:, 0]).astype(np.int32)  # a strip after another
        strip = np.zeros(int(row.max()) + 2, dtype=np.int64)
        np.cumsum(np.bincount(row), out=strip[1:])
        return cls(order, place[order], strip, height)

    @property
    def cell(self) -> NDArray[np.int32]:
        """Cell that holds each taxel, (L, 2): column and row."""
        return self.place.astype(np.int32)

    @property
    def offset(self) -> Floats:
        """Place in the cell, (L, 2), 0 to 1."""
        return self.place - np.floor(self.place)

    def corner(self, reach: int, columns: int) -> NDArray[np.int32]:
        """Flat index of the first cell of a stamp that reaches some cells, (L,)."""
        column, row = (self.cell - (reach - 1)).T
        return np.asarray(row * columns + column)


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

    @cached_property
    def lower(self) -> Any:
        """What lies below the diagonal, as a sparse matrix of SciPy."""
        from scipy.sparse import csr_array

        taxels = len(self.own)
        return csr_array((self.value, self.other, self.start), shape=(taxels, taxels))


def gram_of(placing: Placing, offset: NDArray[Any], stamps: Stamps) -> Gram:
    """Sum the products of the stamps of all neighbours; in the precision of `offset` (L, 2)."""
    from skinfield.solve.sheet.kernels import fill_pairs, search

    taxels, reach, precision = len(placing.order), stamps.neighbours, offset.dtype.type
    back = int(np.ceil(reach / placing.height - 1e-9))
    count, _ = search(placing.place, placing.strip, reach, back)
    room = -(-count // GROUP) * GROUP
    gram = Gram(
        np.append(0, np.cumsum(room)),
        np.repeat(np.arange(taxels, dtype=np.int32), room),
        np.zeros(room.sum(), dtype=precision),
        np.empty(taxels, dtype=precision),
    )
    ends = np.append(placing.strip, np.full(back + 1, taxels))[back + 1 :]
    read, spread = parts_of(stamps.read, precision), parts_of(stamps.spread, precision)
    fill_pairs(
        placing.place,
        offset,
        placing.strip,
        reach,
        back,
        read,
        spread,
        int((ends - placing.strip).max()),
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


LARGEST = 1 << 30  # cells
EXPECTED = 2000  # cells per taxel, more than which is a slip of units or a taxel gone astray
STRIPS = 3  # per reach: low ones give all taxels about as many earlier neighbours as later ones
LOCAL = 12.0  # cells: taxels farther apart have a prior as if they stood so near


class SheetPlan:
    """Lattice, stamps and the matrix of the taxels.

    Attributes
    ----------
    lattice : Grid
        Of cells that hold the stamps of all taxels.
    placing : Placing
        The taxels' order; what follows is in it.
    stamps : Stamps
    offset : (L, 2) array
        Of the taxels in their cells.
    corner : (L,) int array
        First cell of the pressure that a taxel adds.
    share : (L,) array
        Of the noise in a reading's deviation, as the prior has it.
    variance : float, Pa²
        Of a cell, as the prior has it.
    gram : Gram
        Scaled to a diagonal of 1.
    scale, gain : (L,) arrays
        From readings to the system's right side, and from its answer to the stamps' values.
    length_scale : float, m
        Of the prior; 0 for one of independent cells.
    """

    def __init__(
        self,
        patch: Patch,
        noise_std: Floats,
        physics: Physics,
        solver: GaussianField | Tikhonov,
        pitch: float,
        cut: float,
        precision: type[np.floating[Any]],
    ) -> None:
        check_range("pitch", pitch, 1e-6, 1.0, "the side of a cell, in metres")
        check_range("cut", cut, 1e-6, 0.1, "a share of a response's peak")
        places = patch.positions[:, :2]  # its plane, which takes its surface: few ask for that
        _check_extent(len(places), np.ptp(places, axis=0) / pitch)
        self.length_scale = _length_scale(solver, places, pitch)
        self.stamps = stamps = stamps_on(physics, pitch, cut, self.length_scale / pitch)
        spread = stamps.spread
        both = (spread, stamps.read)
        before = max(stamp.reach for stamp in both)
        after = max(stamp.width - stamp.reach for stamp in both)
        self.lattice = lattice_of(patch, pitch, before, after)
        height = stamps.neighbours / STRIPS
        self.placing = Placing.of((places - self.lattice.origin) / pitch, height)
        for stamp in both:
            _check_inside(self.lattice, self.placing, stamp)
        self.offset = self.placing.offset.astype(precision)
        self.gram = gram_of(self.placing, self.offset, stamps)
        self.corner = self.placing.corner(spread.reach, self.lattice.shape[1])
        noise_std = noise_std[self.placing.order]
        own = self.gram.own / noise_std**2
        self.variance = solver.snr**2 / float(np.mean(own))
        share = 1.0 / np.sqrt(1.0 + self.variance * own)
        white, self.share = share / noise_std, share.astype(precision)
        self.scale = white.astype(precision)
        self.gain = (self.variance * white).astype(precision)
        weight, gram = (np.sqrt(self.variance) * white).astype(precision), self.gram
        gram.value[:] *= np.repeat(weight, np.diff(gram.start))
        gram.value[:] *= weight[gram.other]


def _length_scale(solver: object, places: Floats, pitch: float) -> float:
    """Of the prior's smoothness, m; 0 for none."""
    from skinfield.solve.sheet.kernels import search

    if isinstance(solver, Tikhonov):
        return 0.0
    if not isinstance(solver, GaussianField):
        raise InputError(
            f"solver is {solver!r}, expected GaussianField(...) or Tikhonov(...): a sheet is "
            "solved for these two priors"
        )
    if solver.length_scale is not None:
        return float(solver.length_scale)
    placing = Placing.of((places - places.min(axis=0)) / pitch, LOCAL)
    nearest = search(placing.place, placing.strip, LOCAL, 1)[1]
    return PITCHES * pitch * float(np.median(nearest))


def _check_inside(lattice: Grid, placing: Placing, stamp: Stamp) -> None:
    """Raise InputError unless a stamp of every taxel lies on the lattice.

    Compiled code writes stamps unchecked. A cell is farther than rounding from where this fails,
    unless the taxels stand so far from the origin that their coordinates cannot tell cells apart.
    """
    first = placing.cell.astype(np.int64) - (stamp.reach - 1)
    end = first.max(axis=0) + np.array([stamp.width, 2 * stamp.reach])
    if first.min() < 0 or (end > lattice.shape[::-1]).any():
        raise InputError(
            f"positions lie at about {lattice.origin.tolist()} m, where rounding moves them by "
            f"cells of {lattice.pitch:g} m: expected metres from an origin on or near the sheet"
        )


def _check_extent(taxels: int, cells: Floats) -> None:
    count = float(np.prod(cells + 2 * WIDEST))
    if count > LARGEST or count > EXPECTED * (taxels + 1000):
        raise InputError(
            f"positions span {cells[0]:.4g} x {cells[1]:.4g} cells for {taxels} taxels, expected "
            f"at most {EXPECTED} cells per taxel: give metres, larger cells, or each piece of "
            "skin a sheet of its own"
        )
