"""Readings of a press: what pads at the base, or above it, see of it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic import LatticeConvolution
from skinfield.elastic.electrostatics import MARGIN, STEPS, GapStrain
from skinfield.elastic.lattice import (
    cached_indentation_kernel,
    cached_lift_kernel,
    lattice,
    mirrored,
)
from skinfield.errors import Floats, InputError, as_floats, check_finite, check_range, check_shape
from skinfield.simulate.pressing.tractions import Sources, Traction, sources
from skinfield.simulate.pressing.windows import PAD, Medium, Window, coarsened, resplit

NEAR = 4  # cells around a window within which its squares act one by one
MOST_SAMPLES = 10_000_000  # of the mesh: some 2 GB
SHEARED = 3  # squares along a cell that are enough for tangential displacement


def indentation(skin: Medium, touches: tuple[Traction, ...]) -> Floats:
    """Of the cells' centres by the normal loads, (rows, columns) m."""
    total = np.zeros(skin.grid.shape)
    for touch in touches:
        far = skin.far(skin.carried(touch.window, -touch.traction[2]))[PAD:-PAD, PAD:-PAD]
        wide = touch.window.grown(NEAR, skin.grid.shape)
        near = LatticeConvolution(skin.near_kernel(wide))(
            touch.window.embedded(-touch.traction[2], wide)
        )
        far[wide.cells] = wide.centres(near)
        total += far
    return total


def sheared(skin: Medium, touches: tuple[Traction, ...]) -> Floats:
    """Displacement of the cells' centres, (3, rows, columns) m, less that along z by normal loads.

    That is: the tangential one by all loads, and the normal one by tangential loads.
    """
    total = np.zeros((3, *skin.grid.shape))
    far_kernel = skin.far_surface
    for touch in touches:
        split = min(touch.window.split, SHEARED)
        window = replace(touch.window, split=split)
        traction = resplit(touch.traction, touch.window.split, split)
        wide = window.grown(NEAR, skin.grid.shape)
        near_kernel = skin.near_surface(wide)
        for along in np.flatnonzero(traction.any(axis=(1, 2))):
            rows = slice(0, 2) if along == 2 else slice(0, 3)
            load = traction[along]
            far = LatticeConvolution(far_kernel[rows, along])(skin.carried(window, load))
            far = far[..., PAD:-PAD, PAD:-PAD]
            near = LatticeConvolution(near_kernel[rows, along])(window.embedded(load, wide))
            far[:, *wide.cells] = wide.centres(near)
            total[rows] += far
    return total


