"""Observation model: what the taxels read of a pressure, the linear map that solvers invert."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic.bonded_layer import BondedLayer
from skinfield.elastic.curved_layer import CurvedLayer
from skinfield.elastic.elastomer import Layer, Mechanics
from skinfield.elastic.lattice import LatticeConvolution, displacement_kernel
from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_choice,
    check_offers,
    check_shape,
    check_type,
)
from skinfield.skin import Grid, Patch

LAYER = "such as Layer(thickness=2e-3, young_modulus=150e3), in m and Pa"
PATCH = "such as layouts.hexagon72(), or one of load_layout(file), which is a skin of patches"


def check_skin(patch: object, layer: object, mechanics: object, quantity: object) -> None:
    """Raise InputError, with what to hand in, for what is no patch, layer, elastomer or quantity.

    A number, a name or a class in place of an object would fail much later, and elsewhere.
    """
    check_type("patch", patch, Patch, PATCH)
    check_type("layer", layer, Layer, LAYER)
    needs = ("base_stress", "surface_displacement", "indentation")
    check_offers("mechanics", mechanics, needs, "a model such as BondedLayer() or HalfSpace()")
    needs = ("matrix", "linearise", "typical_noise")
    check_offers("quantity", quantity, needs, "one of Capacitance(), BaseStress() and Gap()")
    assert isinstance(layer, Layer)
    check_units(layer)


STEEPEST = 0.95  # strain of a gap
THINNEST, THICKEST = 2e-5, 0.2  # m
SOFTEST, STIFFEST = 500.0, 5e8  # Pa: gels, plastics


def check_units(layer: Layer) -> None:
    """Raise InputError for a layer that no skin has, but one in other units than m and Pa has."""
    if not THINNEST <= layer.thickness <= THICKEST:
        raise InputError(
            f"layer.thickness is {layer.thickness:.3g} m, expected {THINNEST:g} to {THICKEST:g} m: "
            "2 mm is 2e-3"
        )
    if not SOFTEST <= layer.young_modulus <= STIFFEST:
        raise InputError(
            f"layer.young_modulus is {layer.young_modulus:.3g} Pa, expected {SOFTEST:g} to "
            f"{STIFFEST:g} Pa: 150 kPa is 150e3"
        )


class Quantity(ABC):
    """A linear map from pressure to readings, and what undoes the reading's known nonlinearity.

    Attributes
    ----------
    symbol : str
        As it stands on the axis of a figure.
    unit : str
        Of a reading; "1" for a ratio.
    typical_noise : float
        Standard deviation of one reading where nobody has measured it, in `unit`.
    lowest, highest : float
        No reading can be as low, or as high, as this, in `unit`.
    """

    symbol: ClassVar[str]
    unit: ClassVar[str] = "1"
    typical_noise: ClassVar[float] = 0.002
    lowest: ClassVar[float] = -np.inf
    highest: ClassVar[float] = 1e12  # of a stress, Pa: as stiff as diamond

    @abstractmethod
    def matrix(
        self, mechanics: Mechanics, layer: Layer, grid: Grid, taxels: Floats, pad_diameter: float
    ) -> Floats:
        """Readings of taxels at (L, 2) m of the plane per Pa on each node: (L, K)."""

    def linearise(self, readings: Floats, out: Floats) -> Floats:
        """Readings of a linear sensor: `readings` themselves, or written into `out`."""
        return readings

    def from_linear(self, linear: Floats) -> Floats:
        """Readings of those of a linear sensor: what `linearise` undoes."""
        return linear


def _response(mechanics: Mechanics, layer: Layer, grid: Grid, taxels: Floats, pad: float,
              name: str) -> Floats:  # fmt: skip
    """Stress, indentation or charge at taxels (L, 2) m by a pressure on each node, (L, K)."""
    if isinstance(mechanics, CurvedLayer):
        curved = mechanics.on_grid(name, layer, grid, taxels, pad)
        if curved is not None:
            return curved
    of = mechanics.base_stress if name == "stress" else mechanics.indentation
    options = {"electrostatic": True} if name == "charge" else {}
    offsets = (taxels[:, None, :] - grid.plane[None, :, :]).reshape(-1, 2)
    return of(layer, offsets, grid.pitch, pad, **options).reshape(len(taxels), len(grid))


@dataclass(frozen=True)
class BaseStress(Quantity):
    """Normal stress on the base in Pa: what the paper takes a taxel to measure.

    Parameters
    ----------
    pad_averaged : bool
        Average over the pad; else the stress at its centre, as in the paper.
    """

    pad_averaged: bool = True

    symbol = "stress"
    unit = "Pa"
    typical_noise = 400.0

    def matrix(
        self, mechanics: Mechanics, layer: Layer, grid: Grid, taxels: Floats, pad_diameter: float
    ) -> Floats:
        """See `Quantity.matrix`; Pa per Pa."""
        pad = pad_diameter * self.pad_averaged
        return _response(mechanics, layer, grid, taxels, pad, "stress")


@dataclass(frozen=True)
class Gap(Quantity):
    """Mean indentation over the pad divided by the thickness: the strain of the gap.

    With a Poisson's ratio of 0.5 it is blind to uniform pressure and negative beside a contact.

    Parameters
    ----------
    pad_averaged : bool
        Average over the pad; else the indentation above its centre.
    """

    pad_averaged: bool = True

    symbol = "indentation / thickness"

    def matrix(
        self, mechanics: Mechanics, layer: Layer, grid: Grid, taxels: Floats, pad_diameter: float
    ) -> Floats:
        """See `Quantity.matrix`; 1/Pa."""
        pad = pad_diameter if self.pad_averaged else 0.0
        return _response(mechanics, layer, grid, taxels, pad, "indentation") / layer.thickness


@dataclass(frozen=True)
class Capacitance(Quantity):
    r"""Relative change of capacitance, :math:`\Delta C / C_0`, of a pad under a ground plane.

    The field lines between the electrodes smooth the indentation w by
    :math:`\hat S = kh/\sinh kh`; to first order the reading is the pad's mean of S w/h, and
    `simulate.Press.capacitance` has the field in the deformed gap. Without `pad_averaged` it is
    S w/h above the centre.

    Parameters
    ----------
    order : None, 1, 2 or 3
        None for readings of the field in the deformed gap itself, or the terms of the series in
        the strain that made them: those of the first are linear.
    pad_averaged : bool
        Average over the pad; else the density of charge at its centre.
    """

    order: int | None = None
    pad_averaged: bool = True

    symbol = "ΔC/C₀"
    lowest = -1.0  # a pad cannot lose all its capacitance
    highest = 100.0  # of the gap, 1 % is left

    def __post_init__(self) -> None:
        if self.order is not None:
            why = "terms of the series, or None for the field in the deformed gap"
            check_choice("order", str(self.order), ("1", "2", "3"), why)

    def matrix(
        self, mechanics: Mechanics, layer: Layer, grid: Grid, taxels: Floats, pad_diameter: float
    ) -> Floats:
        """See `Quantity.matrix`; 1/Pa, the series' first term."""
        pad = pad_diameter if self.pad_averaged else 0.0
        return _response(mechanics, layer, grid, taxels, pad, "charge") / layer.thickness

    def linearise(self, readings: Floats, out: Floats) -> Floats:
        """Strain c / (1 + c), exact for a uniform gap, C/C0 = 1/(1 - w/h); order 1: `readings`.

        The rest of the nonlinearity depends on the shape of the indentation and stays an error of
        every linear solver.
        """
        if self.order == 1:
            return readings
        np.add(readings, 1.0, out=out)
        return np.divide(readings, out, out=out)

    def from_linear(self, linear: Floats) -> Floats:
        """See `Quantity.from_linear`; strains that no gap has are taken for the highest."""
        if self.order == 1:
            return linear
        strain = np.minimum(linear, STEEPEST)
        return np.asarray(strain / (1.0 - strain))


