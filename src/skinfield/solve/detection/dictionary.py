"""Dictionary of templates: what single touches do to the readings of a patch, and their matches."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import Layer, Mechanics, Quantity
from skinfield.errors import (
    Floats,
    InputError,
    Ints,
    as_floats,
    check_positive,
    check_range,
    check_shape,
)
from skinfield.skin import Grid, Patch

RADII = (0.5, 1.0, 1.75)  # of a touch, in thicknesses
FINENESS = 4.0  # places per pad radius and thickness together, over which readings change
CELLS = 8  # of the lattice that carries a touch, per radius
SAMPLES = 10  # along a cell's side, for the part of the touch that it carries
NEAR, NEAR_STEP, FAR_STEPS = 6.0, 0.05, 60  # thicknesses, and distances beyond them
MOST_VALUES = 200_000_000  # of the table: 1.6 GB


@dataclass(frozen=True, eq=False)
class Templates:
    """Readings of touches of 1 N with Hertz's pressure, of S radii at each of P places.

    Attributes
    ----------
    places : (P, 2) array, m
        In the patch's plane.
    spacing : float, m
        Between neighbouring places.
    radii : (S,) array, m
    readings : (S * P, L) array, unit of the reading per N
        Row `size * P + place`; the linear part, as light touches are.
    """

    places: Floats
    spacing: float
    radii: Floats
    readings: Floats


def round_touches(
    patch: Patch,
    layer: Layer,
    mechanics: Mechanics,
    quantity: Quantity,
    radii: Sequence[float] | None = None,
    spacing: float | None = None,
) -> Templates:
    """Templates on a square lattice of places where the patch feels anything.

    The skin is taken as flat around each touch, and the medium as the same in all directions, so
    that a reading depends on the distance from touch to taxel alone.

    Parameters
    ----------
    radii : sequence of float, m, optional
        Of the touches. Default 0.5, 1 and 1.75 thicknesses.
    spacing : float, m, optional
        Between places. Default a quarter of pad radius and thickness together.
    """
    default = np.multiply(RADII, layer.thickness)
    sizes = default if radii is None else as_floats("radii", radii)
    check_shape("radii", sizes, (None,), "radii of touches, in metres")
    if not len(sizes):
        raise InputError("radii is empty, expected at least one: no touch would be looked for")
    for radius in sizes:
        check_positive("radii", float(radius), "radii of touches, in metres")
    if spacing is None:
        spacing = (patch.pad_diameter / 2 + layer.thickness) / FINENESS
    check_positive("spacing", spacing, "between the places that are tried, in metres")
    places = _places(patch, spacing, len(sizes))
    distance = np.linalg.norm(places[:, None] - patch.plane, axis=2)
    pad = patch.pad_diameter
    shapes = [
        _profile(layer, mechanics, quantity, radius, pad, distance) for radius in sizes.tolist()
    ]
    return Templates(places, spacing, sizes, np.concatenate(shapes))


def _places(patch: Patch, spacing: float, sizes: int) -> Floats:
    """Nodes (P, 2) m of a lattice over the patch: where it measures, or next to a taxel."""
    from scipy.spatial import cKDTree

    margin = max(patch.pad_diameter, patch.pitch) / 2
    low, high = patch.plane.min(axis=0) - margin, patch.plane.max(axis=0) + margin
    wanted = float(np.prod((high - low) / spacing + 1)) * sizes * len(patch)
    if wanted > MOST_VALUES:
        enough = spacing * float(np.sqrt(wanted / MOST_VALUES))
        raise InputError(
            f"spacing is {spacing:.3g} m, expected {enough:.2g} m or more on this patch: the "
            f"table would hold {wanted:.1e} values; split the patch, or look at fewer places"
        )
    grid = Grid.window(patch, low, high, spacing)
    near = np.asarray(cKDTree(patch.plane).query(grid.plane)[0]) <= margin
    return grid.plane[grid.covered | near]


def _profile(
    layer: Layer,
    mechanics: Mechanics,
    quantity: Quantity,
    radius: float,
    pad_diameter: float,
    distance: Floats,
) -> Floats:
    """Readings of taxels at `distance` (...) m from one touch of 1 N, interpolated."""
    from scipy.interpolate import CubicSpline

    h = layer.thickness
    near, far = (NEAR + radius / h) * h + pad_diameter, float(distance.max())
    knots = np.arange(0.0, near + NEAR_STEP * h, NEAR_STEP * h)
    if far > knots[-1]:
        knots = np.concatenate([knots, np.geomspace(knots[-1], far, FAR_STEPS)[1:]])
    line = np.column_stack([knots, np.zeros_like(knots)])
    grid, pressure = _disc(radius)
    matrix = quantity.matrix(mechanics, layer, grid, line, pad_diameter)
    return np.asarray(CubicSpline(knots, matrix @ pressure)(distance))


def _disc(radius: float) -> tuple[Grid, Floats]:
    """Hertz's pressure of 1 N on a lattice around the origin: its cells, and (K,) Pa on them."""
    side = radius / (CELLS + 0.5)  # an odd number of cells across
    grid = Grid(Patch(np.zeros((1, 2))), (2 * CELLS + 1,) * 2, side, np.full(2, -CELLS * side))
    within = ((np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5) * side
    x, y = (grid.plane[:, axis, None] + within for axis in (0, 1))
    square = 1.0 - (x[:, :, None] ** 2 + y[:, None, :] ** 2) / radius**2
    pressure = np.sqrt(np.maximum(square, 0.0)).mean(axis=(1, 2))
    return grid, pressure / (pressure.sum() * grid.cell_area)


UNSEEN = 1e-12  # of the best template's information: below, a template is not seen at all
MASKS_KEPT = 32  # sets of taxels whose information stays known


@dataclass(frozen=True, eq=False)
class ReadingNoise:
    """Gaussian noise of one reading: independent per taxel, and an offset that all share.

    Attributes
    ----------
    std : (L,) array, unit of the reading
    common : float, unit of the reading
        Standard deviation of the offset; infinite where nothing is known of it, 0 for none.
    correlation : float
        With the next reading; it falls as a power of the readings between (an AR(1) process).
    """

    std: Floats
    common: float
    correlation: float = 0.0

    @classmethod
    def of(
        cls, noise_std: object, common_mode: bool | float, correlation: float, taxels: int
    ) -> "ReadingNoise":
        """Check what the caller gave: a number or (L,); False, True or a number."""
        std = as_floats("noise_std", noise_std)  # type: ignore[arg-type]
        std = np.full(taxels, float(std)) if std.ndim == 0 else std.copy()
        check_shape("noise_std", std, (taxels,), "one number, or one per taxel")
        good = np.isfinite(std) & (std > 0)
        if not good.all():
            row = int(np.argmin(good))
            raise InputError(
                f"noise_std[{row}] is {std[row]}, expected a finite number above 0: no reading is "
                "exact; give the standard deviation of a quiet taxel"
            )
        try:
            common = np.inf if common_mode is True else float(common_mode)
        except (TypeError, ValueError):
            common = np.nan
        if not common >= 0.0:
            raise InputError(
                f"common_mode is {common_mode!r}, expected False, True, or the standard deviation "
                "of an offset that all taxels share, in the unit of a reading"
            )
        why = "of a reading's noise with that of the next; 0 for white noise"
        check_range("correlation", correlation, 0.0, 0.99, why)
        return cls(std, common, float(correlation))

    def growth(self, count: Ints) -> Floats:
        """Variance of the sum of so many readings, in variances of one; the count if white."""
        kept = self.correlation
        far = 2.0 * kept * (1.0 - kept**count) / (1.0 - kept) ** 2
        return np.asarray(count * (1.0 + kept) / (1.0 - kept) - far)

    @property
    def offset(self) -> Floats:
        """What an offset of 1 adds to the readings in units of their noise, (L,)."""
        return np.asarray(1.0 / self.std)

    @property
    def inverse_variance(self) -> float:
        """Of the offset: 0 where it is unknown."""
        return 1.0 / self.common**2 if self.common > 0 else np.inf


@dataclass(frozen=True, eq=False)
class DetectorTemplates:
    """Templates in units of the noise.

    Attributes
    ----------
    templates : Templates
    noise : ReadingNoise
    scaled : (J, L) array, 1/N
        Template over noise.
    """

    templates: Templates
    noise: ReadingNoise
    scaled: Floats

    @classmethod
    def of(cls, templates: Templates, noise: ReadingNoise) -> "DetectorTemplates":
        """Divide the templates by the noise."""
        bank = cls(templates, noise, np.ascontiguousarray(templates.readings / noise.std))
        if not bank.information(np.ones(len(noise.std), dtype=np.bool_)).any():
            raise InputError(
                f"common_mode is {noise.common!r} and the patch has {len(noise.std)} taxel(s), "
                "expected a template that an offset cannot imitate: give common_mode=False"
            )
        return bank

    def whitened(self, readings: Floats) -> Floats:
        """Inverse covariance times readings (..., L), times the noise: 0 where they are NaN."""
        valid = ~np.isnan(readings)
        out = np.where(valid, readings, 0.0) / self.noise.std
        if self.noise.common > 0:
            shared = np.where(valid, self.noise.offset, 0.0)
            out -= shared * self._shared_part(out @ self.noise.offset, shared)[..., None]
        return out

    def information(self, valid: NDArray[np.bool_]) -> Floats:
        """Information g² (J,) of one reading in which some taxels answered: see `Matches`."""
        return self._known(np.asarray(valid).tobytes())

    @cached_property
    def _known(self) -> Callable[[bytes], Floats]:
        return lru_cache(MASKS_KEPT)(self._computed)

    def _computed(self, mask: bytes) -> Floats:
        valid = np.frombuffer(mask, np.bool_)
        part = self.scaled[:, valid]
        known = np.einsum("jl,jl->j", part, part)
        floor = UNSEEN * known.max(initial=0.0)
        if self.noise.common > 0:
            shared = self.noise.offset[valid]
            along = part @ shared
            known -= along * self._shared_part(along, shared)
        return np.where(known > floor, known, 0.0)

    def _shared_part(self, along: Floats, shared: Floats) -> Floats:
        """The offset that best explains a reading, given its product with `shared`; 0 if none."""
        weight = np.square(shared).sum(axis=-1) + self.noise.inverse_variance
        out: Floats = np.divide(along, weight, out=np.zeros(np.shape(along)), where=weight > 0)
        return out

    def idle(self, count: int, rng: "np.random.Generator") -> Floats:
        """Whitened noise (count, L) of single readings of an idle patch."""
        noise = rng.standard_normal((count, len(self.noise.std)))
        if 0 < self.noise.common < np.inf:
            offset = self.noise.common * rng.standard_normal((count, 1))
            noise += offset * self.noise.offset
        return self.whitened(noise * self.noise.std)


def spread_of(information: Floats) -> Floats:
    """1/g where g² is above 0, else 0."""
    out = np.zeros_like(information)
    np.divide(1.0, np.sqrt(information), out=out, where=information > 0)
    return out
