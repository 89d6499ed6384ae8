r"""Response of an elastic layer on a lattice of cells, and stamps: products of profiles for it.

A kernel that is even in x and y and equal in both is a symmetric matrix on a fine lattice, so

.. math:: k(x, y) = \sum_r s_r\, v_r(x)\, v_r(y), \qquad s_r = \pm 1,

with profiles that are its eigenvectors. The kernels of an elastic layer are so smooth that four of
them reach some 1e-4 of the peak. What a taxel at any offset from the lattice does to the cells
around is then known from tables of one variable, which stay in the nearest cache.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from skinfield.elastic import Physics
from skinfield.elastic.lattice import mirrored
from skinfield.errors import Floats, InputError
from skinfield.skin import Grid, Patch

FINE = 16  # samples per cell of a kernel
WIDEST = 32  # cells from a taxel to the end of its stamp


# A kernel is what a taxel feels of a pressure on one cell, in the unit of the reading per Pa: a
# quadrant (FINE reach + 1, FINE reach + 1) by the offset in x and y from 0, in steps of 1 / FINE
# of a cell, to `reach` cells from the taxel, where it ends.


def response(physics: Physics, pitch: float, offsets: Floats) -> Floats:
    """What a taxel reads of a cell at offsets (N, 2) in cells: (N,) in its unit per Pa."""
    pad = physics.pad_diameter
    cell = Grid(Patch(np.zeros((1, 2)), pad, name="sheet"), (1, 1), pitch, np.zeros(2))
    places = offsets * pitch
    matrix = physics.quantity.matrix(physics.mechanics, physics.layer, cell, places, pad)
    return np.asarray(matrix[:, 0])


def response_kernel(physics: Physics, pitch: float, cut: float) -> Floats:
    """The response, sampled as far as it exceeds `cut` of its peak."""
    ray = np.arange(4 * WIDEST * 2 + 1) / 4.0
    rays = np.vstack([np.column_stack([ray, share * ray]) for share in (0.0, 1.0)])
    highest = np.abs(response(physics, pitch, rays)).reshape(2, -1).max(axis=0)
    away = np.maximum.reduceat(highest, np.arange(0, len(ray) - 1, 4))
    reach = int(np.flatnonzero(away > cut * highest.max())[-1]) + 1
    if reach > WIDEST:
        raise InputError(
            f"a taxel's response falls to {cut:g} of its peak only {reach} cells away, "
            f"expected within {WIDEST}: a sheet is for short kernels; use larger cells, a "
            "larger cut, BaseStress() or BondedLayer()"
        )
    count = reach * FINE + 1
    i, j = np.tril_indices(count)
    quadrant = np.empty((count, count))
    quadrant[i, j] = quadrant[j, i] = response(physics, pitch, np.column_stack([i, j]) / FINE)
    return quadrant


def convolved(one: Floats, other: Floats) -> Floats:
    """Quadrant (N + M - 1, N + M - 1) of the convolution of two even kernels, by their own."""
    from scipy.fft import irfft2, rfft2  # scipy.signal would take 25 MB

    far = len(one) + len(other) - 2
    size = (2 * far + 1,) * 2
    full = irfft2(rfft2(mirrored(one), size) * rfft2(mirrored(other), size), size)
    return np.asarray(full[far:, far:])


def smoothed_kernel(kernel: Floats, correlation: Floats, cut: float) -> Floats:
    """A kernel convolved with the quadrant (n + 1, n + 1) of a prior's correlation, cut anew."""
    spread = np.zeros(((len(correlation) - 1) * FINE + 1,) * 2)
    spread[::FINE, ::FINE] = correlation
    quadrant = convolved(kernel, spread)
    peak = float(np.abs(quadrant).max())
    away = np.abs(quadrant).max(axis=0)
    reach = int(np.ceil(np.flatnonzero(away > cut * peak)[-1] / FINE))
    reach = max(reach, len(kernel) // FINE)  # so that the lattice holds both
    if reach > WIDEST:
        raise InputError(
            f"the prior carries a taxel's reading {reach} cells away, expected at most {WIDEST}: "
            "use a shorter length_scale, larger cells or a larger cut"
        )
    end = reach * FINE
    return quadrant[: end + 1, : end + 1]


def neighbour_reach(read: Floats, spread: Floats, cut: float) -> float:
    """Cells beyond which two taxels read less than `cut` of each other's pressure.

    As a share of what each reads of its own, for taxels in the middle of cells.
    """
    product = np.abs(convolved(read[::FINE, ::FINE], spread[::FINE, ::FINE]))
    far = np.hypot(*np.indices(product.shape))
    return float(far[product > cut * product[0, 0]].max()) + 0.5


STEPS = 64  # offsets per cell of a profile, linear in between
GROUP = 4  # parts that the kernels add in one pass
LANES = 8  # cells that they add at once
MOST = 16  # parts
MISFIT = 0.2  # of the cut: what the products may be off
TRIALS = 512  # offsets at which a stamp is held against the kernel itself
FAINT = 1e-5  # of a correlation, where it ends


@dataclass(frozen=True, eq=False)
class Stamp:
    """A kernel as a sum of products of profiles, for taxels anywhere in a cell.

    Attributes
    ----------
    table : (STEPS + 1, parts, 2 reach) array
        Profiles at the cells 1 - reach .. reach of a taxel that stands 0 .. 1 past cell 0.
    sign : (parts,) array
        Of each part.
    """

    table: Floats
    sign: Floats

    @property
    def reach(self) -> int:
        """Cells from the taxel to the end."""
        return int(self.table.shape[2]) // 2

    @property
    def width(self) -> int:
        """Cells along x that are written to: a multiple of `LANES`."""
        return -(-2 * self.reach // LANES) * LANES

    def at(self, offsets: Floats) -> Floats:
        """Values (N, 2 reach, 2 reach), by row and column, of taxels (N, 2) cells past cell 0."""
        place = np.clip(offsets, 0.0, 1.0) * STEPS
        step = np.minimum(place.astype(int), STEPS - 1)
        share = (place - step)[..., None, None]
        profile = (1 - share) * self.table[step] + share * self.table[step + 1]
        return np.asarray(
            np.einsum("p,npy,npx->nyx", self.sign, profile[:, 1], profile[:, 0], optimize=True)
        )


def stamp_of(kernel: Floats, tolerance: float) -> tuple[Stamp, float]:
    """Fewest parts that fit the kernel to `tolerance` of its peak, and how far they are off it."""
    from scipy.interpolate import CubicSpline
    from scipy.linalg import eigh

    weight = np.full(len(kernel), np.sqrt(2.0))
    weight[0] = 1.0  # what lies on an axis counts once in the whole plane
    value, vector = eigh(kernel * np.outer(weight, weight))
    order = np.argsort(-np.abs(value))
    peak, reach = np.abs(kernel).max(), len(kernel) // FINE
    for parts in range(GROUP, MOST + 1, GROUP):
        chosen = order[:parts]
        profile = vector[:, chosen] / weight[:, None] * np.sqrt(np.abs(value[chosen]))
        sign = np.sign(value[chosen])
        misfit = float(np.abs((profile * sign) @ profile.T - kernel).max() / peak)
        if misfit <= tolerance:
            break
    both = np.concatenate([profile[:0:-1], profile])
    place = np.arange(-reach * FINE, reach * FINE + 1) / FINE
    cell = np.arange(1 - reach, reach + 1)
    offset = np.arange(STEPS + 1) / STEPS
    table = CubicSpline(place, both)(cell - offset[:, None])  # (STEPS + 1, 2 reach, parts)
    return Stamp(np.ascontiguousarray(np.moveaxis(table, -1, 1)), sign), misfit


def misfit_between_samples(stamp: Stamp, physics: Physics, pitch: float) -> float:
    """How far a stamp is off the response itself at offsets between all samples."""
    index = np.arange(1, TRIALS + 1)
    inside = np.column_stack([index * 0.7548776662, index * 0.5698402910]) % 1.0  # evenly spread
    width = 2 * stamp.reach
    row, column = (index * 7) % width, (index * 11) % width
    offset = np.column_stack([column, row]) + (1 - stamp.reach) - inside
    made = stamp.at(inside)[index - 1, row, column]
    return float(np.abs(made - response(physics, pitch, offset)).max())


@dataclass(frozen=True, eq=False)
class Stamps:
    """What depends on the elastomer and the cells alone.

    Attributes
    ----------
    read : Stamp
        What a taxel reads of each cell, A, in the unit of the reading per Pa.
    spread : Stamp
        Pressure that goes with its reading, Q A^T per variance of a cell.
    neighbours : float
        Cells beyond which two taxels do not count as neighbours.
    """

    read: Stamp
    spread: Stamp
    neighbours: float


@lru_cache(maxsize=16)
def stamps_on(physics: Physics, pitch: float, cut: float, length: float) -> Stamps:
    """Stamps on cells of side `pitch` m for a prior of some length in cells, 0 for none."""
    kernel = response_kernel(physics, pitch, cut)
    read, misfit = stamp_of(kernel, MISFIT * cut)
    between = misfit_between_samples(read, physics, pitch) / float(np.abs(kernel).max())
    misfit = max(misfit, between)
    if misfit > cut:
        raise InputError(
            f"the response of {physics.quantity!r} on {physics.mechanics!r} has edges: {MOST} "
            f"products fit it to {misfit:.1e} of its peak only, expected to the cut of {cut:g}; "
            "use a larger cut, pads that average, or loads that are uniform over a cell"
        )
    if length == 0.0:
        return Stamps(read, read, neighbour_reach(kernel, kernel, cut))
    wide = smoothed_kernel(kernel, correlation(length), cut)
    return Stamps(read, stamp_of(wide, MISFIT * cut)[0], neighbour_reach(kernel, wide, cut))


def correlation(length: float) -> Floats:
    """Matérn-3/2 correlation of cells as far as it counts: the quadrant (n + 1, n + 1) from 0."""
    scaled = 1.0
    while (1.0 + scaled) * np.exp(-scaled) > FAINT:
        scaled += 0.1
    count = int(np.ceil(scaled * length / np.sqrt(3.0)))
    offset = np.arange(count + 1)
    scaled_offset = np.sqrt(3.0) * np.hypot(offset[:, None], offset) / length
    return np.asarray((1 + scaled_offset) * np.exp(-scaled_offset))
