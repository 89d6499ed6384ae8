"""A box in touch with bodies on chosen nodes: a symmetric system without constraints."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skinfield.errors import Floats, InputError, Ints
from skinfield.fem.box import Box

ITERATIONS = 3000


@dataclass(frozen=True)
class Load:
    """What presses a body: a force in E h², or else a depth in h."""

    force: float | None
    depth: float | None


@dataclass(frozen=True, eq=False)
class HeldBox:
    """Nodes of the surface that ride on bodies; bodies with a force find their depth.

    Unknowns are displacements, pressures and the depths of bodies with a force; the displacement
    of a node that rides is that of its body and no unknown. The scalar operators of the box, under
    the same constraint, precondition MINRES.

    Attributes
    ----------
    box : Box
    nodes : (2, n) array of int
        Of the surface, along x and y, that touch.
    owner : (n,) array of int
        The body each of them touches.
    heights : (n,) array
        Of that body there.
    loads : sequence of Load
        Of the bodies.
    flexibility : (n, n) array
        `Box.surface_yielding` of the nodes.
    """

    box: Box
    nodes: Ints
    owner: Ints
    heights: Floats
    loads: Sequence[Load]
    flexibility: Floats

    def solve(self, start: Floats | None, tolerance: float) -> tuple[Floats, Floats, Floats]:
        """Unknowns, forces (n,) of the bodies on the nodes, and depths (bodies,).

        Raises
        ------
        InputError
            If MINRES does not end.
        """
        from scipy.sparse.linalg import LinearOperator, minres

        size = self._sizes[-1]
        given = [0.0 if load.depth is None else load.depth for load in self.loads]
        fixed = np.zeros((3, *self.box.shape))
        fixed[(2, *self.nodes, -1)] = self.heights - np.array(given)[self.owner]
        pull, change = self.box.forces(fixed, np.zeros(self.box.pressure_shape))
        right = -self._gather(pull, change)
        right[self._sizes[1] :] += [self.loads[b].force or 0.0 for b in self._moving]
        operator = LinearOperator((size, size), matvec=self._apply, dtype=float)
        inverse = LinearOperator((size, size), matvec=self._precondition, dtype=float)
        found, status = minres(
            operator, right, x0=start, M=inverse, rtol=tolerance, maxiter=ITERATIONS
        )
        if status != 0:
            raise InputError(
                f"{ITERATIONS} iterations of MINRES did not reach {tolerance:g}, expected a mesh "
                "whose elements are less stretched: use a larger cell or a smaller margin"
            )
        u, p, depth = self._spread(found)
        depths = np.array(given)
        depths[self._moving] = depth
        forces = self.box.forces(u + fixed, p)[0]
        return found, -forces[(2, *self.nodes, -1)], depths

    def fields(self, unknowns: Floats, depths: Floats) -> tuple[Floats, Floats]:
        """Displacements (3, nx, ny, nz) and pressures of a solution."""
        u, p, _ = self._spread(unknowns)
        u[(2, *self.nodes, -1)] = self.heights - depths[self.owner]
        return u, p

    def unknowns(self, u: Floats, p: Floats, depths: Floats) -> Floats:
        """Unknowns of given fields: where to start from."""
        return np.concatenate([u.ravel(), p.ravel(), depths[self._moving]])

    @cached_property
    def _moving(self) -> list[int]:
        return [b for b, load in enumerate(self.loads) if load.depth is None]

    @cached_property
    def _rides(self) -> Floats:
        """One where a node (n,) rides on a body that finds its depth."""
        return np.asarray(self.owner[:, None] == np.array(self._moving, dtype=int), float)

    @cached_property
    def _sizes(self) -> tuple[int, int, int]:
        u = 3 * int(np.prod(self.box.shape))
        p = u + int(np.prod(self.box.pressure_shape))
        return u, p, p + len(self._moving)

    @cached_property
    def _stiffness(self) -> Any:
        from scipy.linalg import cho_factor

        return cho_factor(self.flexibility)

    def _spread(self, unknowns: Floats) -> tuple[Floats, Floats, Floats]:
        """Fields of the unknowns: held nodes at rest, those that ride at the depth's change."""
        us, ps, _ = self._sizes
        u = np.zeros((3, *self.box.shape))
        raw = unknowns[:us].reshape(u.shape)
        for component in range(3):
            free = self.box.free(component)
            u[(component, *free)] = raw[(component, *free)]
        u[(2, *self.nodes, -1)] = -self._rides @ unknowns[ps:]
        return u, unknowns[us:ps].reshape(self.box.pressure_shape), unknowns[ps:]

    def _gather(self, forces: Floats, volume: Floats) -> Floats:
        """What the unknowns feel of nodal forces: the transpose of `_spread`."""
        out = np.zeros((3, *self.box.shape))
        for component in range(3):
            free = self.box.free(component)
            out[(component, *free)] = forces[(component, *free)]
        riding = out[(2, *self.nodes, -1)]
        out[(2, *self.nodes, -1)] = 0.0
        return np.concatenate([out.ravel(), volume.ravel(), -self._rides.T @ riding])

    def _apply(self, unknowns: Floats) -> Floats:
        u, p, _ = self._spread(unknowns)
        return self._gather(*self.box.forces(u, p))

    def _precondition(self, residual: Floats) -> Floats:
        """Solve with the scalar operators, whose nodes ride too."""
        from scipy.linalg import cho_solve

        us, ps, _ = self._sizes
        forces = residual[:us].reshape(3, *self.box.shape)
        u = np.stack([self.box.yielding(c, forces[c]) for c in range(3)])
        top = u[(2, *self.nodes, -1)]
        lag = cho_solve(self._stiffness, np.column_stack([top, self._rides]))
        pull, per_depth = lag[:, 0], lag[:, 1:]
        depth: Floats = np.zeros(0)
        if len(self._moving):
            rest = residual[ps:] - self._rides.T @ pull
            depth = np.asarray(np.linalg.solve(self._rides.T @ per_depth, rest), float)
        push = np.zeros(self.box.shape)
        push[(*self.nodes, -1)] = pull + per_depth @ depth
        u[2] -= self.box.yielding(2, push)
        u[(2, *self.nodes, -1)] = 0.0
        p = self.box.pressures(residual[us:ps].reshape(self.box.pressure_shape))
        return np.concatenate([u.ravel(), p.ravel(), depth])
