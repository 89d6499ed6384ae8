"""What a model of the elastomer offers: responses to a load that is uniform over one cell."""

from typing import Protocol

from skinfield.errors import Floats
from skinfield.mechanics.elastomer import Layer


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
