"""The elastomer layer, and the protocol of its mechanics."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from skinfield.elastic.viscoelastic import StandardLinearSolid
from skinfield.errors import (
    Floats,
    as_floats,
    check_finite,
    check_positive,
    check_range,
    check_shape,
    check_type,
)
from skinfield.plot import (
    INK,
    ORANGE,
    QUIET,
    Pictured,
    Place,
    add_title,
    axes_for,
    number,
    style,
)

VACUUM_PERMITTIVITY = 8.8541878128e-12
"""F/m, CODATA 2018."""
PADS = 3  # in a figure of a layer
BASE = 0.4  # mm: of the board that is drawn


@dataclass(frozen=True, repr=False)
class Layer(Pictured):
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
    relaxation : StandardLinearSolid, optional
        How it creeps, which readings that have stamps are freed from. Default not at all. The
        modulus is the relaxed one.
    """

    thickness: float = 2e-3
    young_modulus: float = 150e3
    poisson_ratio: float = 0.5
    relative_permittivity: float = 3.0
    relaxation: StandardLinearSolid | None = None

    def __post_init__(self) -> None:
        check_positive("thickness", self.thickness, "the elastomer's height in metres")
        check_positive("young_modulus", self.young_modulus, "the elastomer's stiffness in Pa")
        check_range("poisson_ratio", self.poisson_ratio, 0.0, 0.5, "0.5 is incompressible")
        check_range("relative_permittivity", self.relative_permittivity, 1.0, 1e4, "vacuum has 1")
        if self.relaxation is not None:
            how = "such as StandardLinearSolid(0.85, 1.0), or None"
            check_type("relaxation", self.relaxation, StandardLinearSolid, how)
        if self.thickness >= 1.0:
            check_range("thickness", self.thickness, 0.0, 1.0, "give it in metres: 2 mm is 2e-3")

    def __repr__(self) -> str:
        return f"Layer({', '.join(f'{name} {text}' for name, text in self._lengths().items())})"

    def _lengths(self) -> dict[str, str]:
        solid, creep = self.relaxation, {}
        if solid is not None:
            part = f"{1.0 - solid.relaxed_fraction:.1%}"
            creep = {"creep": f"{part} in {number(solid.time_constant)} s"}
        return {
            "thickness": f"{number(self.thickness * 1e3)} mm",
            "E": f"{number(self.young_modulus * 1e-3)} kPa",
            "ν": f"{self.poisson_ratio:g}",
            "εᵣ": f"{self.relative_permittivity:g}",
        } | creep

    def plot(self, ax: Place = None, *, pad_diameter: float = 4e-3) -> Any:
        """Draw a cross-section to scale, with pads below the elastomer; lengths in mm.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            To draw in. Default those of a new figure.
        pad_diameter : float, m
            Of the pads, which lie two diameters apart.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        InputError
            If the diameter is not positive, `ax` is something else, or Matplotlib is not installed.
        """
        return plot_layer(self, ax, pad_diameter)

    def _facts(self) -> Mapping[str, str]:
        lengths = self._lengths()
        return {
            "Layer, thickness": lengths["thickness"],
            "Young's modulus E": lengths["E"],
            "Poisson's ratio ν": lengths["ν"],
            "relative permittivity εᵣ": lengths["εᵣ"],
        } | {name: lengths[name] for name in ("creep",) if name in lengths}

    def rest_capacitance(self, pad_diameter: float) -> float:
        """Capacitance at rest, F, of a round pad of `pad_diameter`, m: eq. (1) of the paper.

        C = ε₀ εᵣ A / h, without fringe: a 4 mm pad under 2 mm of silicone (εᵣ = 3) has 0.167 pF.
        """
        check_positive("pad_diameter", pad_diameter, "in metres, 4 mm is 4e-3")
        area = math.pi * pad_diameter**2 / 4.0
        return VACUUM_PERMITTIVITY * self.relative_permittivity * area / self.thickness


