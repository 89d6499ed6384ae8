"""Small strain: one factorisation of the stiffness, then any forces on the surface."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skinfield.errors import Floats, Ints
from skinfield.fem.law import Elasticity
from skinfield.fem.section import Section
from skinfield.mechanics import Layer


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