@dataclass(frozen=True, eq=False)
class Deformation:
    """Linear map from pressure (K,) Pa to displacement (K, 3) m in the patch's frame.

    On a regular grid the response depends on the offset alone, so the map is a convolution.
    """

    grid: Grid
    layer: Layer
    mechanics: Mechanics

    @cached_property
    def _convolution(self) -> LatticeConvolution:
        rows, columns = self.grid.shape
        pitch = self.grid.pitch
        outward = displacement_kernel(self.mechanics, self.layer, pitch, rows - 1, columns - 1)
        return LatticeConvolution(-outward)  # pressure pushes inwards

    def on(self, grid: Grid) -> "Deformation":
        """The same map for nodes at the same places of another patch's plane; it is shared."""
        other = replace(self, grid=grid)
        vars(other)["_convolution"] = self._convolution
        return other

    def __call__(self, pressure: Floats) -> Floats:
        """Displacement (..., K, 3) of pressures (..., K)."""
        flat = pressure.reshape(-1, *self.grid.shape)
        out = np.empty((len(flat), len(self.grid), 3))
        for index, load in enumerate(flat):
            local = self._convolution(load).reshape(3, -1)
            out[index] = np.einsum("kij,jk->ki", self.grid.frames, local)
        return out.reshape(*pressure.shape, 3)


@dataclass(frozen=True)
class Physics:
    """What taxels are made of and read.

    Attributes
    ----------
    layer : Layer
    mechanics : Mechanics
    quantity : Quantity
    pad_diameter : float, m
    laid_flat : Layer, optional
        On curved skin, the flat layer in the plane that reads nearly the same of a press.
    """

    layer: Layer
    mechanics: Mechanics
    quantity: Quantity
    pad_diameter: float
    laid_flat: Layer | None = None

    @property
    def flat(self) -> "Physics":
        """That of the layer laid flat: what contacts are fitted by."""
        if not isinstance(self.mechanics, CurvedLayer):
            return self
        mechanics = BondedLayer(self.mechanics.inextensible_cover)
        return Physics(self.laid_flat or self.layer, mechanics, self.quantity, self.pad_diameter)


PRESS = 1.25  # thicknesses: radius of a usual contact