class Mechanics(Protocol):
    """Any model of the elastomer; `BondedLayer` and `HalfSpace` are two.

    Loads are uniform over a square cell with a side of `cell` m, and `offset` (N, 2) m leads from
    the cell's centre to the points of observation.
    """

    def base_stress(
        self, layer: Layer, offset: Floats, cell: float, pad_diameter: float = 0.0
    ) -> Floats:
        """Normal stress on the base under a unit pressure on one cell, as a round pad averages it.

        Parameters
        ----------
        layer : Layer
        offset : (N, 2) array, m
        cell : float, m
        pad_diameter : float, m
            0 for a point.

        Returns
        -------
        (N,) array, Pa/Pa
            Positive in compression.
        """
        ...

    def base_traction(
        self, layer: Layer, offset: Floats, cell: float, pad_diameter: float = 0.0
    ) -> Floats:
        """Traction on the base under a unit traction on one cell, as `base_stress`.

        Returns
        -------
        (N, 3, 3) array, Pa/Pa
            [n, i, j]: component i that the layer exerts on the plane of the base (outward normal
            +z, tension positive) per component j on the surface.
        """
        ...

    def surface_displacement(self, layer: Layer, offset: Floats, cell: float) -> Floats:
        """Displacement of the surface under a unit traction on one cell.

        Returns
        -------
        (N, 3, 3) array, m/Pa
            [n, i, j]: component i per component j.
        """
        ...

    def indentation(
        self,
        layer: Layer,
        offset: Floats,
        cell: float,
        pad_diameter: float = 0.0,
        electrostatic: bool = False,
    ) -> Floats:
        """Displacement into the skin above a pad, under a unit pressure on one cell.

        Parameters
        ----------
        layer, offset, cell, pad_diameter
            See `base_stress`.
        electrostatic : bool
            Smooth as the field lines between the electrodes do (`hankel.electrostatic`).

        Returns
        -------
        (N,) array, m/Pa
        """
        ...

    def lift(
        self,
        layer: Layer,
        offset: Floats,
        cell: float,
        pad_diameter: float = 0.0,
    ) -> Floats:
        """Displacement out of the skin above a pad, under a unit tangential traction on one cell.

        Parameters
        ----------
        layer, offset, cell, pad_diameter
            See `base_stress`.

        Returns
        -------
        (N, 2) array, m/Pa
            By traction along x, and along y. A skin that is pushed rises ahead and sinks behind.
        """
        ...

    def reach(self, layer: Layer) -> float:
        """Distance in m beyond which responses are negligible; infinite if they never are."""
        ...


def in_thicknesses(
    layer: Layer, offset: Floats, cell: float, pad_diameter: float
) -> tuple[Floats, float, float]:
    """Check lengths in m, and express them in thicknesses; the pad becomes its radius."""
    offset = as_floats("offset", offset)
    check_shape("offset", offset, (None, 2), "from the cell's centre to each point, in the plane")
    check_finite("offset", offset, "a point without a place feels nothing")
    check_positive("cell", cell, "the side of the loaded square, in metres")
    check_range("pad_diameter", pad_diameter, 0.0, 1.0, "0 is a point; give it in metres")
    h = layer.thickness
    return offset / h, cell / h, round(pad_diameter / 2 / h, 12)


def plot_layer(layer: Layer, ax: Place = None, pad_diameter: float = 4e-3) -> Any:
    """Draw a cross-section to scale; see `Layer.plot`."""
    check_positive("pad_diameter", pad_diameter, "in metres, 4 mm is 4e-3")
    high, pad = layer.thickness * 1e3, pad_diameter * 1e3
    half = PADS * pad
    with style():
        axes = axes_for(ax, (4.4, 4.4 * (high + 4.0 * BASE) / (2.0 * half)), (0.75, 0.55, 0.3, 0.6))
        axes.axhspan(0.0, high, color="#f0d8b7", lw=0.0)
        axes.axhspan(-2.0 * BASE, 0.0, color="#c9c9d1", lw=0.0)
        for place in range(PADS):
            middle = 2.0 * pad * (place - (PADS - 1) / 2)
            axes.plot([middle - pad / 2, middle + pad / 2], [0.0, 0.0], color=ORANGE, lw=3.0)
        axes.plot([-half, half], [high, high], color=INK, lw=1.0)
        look = {"arrowstyle": "<->", "color": QUIET, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (0.9 * half, 0.0), (0.9 * half, high), arrowprops=look)
        words = f"{number(high)} mm"
        axes.text(0.87 * half, high / 2, words, ha="right", va="center", fontsize=8)
        axes.set(xlim=(-half, half), ylim=(-2.0 * BASE, high + 2.0 * BASE))
        axes.set(xlabel="x (mm)", ylabel="height (mm)")
        axes.set_aspect("equal", adjustable="box", anchor="NW")
        note = f"elastomer over pads of {number(pad)} mm on their board, to scale"
        add_title(axes, "", repr(layer), note)
    return axes
