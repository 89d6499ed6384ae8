"""Paper's algorithm as printed, and its patch, indenters and methods."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from skinfield.elastic import BaseStress, BondedLayer, HalfSpace, Layer, Mechanics, Quantity
from skinfield.errors import Floats
from skinfield.reconstruct import Reconstructor
from skinfield.simulate import Cylinder, Press, Sphere, press
from skinfield.simulate.pressing.press import Readings, readings_anywhere
from skinfield.skin import Grid, Patch
from skinfield.skin.generators import hexagon72
from skinfield.solve import GaussianField, Inverse, Solver


class Reconstruction(NamedTuple):
    """What the paper's algorithm finds at the N nodes of a square grid."""

    force: Floats  # (N,) N, positive when pushing
    normal: Floats  # (N,) m, displacement into the skin
    tangential: Floats  # (N, 2) m, displacement in the plane


def virtual_readings(readings: Floats, taxels_xy: Floats, nodes: Floats) -> Floats:
    """Section III-B, steps 1 to 3: convex combinations, zero for nodes outside the hull."""
    from scipy.spatial import Delaunay

    triangulation = Delaunay(taxels_xy)
    triangle = triangulation.find_simplex(nodes, tol=1e-9)
    affine = triangulation.transform[triangle]
    first = np.einsum("nij,nj->ni", affine[:, :2], nodes - affine[:, 2])
    weights = np.column_stack([first, 1.0 - first.sum(axis=1)])
    virtual = np.sum(weights * readings[triangulation.simplices[triangle]], axis=1)
    return np.asarray(np.where(triangle >= 0, virtual, 0.0))


def stress_matrix(offset: Floats, thickness: float) -> Floats:
    """Elements (11) in their correct form, Pa/N, for offsets (N, N, 2)."""
    square = np.sum(offset**2, axis=-1)
    return np.asarray(3.0 * thickness**3 / (2.0 * np.pi * (square + thickness**2) ** 2.5))


def displacements(
    force: Floats, offset: Floats, cell_area: float, layer: Layer, psi: float
) -> tuple[Floats, Floats]:
    """(18) and (19) corrected, for normal forces, and (26) where the force meets itself."""
    h, modulus = layer.thickness, layer.young_modulus
    square = np.sum(offset**2, axis=-1)
    away = np.sqrt(np.where(square == 0.0, np.inf, square))
    below = np.sqrt(square + h**2)
    factor = 3.0 / (4.0 * np.pi * modulus)
    normal = factor * (1.0 / away - (1.0 + h**2 / below**2) / below)
    depth = np.sqrt(3.0 * cell_area / (2.0 * np.pi))
    np.fill_diagonal(normal, 9.0 / (2.0 * np.pi * modulus * depth) * psi)
    tangential = -factor * h * offset / below[..., None] ** 3
    return normal @ force, np.einsum("nkc,k->nc", tangential, force)


def reconstruct_as_paper(
    readings: Floats,
    taxels_xy: Floats,
    nodes: Floats,
    layer: Layer,
    cell_area: float,
    psi: float = 0.25,
) -> Reconstruction:
    """Force and displacement at the nodes from one reading of the taxels.

    Parameters
    ----------
    readings : (L,) array, Pa
        Normal stress at the taxels, compression positive.
    taxels_xy : (L, 2) array, m
    nodes : (N, 2) array, m
        Virtual taxels, and places of the forces.
    layer : Layer
        Incompressible; its Poisson's ratio is not looked at.
    cell_area : float, m²
        Area around one node.
    psi : float
        0.25 is the paper's; skinfield's exact value depends on thickness and area.
    """
    offset = nodes[:, None] - nodes[None]
    virtual = virtual_readings(readings, taxels_xy, nodes)
    force = np.linalg.inv(stress_matrix(offset, layer.thickness)) @ virtual
    normal, tangential = displacements(force, offset, cell_area, layer, psi)
    return Reconstruction(force, normal, tangential)


LAYER = Layer(thickness=2e-3, young_modulus=100e3, poisson_ratio=0.5)  # the paper states no modulus
# Standard deviation of one reading, Pa and ΔC/C₀. 3.8 kPa is the noise at which the paper's own
# method misses 0.2 N and finds 0.5 N over a taxel, as the paper reports.
NOISES = {"stress": 3.8e3, "capacitance": 0.02}
FALSE_ALARMS = 1e-3  # share of idle readings in which a contact may be found
RATE = 50.0  # readings per second, where averages are times
LOADS = (0.2, 0.5, 1.8, 3.0)  # N
PLACES = ("over a taxel", "between two", "between three")
INNER = 20e-3  # m from the patch's middle: no press reaches over its rim
PAIR = 6e-3  # m: taxels that are neighbours


