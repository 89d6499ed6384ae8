"""All of a sheet that needs no reading."""

from typing import Any

import numpy as np

from skinfield.errors import Floats, InputError, check_range
from skinfield.inverse.gaussian_field import PITCHES, GaussianField
from skinfield.inverse.sheet.gram import gram_of
from skinfield.inverse.sheet.placing import Lattice, Placing, nearest_distance
from skinfield.inverse.sheet.response import WIDEST
from skinfield.inverse.sheet.stamps import Stamp, Stamps
from skinfield.inverse.tikhonov import Tikhonov
from skinfield.mechanics import Layer, Mechanics
from skinfield.observation import Quantity

LARGEST = 1 << 30  # cells
EXPECTED = 2000  # cells per taxel, more than which is a slip of units or a taxel gone astray
STRIPS = 3  # per reach: low ones give all taxels about as many earlier neighbours as later ones
LOCAL = 12.0  # cells among which a taxel's nearest neighbour is looked for


class SheetPlan:
    """Lattice, stamps and the matrix of the taxels.

    Attributes
    ----------
    lattice : Lattice
    placing : Placing
        The taxels' order; what follows is in it.
    stamps : Stamps
    offset : (L, 2) array
        Of the taxels in their cells.
    corner : (L,) int array
        First cell of the pressure that a taxel adds.
    noise_std : (L,) array, unit of the reading
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
        places: Floats,
        noise_std: Floats,
        layer: Layer,
        mechanics: Mechanics,
        quantity: Quantity,
        solver: GaussianField | Tikhonov,
        pitch: float,
        pad_diameter: float,
        cut: float,
        precision: type[np.floating[Any]],
    ) -> None:
        check_range("pitch", pitch, 1e-6, 1.0, "the side of a cell, in metres")
        check_range("cut", cut, 1e-6, 0.1, "a share of a response's peak")
        low, high = places.min(axis=0), places.max(axis=0)
        _check_extent(len(places), (high - low) / pitch)
        self.length_scale = _length_scale(solver, (places - low) / pitch, pitch)
        self.stamps = stamps = Stamps.of(
            mechanics, layer, quantity, pitch, pad_diameter, cut, self.length_scale / pitch
        )
        spread = stamps.spread
        both = (spread, stamps.read)
        before = max(stamp.reach for stamp in both)
        after = max(stamp.width - stamp.reach for stamp in both)
        self.lattice = Lattice.around(low, high, pitch, before, after)
        height = stamps.neighbours / STRIPS
        self.placing = Placing.of((places - self.lattice.origin) / pitch, height)
        for stamp in both:
            _check_inside(self.lattice, self.placing, stamp)
        self.gram = gram_of(self.placing, stamps, precision)
        self.offset = self.placing.offset.astype(precision)
        self.corner = self.placing.corner(spread.reach, self.lattice.shape[1])
        self.noise_std = noise_std[self.placing.order]
        self._scale(self.noise_std, solver.snr)

    def _scale(self, noise_std: Floats, snr: float) -> None:
        """Give the prior its variance and the matrix its diagonal."""
        from skinfield.inverse.sheet.gram_kernel import scale_pairs

        own = self.gram.own / noise_std**2
        self.variance = snr**2 / float(np.mean(own))
        diagonal = np.sqrt(1.0 + self.variance * own)
        precision = self.gram.value.dtype
        white = 1.0 / (noise_std * diagonal)
        self.scale = white.astype(precision)
        self.gain = (self.variance * white).astype(precision)
        weight = (np.sqrt(self.variance) * white).astype(precision)
        scale_pairs(self.gram.start, self.gram.other, weight, self.gram.value)


def _length_scale(solver: object, places: Floats, pitch: float) -> float:
    """Of the prior's smoothness, m; 0 for none."""
    if isinstance(solver, Tikhonov):
        return 0.0
    if not isinstance(solver, GaussianField):
        raise InputError(
            f"solver is {solver!r}, expected GaussianField(...) or Tikhonov(...): a sheet is "
            "solved for these two priors"
        )
    if solver.length_scale is not None:
        return float(solver.length_scale)
    return PITCHES * pitch * nearest_distance(Placing.of(places, LOCAL))


def _check_inside(lattice: Lattice, placing: Placing, stamp: Stamp) -> None:
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
