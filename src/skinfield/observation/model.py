"""What the taxels see of a pressure: the linear map every solver inverts."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, as_floats, check_shape
from skinfield.layout import Grid, Patch
from skinfield.mechanics import Layer, Mechanics
from skinfield.observation.quantity import Quantity


@dataclass(frozen=True)
class Physics:
    """What taxels are made of and read.

    Attributes
    ----------
    layer : Layer
    mechanics : Mechanics
    quantity : Quantity
    pad_diameter : float, m
    """

    layer: Layer
    mechanics: Mechanics
    quantity: Quantity
    pad_diameter: float


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
        noise_std: ArrayLike,
    ) -> "ObservationModel":
        """Model of a patch; `noise_std` is one number for all taxels or (L,)."""

        def virtual_matrix(taxels: Floats) -> Floats:
            return quantity.matrix(mechanics, layer, grid, taxels, pad_diameter=0.0)

        noise = as_floats("noise_std", noise_std)
        if noise.ndim == 0:
            noise = np.full(len(patch), float(noise))
        matrix = quantity.matrix(mechanics, layer, grid, patch.plane, patch.pad_diameter)
        physics = Physics(layer, mechanics, quantity, patch.pad_diameter)
        return cls(matrix, noise, patch.plane, grid, virtual_matrix, physics)

    def subset(self, rows: NDArray[np.bool_]) -> "ObservationModel":
        """Model of some of the taxels, by a mask (L,)."""
        return replace(
            self,
            matrix=self.matrix[rows],
            noise_std=self.noise_std[rows],
            taxels=self.taxels[rows],
        )