def gap_strain(
    skin: Medium, touches: tuple[Traction, ...], around: Floats, pad_diameter: float = 0.0
) -> GapStrain:
    """Indentation over thickness, finely sampled around touches and pads at (L, 2) m."""
    h, pitch = skin.layer.thickness, skin.grid.pitch
    split = 1
    while pitch / split > h / STEPS * (1 + 1e-9):
        split *= 3
    step = pitch / split
    low, high = _extent(skin, touches, around, step, MARGIN * h + pad_diameter / 2)
    columns, rows = (int(n) for n in high - low)
    kernel = cached_indentation_kernel(skin.mechanics, skin.layer, step, step, rows, columns)
    convolve = LatticeConvolution(kernel)
    total = np.zeros((rows + 1, columns + 1))
    for touch in touches:
        window = touch.window
        load = np.zeros((3, *total.shape))
        load[:, *_on_mesh(window, split, low)] = resplit(touch.traction, window.split, split)
        sunk = convolve(-load[2])
        if window.split > split:  # near its squares the mesh sees each of them
            wide = window.grown(NEAR + 1)
            near = LatticeConvolution(skin.near_kernel(wide))(
                window.embedded(-touch.traction[2], wide)
            )
            inside = slice(split, -split)
            sampled = _sampled(near, window.split // split)[inside, inside]
            sunk[_on_mesh(window.grown(NEAR), split, low)] = sampled
        total += sunk
        if load[:2].any():
            lift = cached_lift_kernel(skin.mechanics, skin.layer, step, step, rows, columns)
            total -= LatticeConvolution(lift)(load[:2], total=True)
    first = skin.grid.origin + ((low + 0.5) / split - 0.5) * pitch
    return GapStrain(total / h, first, step)


def _sampled(values: Floats, ratio: int) -> Floats:
    """On a mesh so many times as coarse: block means, less what a mean adds to a curved surface.

    Points would do where the surface is smooth, but not where it steps down beside an edge.
    """
    from scipy.ndimage import laplace

    means = coarsened(values, ratio)
    return np.asarray(means - laplace(means, mode="nearest") * (1 - ratio**-2) / 24)


def _on_mesh(window: Window, split: int, low: NDArray[np.int64]) -> tuple[slice, slice]:
    """Where a window lies on a mesh of `split` squares along a cell, from column and row `low`."""
    row, column = window.row * split - int(low[1]), window.column * split - int(low[0])
    return (slice(row, row + window.rows * split), slice(column, column + window.columns * split))


def _extent(
    skin: Medium, touches: tuple[Traction, ...], around: Floats, step: float, margin: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First and last column and row of a mesh that covers touches and points, with a margin."""
    corner = skin.grid.origin - skin.grid.pitch / 2
    places = [around]
    for touch in touches:
        window = touch.window
        first = np.array([window.column, window.row])
        size = np.array([window.columns, window.rows])
        places.append(corner + np.stack([first, first + size]) * skin.grid.pitch)
    every = np.concatenate(places)
    lowest, highest = every.min(axis=0) - margin, every.max(axis=0) + margin
    width, height = highest - lowest
    if width * height > MOST_SAMPLES * step**2:
        raise InputError(
            f"positions lie up to {np.abs(around).max():g} m from the origin, expected pads and "
            f"touches within a square of some {MOST_SAMPLES**0.5 * step:.2g} m: give positions "
            "in metres, or read far pads, which feel nothing, apart"
        )
    low = np.floor((lowest - corner) / step).astype(np.int64)
    high = np.ceil((highest - corner) / step).astype(np.int64)
    return low, high


WIDEST = 0.125  # thicknesses: side of the squares that stand for a touch


def points_of(positions: ArrayLike, pad_diameter: float) -> Floats:
    """Points of the plane (L, 2) m from (L, 2) or (L, 3), beside a diameter that can be."""
    check_range("pad_diameter", pad_diameter, 0.0, 1.0, "0 is a point; give it in metres")
    positions = as_floats("positions", positions)
    columns = 3 if positions.ndim == 2 and positions.shape[1] == 3 else 2
    check_shape("positions", positions, (None, columns), "x, y (and z) of each pad, in metres")
    check_finite("positions", positions, "a pad without a place reads nothing")
    if not len(positions):
        raise InputError("positions is empty, expected at least one pad: nothing would be read")
    return positions[:, :2]


def _offsets(places: Floats, source: Sources) -> Floats:
    return (places[:, None] - source.places[None]).reshape(-1, 2)


def _sources(skin: Medium, touches: tuple[Traction, ...]) -> list[Sources]:
    every = [sources(skin, touch, WIDEST * skin.layer.thickness) for touch in touches]
    return [source for source in every if len(source.places)]


def base_stress(
    skin: Medium, touches: tuple[Traction, ...], places: Floats, pad_diameter: float
) -> Floats:
    """Mean pressure (L,) Pa on pads at the base."""
    out = np.zeros(len(places))
    for source in _sources(skin, touches):
        if source.traction[:, :2].any():
            out -= _traction(skin, source, places, pad_diameter)[:, 2]
            continue
        each = skin.mechanics.base_stress(
            skin.layer, _offsets(places, source), source.side, pad_diameter
        )
        out -= each.reshape(len(places), -1) @ source.traction[:, 2]
    return out


def base_traction(
    skin: Medium, touches: tuple[Traction, ...], places: Floats, pad_diameter: float
) -> Floats:
    """Mean traction (L, 3) Pa that the skin exerts on the base's pads, as an outward normal +z."""
    out = np.zeros((len(places), 3))
    for source in _sources(skin, touches):
        out += _traction(skin, source, places, pad_diameter)
    return out


def _traction(skin: Medium, source: Sources, places: Floats, pad_diameter: float) -> Floats:
    each = skin.mechanics.base_traction(
        skin.layer, _offsets(places, source), source.side, pad_diameter
    )
    each = each.reshape(len(places), -1, 3, 3)
    return np.asarray(np.einsum("lnij,nj->li", each, source.traction))


def gap_change(
    skin: Medium, touches: tuple[Traction, ...], places: Floats, pad_diameter: float
) -> Floats:
    """Mean indentation (L,) m above pads."""
    out = np.zeros(len(places))
    for source in _sources(skin, touches):
        each = skin.mechanics.indentation(
            skin.layer, _offsets(places, source), source.side, pad_diameter
        )
        out -= each.reshape(len(places), -1) @ source.traction[:, 2]
        if source.traction[:, :2].any():
            lifts = skin.mechanics.lift(
                skin.layer, _offsets(places, source), source.side, pad_diameter
            ).reshape(len(places), -1, 2)
            out -= np.einsum("lnj,nj->l", lifts, source.traction[:, :2])
    return out


@dataclass(frozen=True, eq=False)
class Around:
    """Readings around a round body by distance and angle.

    Attributes
    ----------
    distance : (D,) array, m
        From 0 up, evenly.
    harmonics : (N, D) array
        Row n goes with the cosine of n times the angle; row 1 is the dipole.
    direction : float, rad
        Where the angle is 0.
    """

    distance: Floats
    harmonics: Floats
    direction: float = 0.0

    @classmethod
    def of(
        cls, read: Callable[[Floats], Floats], distance: Floats, direction: float, count: int
    ) -> "Around":
        """Read points (N, 2) m at `count` angles over the half circle, which the other mirrors."""
        angle = np.pi * np.arange(count) / max(count - 1, 1)
        turned = np.column_stack([np.cos(angle + direction), np.sin(angle + direction)])
        values = read((turned[:, None] * distance[:, None]).reshape(-1, 2)).reshape(count, -1)
        order = np.arange(count)
        weight = np.where((order == 0) | (order == max(count - 1, 1)), 1.0, 2.0)
        waves = np.cos(np.outer(order, angle)) * weight * weight[:, None] / (2 * max(count - 1, 1))
        return cls(distance, waves @ values if count > 1 else values, direction)

    @cached_property
    def _splines(self) -> list[Callable[[Floats], Floats]]:
        from scipy.interpolate import CubicSpline

        # All but a dipole are flat at the axis.
        return [
            CubicSpline(
                self.distance, row, bc_type=("not-a-knot" if n == 1 else "clamped", "clamped")
            )
            for n, row in enumerate(self.harmonics)
        ]

    def __call__(self, points: Floats) -> Floats:
        """Readings (N,) at points (N, 2) m; 0 beyond the table."""
        away = np.hypot(points[:, 0], points[:, 1])
        angle = np.arctan2(points[:, 1], points[:, 0]) - self.direction
        held = np.minimum(away, self.distance[-1])
        total = sum(spline(held) * np.cos(n * angle) for n, spline in enumerate(self._splines))
        return np.where(away <= self.distance[-1], total, 0.0)


def cell_traction(skin: Medium, touches: tuple[Traction, ...]) -> Floats:
    """Mean on each cell, (3, rows, columns) Pa."""
    out = np.zeros((3, *skin.grid.shape))
    for touch in touches:
        out[:, *touch.window.cells] = touch.window.means(touch.traction)
    return out


def pressure_by_body(skin: Medium, touches: tuple[Traction, ...], bodies: int) -> Floats:
    """Mean pressure (bodies, K) Pa on each cell by each body."""
    out = np.zeros((bodies, *skin.grid.shape))
    for touch in touches:
        for index in range(bodies):
            push = np.where(touch.body == index, -touch.traction[2], 0.0)
            out[index][touch.window.cells] += touch.window.means(push)
    return out.reshape(bodies, -1)


def base_stress_below_cells(skin: Medium, touches: tuple[Traction, ...]) -> Floats:
    """Normal stress (K,) Pa below the centre of each cell, by convolution of the cells' means."""
    rows, columns = skin.grid.shape
    offsets, pitch = lattice(rows - 1, columns - 1, skin.grid.pitch), skin.grid.pitch
    traction = cell_traction(skin, touches)
    if not traction[:2].any():
        response = skin.mechanics.base_stress(skin.layer, offsets, pitch, 0.0)
        kernel = mirrored(response.reshape(rows, columns))
        return np.asarray(LatticeConvolution(kernel)(-traction[2])).ravel()
    response = skin.mechanics.base_traction(skin.layer, offsets, pitch, 0.0)[:, 2]
    along = response.T.reshape(3, rows, columns)
    total = np.zeros((rows, columns))
    for axis, (odd_x, odd_y) in enumerate(((True, False), (False, True), (False, False))):
        kernel = mirrored(along[axis], odd_x=odd_x, odd_y=odd_y)
        total -= LatticeConvolution(kernel)(traction[axis])
    return total.ravel()