def on_surface(grid: Grid, layer: Layer, mechanics: Mechanics) -> Grid:
    """Nodes where pressure acts: on curved skin, the outer surface above those of a grid."""
    return mechanics.outer(grid, layer) if isinstance(mechanics, CurvedLayer) else grid


def _laid_flat(physics: Physics, curved: Floats, grid: Grid) -> Layer:
    """The flat layer that reads the same force above a pad alike, (L, K) being the curved one's.

    Waves of the middle of the layer are longer than those of its base: it is thinner by as much.
    The modulus takes what is left; a stress on the base does not depend on it.
    """
    layer = physics.layer
    if isinstance(physics.quantity, BaseStress):
        return layer
    between = grid.spread**0.25  # what lengths on the middle of the layer are on its base
    thinner = replace(layer, thickness=round(layer.thickness / between, 7))
    mechanics, quantity, pad = physics.flat.mechanics, physics.quantity, physics.pad_diameter
    flat = quantity.matrix(mechanics, thinner, grid, grid.patch.plane, pad)
    radius = max(PRESS * layer.thickness, 1.5 * grid.pitch)
    away = np.linalg.norm(grid.patch.plane[:, None] - grid.plane, axis=2) / radius
    dome = np.sqrt(np.maximum(1.0 - away**2, 0.0))
    known = np.sum(flat * dome, axis=1), np.sum(curved * dome, axis=1) / grid.spread
    pressed = (known[0] > 0.0) & (known[1] > 0.0)
    if not pressed.any():
        return thinner
    stiffer = float(np.median(known[0][pressed] / known[1][pressed]).round(4))
    return replace(thinner, young_modulus=stiffer * layer.young_modulus)


@dataclass(frozen=True, eq=False)
class ObservationModel:
    """Readings of L taxels as a linear function of the pressure on K nodes.

    Attributes
    ----------
    matrix : (L, K) array, unit of the reading per Pa
    noise_std : (L,) array, unit of the reading
        Of one reading, independent from taxel to taxel.
    taxels : (L, 2) array, m
        In the patch's plane.
    grid : Grid
        The K nodes.
    virtual_matrix : function of (N, 2) array
        The matrix (N, K) of taxels that would stand elsewhere in the plane, each a point: readings
        that are interpolated between pads are no pad's mean.
    physics : Physics, optional
        What the matrix was made of, for solvers that model more than its linear map.
    """

    matrix: Floats
    noise_std: Floats
    taxels: Floats
    grid: Grid
    virtual_matrix: Callable[[Floats], Floats]
    physics: Physics | None = None

    def __post_init__(self) -> None:
        check_shape("matrix", self.matrix, (None, len(self.grid)), "one column per node")
        taxels = len(self.matrix)
        check_shape("noise_std", self.noise_std, (taxels,), "one per row of matrix")
        check_shape("taxels", self.taxels, (taxels, 2), "one per row of matrix")
        if not (np.isfinite(self.noise_std).all() and (self.noise_std > 0).all()):
            row = int(np.argmin(np.nan_to_num(self.noise_std, nan=-1.0, posinf=-1.0)))
            raise InputError(
                f"noise_std[{row}] is {self.noise_std[row]}, expected a finite number above 0: "
                "no reading is exact; give the standard deviation of a quiet taxel"
            )

    @classmethod
    def of(
        cls,
        patch: Patch,
        layer: Layer,
        grid: Grid,
        mechanics: Mechanics,
        quantity: Quantity,
        noise_std: ArrayLike | None = None,
    ) -> "ObservationModel":
        """Model of a patch.

        Parameters
        ----------
        patch : Patch
        layer : Layer
        grid : Grid
            On the patch; a node stands for the outer surface above it. That of the model has its
            nodes there, with the areas there, where the skin is curved.
        mechanics : Mechanics
            `BondedLayer()`; on a sphere or cylinder, `CurvedLayer()`.
        quantity : Quantity
            `Capacitance()`, `BaseStress()` or `Gap()`.
        noise_std : float or (L,) array, unit of the reading, optional
            One for all taxels, or each its own. Default the quantity's `typical_noise`.
        """
        noise_std = quantity.typical_noise if noise_std is None else noise_std
        grid = on_surface(grid, layer, mechanics)

        def virtual_matrix(taxels: Floats) -> Floats:
            return quantity.matrix(mechanics, layer, grid, taxels, pad_diameter=0.0)

        noise = as_floats("noise_std", noise_std)
        if noise.ndim == 0:
            noise = np.full(len(patch), float(noise))
        matrix = quantity.matrix(mechanics, layer, grid, patch.plane, patch.pad_diameter)
        physics = Physics(layer, mechanics, quantity, patch.pad_diameter)
        if isinstance(mechanics, CurvedLayer):
            physics = replace(physics, laid_flat=_laid_flat(physics, matrix, grid))
        return cls(matrix, noise, patch.plane, grid, virtual_matrix, physics)

    def subset(self, rows: NDArray[np.bool_]) -> "ObservationModel":
        """Model of some of the taxels, by a mask (L,)."""
        return replace(
            self, matrix=self.matrix[rows], noise_std=self.noise_std[rows], taxels=self.taxels[rows]
        )
