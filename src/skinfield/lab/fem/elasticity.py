"""Elasticity of a section: the neo-Hookean solid with a pressure of its own, and its Hooke tangent.

With c = dJ/dF and Lame's λ (infinite for ν = 1/2) the energy per volume is

    W = μ/2 (F:F - 3) - μ ln J + p (J - 1) - p²/(2λ)

(Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd ed., section 6.4.3,
there without the pressure). F has the entries rr, rz, zr, zz, θθ. At small strain there is one
factorisation of the stiffness, then any forces on the surface.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix

from skinfield.elastic import Layer
from skinfield.errors import Floats, Ints
from skinfield.lab.fem.mesh import Section

IDENTITY = np.array([1.0, 0.0, 0.0, 1.0, 1.0])


def jacobian(f: Floats) -> tuple[Floats, Floats, Floats]:
    """J (...), its derivative c (..., 5) and its second derivative (..., 5, 5)."""
    rr, rz, zr, zz, turn = np.moveaxis(f, -1, 0)
    plane = rr * zz - rz * zr
    first = np.stack([zz * turn, -zr * turn, -rz * turn, rr * turn, plane], axis=-1)
    second = np.zeros((*f.shape, 5))
    for i, j, value in (
        (0, 3, turn), (1, 2, -turn), (0, 4, zz), (1, 4, -zr), (2, 4, -rz), (3, 4, rr),
    ):  # fmt: skip
        second[..., i, j] = second[..., j, i] = value
    return plane * turn, first, second


@dataclass(frozen=True, eq=False)
class Elasticity:
    """Forces and stiffness of a section.

    Parameters
    ----------
    section : Section
    shear_modulus : float
        In Young's moduli.
    bulk_compliance : float
        1/λ, zero when incompressible.
    """

    section: Section
    shear_modulus: float
    bulk_compliance: float

    def valid(self, state: Floats) -> bool:
        """Whether no element is turned inside out, or nearly."""
        return bool(self._kinematics(state)[2].min() > 0.1)

    def forces(self, state: Floats) -> Floats:
        """Derivative of the energy by the unknowns, (unknowns,), at a state (unknowns,)."""
        mesh = self.section
        f, p, j, first, _ = self._kinematics(state)
        mu = self.shear_modulus
        stress = mu * f + (p - mu / j)[..., None] * first
        local = np.einsum("eqai,eqi,eq->ea", mesh.gradient, stress, mesh.weight)
        strain = j - 1 - self.bulk_compliance * p
        local_p = np.einsum("eqa,eq,eq->ea", mesh.pressure_shape, strain, mesh.weight)
        total = np.zeros(mesh.unknowns)
        np.add.at(total, mesh.displacement_dofs, local)
        np.add.at(total, mesh.displacements + mesh.pressure_dofs, local_p)
        return total

    def stiffness(self, state: Floats) -> csc_matrix:
        """Second derivative of the energy, (unknowns, unknowns), at a state (unknowns,)."""
        mesh = self.section
        _, p, j, first, second = self._kinematics(state)
        mu = self.shear_modulus
        moduli = (mu / j**2)[..., None, None] * first[..., :, None] * first[..., None, :]
        moduli += (p - mu / j)[..., None, None] * second + mu * np.eye(5)
        moduli *= mesh.weight[..., None, None]
        elements, points, local, _ = mesh.gradient.shape
        flat = mesh.gradient.transpose(0, 2, 1, 3).reshape(elements, local, points * 5)
        stressed = (mesh.gradient @ moduli).transpose(0, 2, 1, 3).reshape(flat.shape)
        block = flat @ stressed.transpose(0, 2, 1)
        volume = np.einsum("eqai,eqi,eq->eqa", mesh.gradient, first, mesh.weight)
        coupling = volume.transpose(0, 2, 1) @ mesh.pressure_shape
        weighted = mesh.pressure_shape * mesh.weight[..., None]
        bulk = -self.bulk_compliance * weighted.transpose(0, 2, 1) @ mesh.pressure_shape
        full = np.concatenate(
            [
                np.concatenate([block, coupling], axis=2),
                np.concatenate([coupling.transpose(0, 2, 1), bulk], axis=2),
            ],
            axis=1,
        )
        dofs = np.concatenate(
            [mesh.displacement_dofs, mesh.displacements + mesh.pressure_dofs], axis=1
        )
        rows = np.broadcast_to(dofs[:, :, None], full.shape).ravel()
        columns = np.broadcast_to(dofs[:, None, :], full.shape).ravel()
        size = (mesh.unknowns, mesh.unknowns)
        return csc_matrix(coo_matrix((full.ravel(), (rows, columns)), shape=size))

    def _kinematics(self, state: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        mesh = self.section
        u, p = state[: mesh.displacements], state[mesh.displacements :]
        f = IDENTITY + np.einsum("eqai,ea->eqi", mesh.gradient, u[mesh.displacement_dofs])
        pressure = np.einsum("eqa,ea->eq", mesh.pressure_shape, p[mesh.pressure_dofs])
        j, first, second = jacobian(f)
        return f, pressure, j, first, second


def free_unknowns(mesh: Section) -> Ints:
    """Indices of what the supports do not fix."""
    return np.flatnonzero(np.concatenate([mesh.free, np.ones(mesh.pressures, dtype=bool)]))


def law_of(layer: Layer, mesh: Section) -> Elasticity:
    """Hooke's or the neo-Hookean law of the layer, in units of its Young's modulus."""
    return Elasticity(mesh, *moduli(layer))


def moduli(layer: Layer) -> tuple[float, float]:
    """Shear modulus and the inverse of Lamé's λ, in units of Young's modulus."""
    nu = max(layer.poisson_ratio, 1e-6)  # at 0 the pressure has no stiffness to be a part of
    return 0.5 / (1 + nu), (1 + nu) * (1 - 2 * nu) / nu


@dataclass(frozen=True, eq=False)
class LinearSection:
    """A section that is ready to be loaded.

    Attributes
    ----------
    section : Section
    stiffness : sparse matrix (unknowns, unknowns)
    factor : SuperLU
        Of its free part.
    """

    section: Section
    stiffness: Any
    factor: Any

    @classmethod
    def prepare(cls, law: Elasticity) -> "LinearSection":
        """Assemble and factorise."""
        from scipy.sparse.linalg import splu

        section = law.section
        stiffness = law.stiffness(np.zeros(section.unknowns))
        free = free_unknowns(section)
        return cls(section, stiffness, splu(stiffness[free][:, free].tocsc()))

    def respond(self, forces: Floats) -> Floats:
        """State (unknowns, ...) under forces (nodes, ...) into the nodes of the surface."""
        load = np.zeros((self.section.unknowns, *forces.shape[1:]))
        load[self.section.top_z] = -forces
        state, free = np.zeros_like(load), free_unknowns(self.section)
        state[free] = self.factor.solve(load[free])
        return state

    def flexibility(self, nodes: Ints) -> Floats:
        """Displacement into the layer per force, among some nodes of the surface, (n, n)."""
        unit = np.zeros((len(self.section.top_z), len(nodes)))
        unit[nodes, np.arange(len(nodes))] = 1.0
        return -self.respond(unit)[self.section.top_z[nodes]]
