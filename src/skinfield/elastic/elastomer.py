"""The elastomer layer, and the protocol of its mechanics."""

from dataclasses import dataclass
from typing import Protocol

from skinfield.errors import Floats, check_positive, check_range


@dataclass(frozen=True)
class Layer:
    """A homogeneous, isotropic elastic layer bonded to the rigid robot.

    Parameters
    ----------
    thickness : float, m
        Of the undeformed elastomer, the paper's h.
    young_modulus : float, Pa
        At small strain, the paper's E.
    poisson_ratio : float
        0 to 0.5; 0.5 is incompressible, as solid silicone is to four digits.
    relative_permittivity : float
        Of the elastomer as a dielectric; about 3 for silicone.
    """

    thickness: float = 2e-3
    young_modulus: float = 150e3
    poisson_ratio: float = 0.5
    relative_permittivity: float = 3.0

    def __post_init__(self) -> None:
        check_positive("thickness", self.thickness, "the elastomer's height in metres")
        check_positive("young_modulus", self.young_modulus, "the elastomer's stiffness in Pa")
        check_range("poisson_ratio", self.poisson_ratio, 0.0, 0.5, "0.5 is incompressible")
        check_range("relative_permittivity", self.relative_permittivity, 1.0, 1e4, "vacuum has 1")
        if self.thickness >= 1.0:
            check_range("thickness", self.thickness, 0.0, 1.0, "give it in metres: 2 mm is 2e-3")


class Mechanics(Protocol):
    """Any model of the elastomer; `BondedLayer` and `HalfSpace` are two."""

    def base_stress(
        self, layer: Layer, offset: Floats, cell: float, pad_diameter: float = 0.0
    ) -> Floats:
        """Normal stress at taxels, (N,) Pa, per Pa of pressure on a cell at `offset` (N, 2) m."""
        ...

    def base_traction(
        self, layer: Layer, offset: Floats, cell: float, pad_diameter: float = 0.0
    ) -> Floats:
        """Traction on the base, (N, 3, 3) Pa, per Pa of traction on a cell at `offset`."""
        ...

    def surface_displacement(self, layer: Layer, offset: Floats, cell: float) -> Floats:
        """Displacement of the surface, (N, 3, 3) m, per Pa of traction on a cell."""
        ...

    def indentation(
        self,
        layer: Layer,
        offset: Floats,
        cell: float,
        pad_diameter: float = 0.0,
        electrostatic: bool = False,
    ) -> Floats:
        """Inward displacement averaged over a pad, (N,) m, per Pa of pressure on a cell."""
        ...

    def reach(self, layer: Layer) -> float:
        """Distance in m beyond which responses are negligible; infinite if they never are."""
        ...
