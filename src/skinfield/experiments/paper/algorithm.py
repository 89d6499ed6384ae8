"""The paper's algorithm as printed (with its formulas corrected), all of it for every reading.

Nothing is prepared: each call triangulates, interpolates, builds and inverts the matrix of (12)
and sums (18), (19) with the coincident terms (25), (26). It is written from the paper's formulas
alone, without skinfield's mechanics, so that it is a second opinion as well as a yardstick.
"""

from typing import NamedTuple

import numpy as np

from skinfield.errors import Floats
from skinfield.mechanics import Layer


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