@dataclass(frozen=True)
class Tip:
    """One of the paper's four indenters.

    Parameters
    ----------
    name : str
    body : Sphere or Cylinder
        At the origin; its load is set for each press.
    extent : float, m
        Side of the square in which it may touch.
    """

    name: str
    body: Sphere | Cylinder
    extent: float

    @lru_cache(maxsize=64)  # noqa: B019  # there are four tips
    def pressed(self, layer: Layer, force: float, cell: float) -> Press:
        """Truth under a force in N.

        Raises
        ------
        InputError
            Where linear elasticity lets the tip sink through the layer.
        """
        return press(layer, [replace(self.body, force=force)], self.extent, cell)

    def contact_radius(self, force: float, cell: float) -> float:
        """Radius of the disc as large as the true contact on the paper's layer, m."""
        return float(np.sqrt(self.pressed(LAYER, force, cell).contact_area / np.pi))


TIPS = (
    Tip("half-sphere 0.6 cm", Sphere(radius=3e-3), 8e-3),
    Tip("half-sphere 1.2 cm", Sphere(radius=6e-3), 12e-3),
    Tip("cylinder 0.3 cm", Cylinder(radius=1.5e-3), 6e-3),
    Tip("cylinder 1.2 cm", Cylinder(radius=6e-3), 14e-3),
)
BALL = TIPS[1]  # of Figures 6 to 8


@lru_cache(maxsize=128)
def _anywhere(tip: Tip, force: float, cell: float, quantity: str) -> Readings:
    pressed = tip.pressed(LAYER, force, cell)
    return readings_anywhere(pressed, paper_patch().pad_diameter, quantity)


def readings(tip: Tip, force: float, cell: float, places: Floats, quantity: str) -> Floats:
    """Readings (P, L) without noise of the paper's patch that is pressed at places (P, 2) m.

    Raises
    ------
    InputError
        Where linear elasticity lets the tip sink through the layer.
    """
    apart = (paper_patch().plane[None] - places[:, None]).reshape(-1, 2)
    return _anywhere(tip, force, cell, quantity)(apart).reshape(len(places), -1)


@lru_cache(maxsize=1)
def paper_patch() -> Patch:
    """The hexagon of six modules with 72 taxels."""
    return hexagon72()


@lru_cache(maxsize=1)
def sites() -> dict[str, Floats]:
    """Places (P, 2) m for each of `PLACES`, away from the rim of the paper's patch."""
    from scipy.spatial import Delaunay

    plane = paper_patch().plane
    corners = plane[Delaunay(plane).simplices]  # (T, 3, 2)
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    close = corners[(sides < PAIR).all(axis=1)]
    middles = ((corners + np.roll(corners, 1, axis=1)) / 2)[sides < PAIR]
    found = (plane, np.unique(middles.round(9), axis=0), close.mean(axis=1))
    return {
        name: places[np.linalg.norm(places, axis=1) < INNER]
        for name, places in zip(PLACES, found, strict=True)
    }


@dataclass(frozen=True)
class Method:
    """A solver with what it assumes of elastomer and taxels.

    Parameters
    ----------
    name : str
    solver : Solver
    mechanics : Mechanics
    quantity : Quantity
        What it takes the readings to be.
    """

    name: str
    solver: Solver
    mechanics: Mechanics
    quantity: Quantity

    def prepared(self, nodes: int, noise_std: float, precision: Any = np.float64) -> Reconstructor:
        """Reconstruction of the paper's patch on `nodes` x `nodes`, as in its figures."""
        return Reconstructor(
            paper_patch(),
            LAYER,
            Grid.square(paper_patch(), nodes=nodes),
            mechanics=self.mechanics,
            quantity=self.quantity,
            solver=self.solver,
            noise_std=noise_std,
            precision=precision,
        )


POINT = BaseStress(pad_averaged=False)
PRINTED = HalfSpace(psi=0.25)  # the paper's constant in (25) and (26), "in all the experiments"
PAPER = Method("paper: inverse, half-space", Inverse(), PRINTED, POINT)
FIELD = Method("ours: Gaussian field, layer", GaussianField(), BondedLayer(), BaseStress())
