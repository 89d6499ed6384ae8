"""Design of a skin before it is made: the touch it is judged by, places, and the response."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic import (
    BondedLayer,
    Capacitance,
    Layer,
    Mechanics,
    Physics,
    Quantity,
    check_skin,
)
from skinfield.errors import Floats, InputError, Ints, as_floats, check_positive, check_shape
from skinfield.settings import Positive, Section
from skinfield.skin import Grid, Patch

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
class Touch(Section):
    """A round contact: a ball that presses on the skin.

    Parameters
    ----------
    force : float, N
    radius : float, m
        Of the contact, not of the ball.
    """

    force: Annotated[float, Positive("of the touch, in newtons")]
    radius: Annotated[float, Positive("of the contact, in metres")]

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
    def over(
        cls,
        patch: Patch,
        pitch: float | None = None,
        *,
        per_pitch: float = PER_PITCH,
        most: int = MOST,
    ) -> "Places":
        """Places all over a patch.

        Parameters
        ----------
        patch : Patch
        pitch : float, m, optional
            Distance of neighbouring places. Default that of two taxels over `per_pitch`; more on
            patches so large that there were more than `most` places.
        per_pitch : float
        most : int

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
            pitch = max(patch.pitch / per_pitch, np.sqrt(box / most))
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


BLOCK = 4096  # places whose neighbouring taxels are listed at once
FAINT = 1e-6  # of the strongest reading per newton: what is below is no response
TRIAL = 1e-3  # N: at which readings are proportional to the force
DEEPEST = 0.9  # of the gap: beyond it the elastomer is flat


@dataclass(frozen=True, eq=False)
class Responses:
    """Inner products of the whitened readings of a touch and of their derivatives, per place.

    Attributes
    ----------
    gram : (P, 5, 5) array
        Of the readings y / noise and their derivatives by x m, y m, ln force and ln radius. So
        [:, 0, 0] is the squared signal-to-noise ratio and [:, 1:, 1:] the Fisher information.
    """

    gram: Floats

    @property
    def snr(self) -> Floats:
        """Signal-to-noise ratio of a matched filter, (P,)."""
        return np.asarray(np.sqrt(self.gram[:, 0, 0]))

    @property
    def turn(self) -> Floats:
        """How the direction of the readings turns with the place: metric (P, 2, 2), 1/m²."""
        power = np.maximum(self.gram[:, 0, 0], np.finfo(float).tiny)[:, None, None]
        across = self.gram[:, 1:3, 0] / power[:, 0]  # its square could underflow
        return np.asarray(self.gram[:, 1:3, 1:3] / power - across[:, :, None] * across[:, None, :])


def largest_force(design: SkinDesign, radius: float) -> float:
    """Force in N at which a contact of some radius in m has closed the gap to DEEPEST of it.

    Infinite where readings are taken as proportional to the force.
    """
    from skinfield.solve.atoms.table import BALL, atom_tables, unit_indentation

    if not atom_tables(design.physics).strain.size:
        return float("inf")
    axis = np.array([1e-6 * radius])
    sunk = unit_indentation(design.layer, design.mechanics, BALL, radius, axis)
    return float(DEEPEST * design.layer.thickness / sunk[0])


def sight_of(design: SkinDesign, radius: float) -> float:
    """Distance in m from a contact's middle beyond which a taxel reads nothing."""
    from skinfield.solve.atoms.table import SIGHT

    return radius + design.patch.pad_diameter / 2 + SIGHT * design.layer.thickness


def respond(
    design: SkinDesign, touch: Touch, points: Floats, forces: Floats | None = None
) -> Responses:
    """Responses to a touch at points (P, 2) m of the plane, from the taxels within its sight.

    Memory grows with P alone: taxels are listed for some thousand places at a time.

    Parameters
    ----------
    design : SkinDesign
    touch : Touch
    points : (P, 2) array, m
    forces : (P,) array, N, optional
        Instead of the touch's, place by place.
    """
    from skinfield.design.kernels import grams
    from skinfield.solve.atoms.table import atom_tables

    touch.check_on(design.layer)
    if forces is None:
        most = largest_force(design, touch.radius)
        if touch.force > most:
            raise InputError(
                f"force is {touch.force:g} N on a contact of radius {touch.radius * 1e3:g} mm, "
                f"expected at most {most:.3g} N: it would press the elastomer flat; take less "
                "force, a wider contact, a harder or thicker elastomer, or only the linear response"
            )
        forces = np.full(len(points), touch.force)
    h, tables, logs = design.layer.thickness, atom_tables(design.physics), np.log(forces)
    taxels, white = design.patch.plane / h, 1.0 / design.noise
    gram = np.empty((len(points), 5, 5))
    for first in range(0, len(points), BLOCK):
        part = slice(first, first + BLOCK)
        start, rows = near_taxels(design, points[part], sight_of(design, touch.radius))
        scaled, log_radius = points[part] / h, float(np.log(touch.radius / h))
        grams(scaled, logs[part], log_radius, taxels, white, start, rows, tables, gram[part])
    unit = np.array([1.0, 1.0 / h, 1.0 / h, 1.0, 1.0])
    return Responses(gram * unit[:, None] * unit)


def near_taxels(design: SkinDesign, points: Floats, distance: float) -> tuple[Ints, Ints]:
    """Taxels within a distance of each point, nearest first.

    Returns
    -------
    start : (P + 1,) int array
        Where each point's taxels begin in `rows`.
    rows : (N,) int array
    """
    from scipy.spatial import cKDTree

    plane = design.patch.plane
    near: Any = cKDTree(plane).query_ball_point(points, distance)
    counts = np.array([len(rows) for rows in near], dtype=np.int64)
    start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    rows = np.concatenate([np.asarray(rows, dtype=np.int64) for rows in near])
    point = np.repeat(np.arange(len(points)), counts)
    away = np.linalg.norm(plane[rows] - points[point], axis=1)
    return start, rows[np.lexsort([away, point])]


def snr_per_newton(design: SkinDesign, radius: float, points: Floats) -> Floats:
    """Signal-to-noise ratio of a light touch of some radius in m, over its force: (P,), 1/N."""
    return respond(design, Touch(TRIAL, radius), points).snr / TRIAL
