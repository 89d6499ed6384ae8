"""A skin before it is made, the touch it is judged by, and the places where it is judged."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import (
    Floats,
    InputError,
    Ints,
    as_floats,
    check_positive,
    check_shape,
)
from skinfield.layout import Grid, Patch
from skinfield.mechanics import BondedLayer, Layer, Mechanics
from skinfield.observation import Capacitance, Physics, Quantity, check_skin

NARROWEST, WIDEST = 0.15, 6.0  # radius of a touch in thicknesses, with room to vary it
PER_PITCH = 10.0  # places in the distance of two taxels
MOST = 40_000  # places, unless a pitch is asked for
MOST_ASKED = 400_000  # else: a map of 72 taxels then takes some 10 s


@dataclass(frozen=True, eq=False, kw_only=True)
class SkinDesign:
    """Where the taxels are, what lies on them, and how well they are read.

    Parameters
    ----------
    patch : Patch
    layer : Layer
    mechanics : Mechanics
    quantity : Quantity
        What a taxel reads.
    noise_std : float or (L,) array, in the quantity's unit
        Of one reading, independent from taxel to taxel. Default the quantity's typical noise.
    """

    patch: Patch
    layer: Layer
    mechanics: Mechanics = field(default_factory=BondedLayer)
    quantity: Quantity = field(default_factory=Capacitance)
    noise_std: ArrayLike | None = None

    def __post_init__(self) -> None:
        check_skin(self.patch, self.layer, self.mechanics, self.quantity)
        for value in self.noise:
            check_positive("noise_std", float(value), "no reading is exact")

    @cached_property
    def noise(self) -> Floats:
        """`noise_std` of each taxel, (L,)."""
        given = self.quantity.typical_noise if self.noise_std is None else self.noise_std
        noise = as_floats("noise_std", given)
        if noise.ndim == 0:
            noise = np.full(len(self.patch), float(noise))
        check_shape("noise_std", noise, (len(self.patch),), "one per taxel, or one for all")
        return noise

    @property
    def linear(self) -> "SkinDesign":
        """The same skin, its readings taken as proportional to the force."""
        quantity = self.quantity
        if not isinstance(quantity, Capacitance) or quantity.order == 1:
            return self
        return replace(self, quantity=replace(quantity, order=1))

    @property
    def physics(self) -> Physics:
        """What the taxels are made of and read."""
        return Physics(self.layer, self.mechanics, self.quantity, self.patch.pad_diameter)


@dataclass(frozen=True)
class Touch:
    """A round contact: a ball that presses on the skin.

    Parameters
    ----------
    force : float, N
    radius : float, m
        Of the contact, not of the ball.
    """

    force: float
    radius: float

    def __post_init__(self) -> None:
        check_positive("force", self.force, "of the touch, in newtons")
        check_positive("radius", self.radius, "of the contact, in metres")

    @classmethod
    def small(cls, layer: Layer, force: float = 0.5) -> "Touch":
        """Touch as wide as the layer is thick: a radius of half the thickness."""
        return cls(force, layer.thickness / 2)

    def check_on(self, layer: Layer) -> None:
        """Raise InputError where the layer is too thin or thick for the radius."""
        low, high = NARROWEST * layer.thickness, WIDEST * layer.thickness
        if not low <= self.radius <= high:
            raise InputError(
                f"radius is {self.radius!r} m, expected from {low:g} to {high:g} m, which is "
                f"{NARROWEST:g} to {WIDEST:g} times the layer's thickness: narrower contacts read "
                "as that one does, wider ones are no touch"
            )


@dataclass(frozen=True, eq=False)
class Places:
    """Where a layout is judged: nodes of a regular grid in the patch's plane.

    Attributes
    ----------
    grid : Grid
    nodes : (P,) int array
        Those of its nodes that lie among the taxels, or on a pad.
    """

    grid: Grid
    nodes: Ints

    @classmethod
    def over(cls, patch: Patch, pitch: float | None = None) -> "Places":
        """Places all over a patch.

        Parameters
        ----------
        patch : Patch
        pitch : float, m, optional
            Distance of neighbouring places. Default a tenth of the distance of two taxels; more on
            patches so large that there were above 40 000 places.

        Raises
        ------
        InputError
            Where the pitch is not positive, so wide that no place is left, or so fine that there
            were above 400 000.
        """
        from scipy.spatial import cKDTree

        rim = patch.pad_diameter / 2
        box = float(np.prod(np.ptp(patch.plane, axis=0) + 2 * rim))
        if pitch is None:
            pitch = max(patch.pitch / PER_PITCH, np.sqrt(box / MOST))
        check_positive("pitch", pitch, "distance of neighbouring places, in metres")
        wanted = box / pitch / pitch
        if wanted > MOST_ASKED:
            enough = 1.05 * float(np.sqrt(box / MOST_ASKED))
            raise InputError(
                f"pitch is {pitch!r} m, which makes {wanted:.2g} places on patch {patch.name!r}, "
                f"expected at most {MOST_ASKED}: take {enough:.2g} m or more, or "
                "judge a part of the patch"
            )
        grid = Grid.window(
            patch, patch.plane.min(axis=0) - rim, patch.plane.max(axis=0) + rim, pitch
        )
        on_pad = np.asarray(cKDTree(patch.plane).query(grid.plane)[0]) <= rim
        nodes = np.flatnonzero(grid.covered | on_pad)
        if not len(nodes):
            raise InputError(
                f"pitch is {pitch!r} m, expected a smaller one: no place of so wide a grid lies "
                f"on patch {patch.name!r}"
            )
        return cls(grid, nodes)

    def __len__(self) -> int:
        return len(self.nodes)

    @cached_property
    def plane(self) -> Floats:
        """Places in the patch's plane, (P, 2) m."""
        return self.grid.plane[self.nodes]

    @property
    def area(self) -> float:
        """Of all places together, m²."""
        return len(self) * self.grid.cell_area

    @cached_property
    def inside(self) -> NDArray[np.bool_]:
        """Which nodes of the grid are places, (rows, columns)."""
        mask = np.zeros(len(self.grid), dtype=np.bool_)
        mask[self.nodes] = True
        return mask.reshape(self.grid.shape)

    def picture(self, values: ArrayLike) -> Floats:
        """Values (P,) as a picture (rows, columns) with y upwards; NaN where there is no place."""
        values = as_floats("values", values)
        check_shape("values", values, (len(self),), "one per place")
        out = np.full(len(self.grid), np.nan)
        out[self.nodes] = values
        return out.reshape(self.grid.shape)

    def parts(self, mask: NDArray[np.bool_]) -> Iterator[Ints]:
        """Connected parts of the places where `mask` (P,), largest first: rows of places each.

        Places that share a side or a corner belong together.
        """
        from scipy.ndimage import label

        whole = np.zeros(len(self.grid), dtype=np.bool_)
        whole[self.nodes[mask]] = True
        names, count = label(whole.reshape(self.grid.shape), structure=np.ones((3, 3)))
        of_place = names.ravel()[self.nodes]
        sizes = np.bincount(of_place, minlength=count + 1)[1:]
        for part in np.argsort(-sizes, kind="stable") + 1:
            yield np.flatnonzero(of_place == part)
