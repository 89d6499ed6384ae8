"""Elements of the section of a round piece of layer: Taylor-Hood, Q2 displacement, Q1 pressure.

Lengths are in thicknesses of the layer and stresses in Young's moduli. The layer fills 0 <= z <= 1.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints
from skinfield.fem.library import scikit_fem
from skinfield.fem.trace import Trace

IN_PLANE = ((0, 0), (0, 1), (1, 0), (1, 1))  # component and direction of the gradient's entries


@dataclass(frozen=True, eq=False)
class Section:
    """What any elastic law needs to know about the mesh.

    Attributes
    ----------
    gradient : (elements, points, 18, 5) array
        Of the shape functions: d(u_r)/dr, d(u_r)/dz, d(u_z)/dr, d(u_z)/dz, u_r/r.
    pressure_shape : (elements, points, 4) array
    weight : (elements, points) array
        Volume of a quadrature point, turned about the axis.
    displacement_dofs : (elements, 18) array
    pressure_dofs : (elements, 4) array
    displacements, pressures : int
        Numbers of unknowns.
    free : (displacements,) array of bool
        False where the layer is held: base, rim, and the axis sideways.
    top_r, top_z, base_z : arrays of int
        Unknowns of the surface and of the base, from the axis outwards.
    trace : Trace
        The nodes of surface and base.
    """

    gradient: Floats
    pressure_shape: Floats
    weight: Floats
    displacement_dofs: Ints
    pressure_dofs: Ints
    displacements: int
    pressures: int
    free: NDArray[np.bool_]
    top_r: Ints
    top_z: Ints
    base_z: Ints
    trace: Trace

    @property
    def unknowns(self) -> int:
        """Displacements and pressures together."""
        return self.displacements + self.pressures


def mesh_section(radii: Floats, heights: Floats) -> Section:
    """Elements between the given radii and heights, both in thicknesses."""
    fem = scikit_fem()
    mesh = fem.MeshQuad.init_tensor(radii, heights)
    basis = fem.Basis(mesh, fem.ElementVector(fem.ElementQuad2()), intorder=5)
    pressure = fem.Basis(mesh, fem.ElementQuad1(), intorder=5)
    r, z = basis.doflocs
    component = _components(basis)
    held = (z == 0) | (r == radii[-1]) | ((r == 0) & (component == 0))

    def line(height: float, wanted: int) -> Ints:
        found = np.flatnonzero((z == height) & (component == wanted))
        return found[np.argsort(r[found])]

    top = line(heights[-1], 0)
    return Section(
        gradient=_gradients(basis),
        pressure_shape=np.stack([np.asarray(shape[0]) for shape in pressure.basis], axis=-1),
        weight=2 * np.pi * basis.global_coordinates()[0] * basis.dx,
        displacement_dofs=basis.element_dofs.T.astype(np.int64),
        pressure_dofs=pressure.element_dofs.T.astype(np.int64),
        displacements=basis.N,
        pressures=pressure.N,
        free=~held,
        top_r=top,
        top_z=line(heights[-1], 1),
        base_z=line(0.0, 1),
        trace=Trace(r[top]),
    )


def _components(basis: Any) -> Ints:
    """Component 0 or 1 of the displacement that each unknown stands for."""
    component = np.empty(basis.N, dtype=np.int64)
    for local, shape in enumerate(basis.basis):
        values = np.abs(np.asarray(shape[0])).max(axis=(1, 2))
        component[basis.element_dofs[local]] = int(values[1] > values[0])
    return component


def _gradients(basis: Any) -> Floats:
    radius = basis.global_coordinates()[0]
    columns = []
    for shape in basis.basis:
        field = shape[0]
        entries = [np.asarray(field.grad)[i, j] for i, j in IN_PLANE]
        columns.append(np.stack([*entries, np.asarray(field)[0] / radius], axis=-1))
    return np.stack(columns, axis=-2)
