"""Linear elasticity of a round piece of layer: Taylor-Hood elements, Q2 displacement, Q1 pressure.

Lengths are in thicknesses of the layer and stresses in Young's moduli; the layer fills 0 <= z <= 1.
Displacement u and pressure p make the energy per volume

    W = μ ε:ε + p div u - p²/(2λ)

stationary, with Lamé's λ infinite for ν = 1/2. The stiffness is factorised once, for any
forces on the surface.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bmat, csc_matrix

from skinfield.elastic import Layer
from skinfield.errors import Floats, Ints
from skinfield.lab.fem.mesh import Trace, scikit_fem


@dataclass(frozen=True, eq=False)
class LayerSection:
    """A layer between radii and heights, bonded at its base and held at its rim.

    Attributes
    ----------
    stiffness : sparse matrix (unknowns, unknowns)
        Of displacements and then pressures.
    free : (unknowns,) array of bool
        False where the layer is held: base, rim, and the axis sideways.
    factor : SuperLU
        Of the free part of the stiffness.
    top_r, top_z, base_z : arrays of int
        Unknowns of the surface and of the base, from the axis outwards.
    trace : Trace
        The nodes of surface and base.
    """

    stiffness: csc_matrix
    free: NDArray[np.bool_]
    factor: Any
    top_r: Ints
    top_z: Ints
    base_z: Ints
    trace: Trace

    @classmethod
    def of(cls, layer: Layer, radii: Floats, heights: Floats) -> "LayerSection":
        """Elements between the given radii and heights, both in thicknesses."""
        from scipy.sparse.linalg import splu

        fem = scikit_fem()
        mesh = fem.MeshQuad.init_tensor(radii, heights)
        basis = fem.Basis(mesh, fem.ElementVector(fem.ElementQuad2()), intorder=5)
        pressure = fem.Basis(mesh, fem.ElementQuad1(), intorder=5)
        stiffness = _stiffness(fem, layer, basis, pressure)
        r, z = basis.doflocs
        component = np.empty(basis.N, dtype=np.int64)
        for dofs in (basis.nodal_dofs, basis.facet_dofs, basis.interior_dofs):
            component[dofs] = np.arange(2)[:, None]
        held = (z == 0) | (r == radii[-1]) | ((r == 0) & (component == 0))
        free = np.concatenate([~held, np.ones(pressure.N, dtype=np.bool_)])

        def line(height: float, wanted: int) -> Ints:
            found = np.flatnonzero((z == height) & (component == wanted))
            return found[np.argsort(r[found])]

        top, last = line(heights[-1], 0), line(heights[-1], 1)
        factor = splu(stiffness[free][:, free].tocsc())
        return cls(stiffness, free, factor, top, last, line(0.0, 1), Trace(r[top]))

    def respond(self, forces: Floats) -> Floats:
        """State (unknowns, ...) under forces (nodes, ...) into the nodes of the surface."""
        load = np.zeros((len(self.free), *forces.shape[1:]))
        load[self.top_z] = -forces
        state = np.zeros_like(load)
        state[self.free] = self.factor.solve(load[self.free])
        return state

    def flexibility(self, nodes: Ints) -> Floats:
        """Displacement into the layer per force, among some nodes of the surface, (n, n)."""
        unit = np.zeros((len(self.top_z), len(nodes)))
        unit[nodes, np.arange(len(nodes))] = 1.0
        return -self.respond(unit)[self.top_z[nodes]]


def moduli(layer: Layer) -> tuple[float, float]:
    """Shear modulus and the inverse of Lamé's λ, in units of Young's modulus."""
    nu = max(layer.poisson_ratio, 1e-6)  # at 0 the pressure has no stiffness to be a part of
    return 0.5 / (1 + nu), (1 + nu) * (1 - 2 * nu) / nu


def _stiffness(fem: Any, layer: Layer, basis: Any, pressure: Any) -> csc_matrix:
    """Second derivative of the energy of the layer turned about the axis."""
    shear, compliance = moduli(layer)

    @fem.BilinearForm
    def strain(u, v, w):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
        a, b, r = u.grad, v.grad, w.x[0]
        skew = (a[0, 1] + a[1, 0]) * (b[0, 1] + b[1, 0]) / 2
        along = a[0, 0] * b[0, 0] + a[1, 1] * b[1, 1] + u[0] * v[0] / r**2
        return 2 * shear * (along + skew) * 2 * np.pi * r

    @fem.BilinearForm
    def volume(u, q, w):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
        return (u.grad[0, 0] + u.grad[1, 1] + u[0] / w.x[0]) * q * 2 * np.pi * w.x[0]

    @fem.BilinearForm
    def bulk(p, q, w):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
        return -compliance * p * q * 2 * np.pi * w.x[0]

    coupling = volume.assemble(basis, pressure)
    blocks = [[strain.assemble(basis), coupling.T], [coupling, bulk.assemble(pressure)]]
    return csc_matrix(bmat(blocks))
