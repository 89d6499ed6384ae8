"""A box of bricks, Q2 displacement and Q1 pressure, as products of three lines.

On a mesh of straight lines every integral is a product of integrals along them, so nothing is
assembled. The scalar operators can even be inverted exactly (Lynch, Rice and Thomas, Numer. Math. 6
(1964) 185): they precondition the elastic ones. Lengths in thicknesses, stresses in Young's moduli.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skinfield.errors import Floats, Ints
from skinfield.fem.lines import Line


def along_axes(matrices: Sequence[Floats], field: Floats) -> Floats:
    """Apply one matrix per axis to a field (nx, ny, nz)."""
    x, y, z = matrices
    field = field @ z.T
    field = np.matmul(y, field)
    shape = field.shape
    return np.asarray((x @ field.reshape(shape[0], -1)).reshape(-1, *shape[1:]))


@dataclass(frozen=True, eq=False)
class Box:
    """The layer, held at its base and its sides.

    Parameters
    ----------
    lines : (Line, Line, Line)
        Along x, y and z.
    mirror : bool
        Whether y = 0 is a plane of symmetry and the box is one half.
    shear_modulus, bulk_compliance : float
        Of the material; the latter zero when incompressible.
    """

    lines: tuple[Line, Line, Line]
    mirror: bool
    shear_modulus: float
    bulk_compliance: float

    @property
    def shape(self) -> tuple[int, int, int]:
        """Nodes of the displacement along x, y and z."""
        x, y, z = (len(line.nodes) for line in self.lines)
        return x, y, z

    @property
    def pressure_shape(self) -> tuple[int, int, int]:
        """Nodes of the pressure along x, y and z."""
        x, y, z = (len(line.pressure_mass) for line in self.lines)
        return x, y, z

    def free(self, component: int) -> tuple[slice, slice, slice]:
        """Nodes that a component of the displacement may move."""
        first = 0 if self.mirror and component != 1 else 1
        return slice(1, -1), slice(first, -1), slice(1, None)

    def forces(self, u: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Nodal forces (3, nx, ny, nz) of displacements and pressures, and volume changes."""
        out, volume = np.zeros_like(u), np.zeros_like(p)
        for i in range(3):
            mixed = [line.mixed for line in self.lines]
            mixed[i] = self.lines[i].divergence
            volume += along_axes(mixed, u[i])
            out[i] += along_axes([matrix.T for matrix in mixed], p)
            for j in range(3):
                out[i] += self.shear_modulus * self._coupling(i, j, u[j])
        masses = [line.pressure_mass for line in self.lines]
        return out, volume - self.bulk_compliance * along_axes(masses, p)

    def _coupling(self, i: int, j: int, u: Floats) -> Floats:
        """Forces along i of a displacement along j, per shear modulus."""
        matrices = [line.mass for line in self.lines]
        if i != j:
            matrices[j], matrices[i] = self.lines[j].slope, self.lines[i].slope.T
            return along_axes(matrices, u)
        total = np.zeros_like(u)
        for axis in range(3):
            stretched = list(matrices)
            stretched[axis] = self.lines[axis].stiffness * (2.0 if axis == i else 1.0)
            total += along_axes(stretched, u)
        return total

    @cached_property
    def _modes(self) -> list[tuple[tuple[Floats, Floats, Floats], Floats]]:
        """Per component: eigenvectors along the axes and the inverse of their stiffness."""
        found = []
        for component in range(3):
            pairs = [
                line.modes(free)
                for line, free in zip(self.lines, self.free(component), strict=True)
            ]
            weight = [2.0 if axis == component else 1.0 for axis in range(3)]
            x, y, z = (w * values for w, (_, values) in zip(weight, pairs, strict=True))
            total = self.shear_modulus * (x[:, None, None] + y[:, None] + z)
            vectors = (pairs[0][0], pairs[1][0], pairs[2][0])
            found.append((vectors, 1.0 / total))
        return found

    def yielding(self, component: int, forces: Floats) -> Floats:
        """Displacements (nx, ny, nz) if the components did not know of each other."""
        vectors, inverse = self._modes[component]
        return along_axes(vectors, inverse * along_axes([v.T for v in vectors], forces))

    def surface_yielding(self, i: Ints, j: Ints) -> Floats:
        """Of nodes (i, j) of the surface under vertical forces on each of them, (n, n)."""
        (x, y, z), inverse = self._modes[2]
        per_mode = np.einsum("mnk,k->mn", inverse, z[-1] ** 2)
        both = (x[i][:, :, None] * y[j][:, None, :]).reshape(len(i), -1)
        return np.asarray((both * per_mode.ravel()) @ both.T)

    @cached_property
    def _pressure_inverses(self) -> list[Floats]:
        return [np.asarray(np.linalg.inv(line.pressure_mass), float) for line in self.lines]

    def pressures(self, volume: Floats) -> Floats:
        """Pressures that would undo given changes of volume, nearly."""
        scale = 0.5 / self.shear_modulus + self.bulk_compliance
        return along_axes(self._pressure_inverses, volume) / scale
