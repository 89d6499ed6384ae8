"""Which nodes of a box touch which body: an active set that is exact for the mesh."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from skinfield.errors import Floats, InputError, Ints
from skinfield.fem.box import Box
from skinfield.fem.grading import graded, towards
from skinfield.fem.held_box import HeldBox, Load
from skinfield.fem.linear import moduli
from skinfield.fem.lines import Line
from skinfield.fem.solution_3d import BoxSolution, densities
from skinfield.fem.unilateral import push_to_depth, push_with_force
from skinfield.mechanics import Layer

MARGIN = 8.0  # thicknesses of layer around the bodies
CHANGES = 40  # of which nodes touch
LOW = 0.4  # thicknesses; a body below this height may touch, at first sight
Zones = tuple[list[tuple[float, float]], list[tuple[float, float]]]


class Body(Protocol):
    """A rigid body as `skinfield.simulate` has them."""

    @property
    def position(self) -> tuple[float, float]:
        """Of its axis, m."""
        ...

    @property
    def force(self) -> float | None:
        """Into the layer, N; or else `depth`."""
        ...

    @property
    def depth(self) -> float | None:
        """Of its lowest point below the surface, m."""
        ...

    def height(self, x: Floats, y: Floats) -> Floats:
        """Above its lowest point, m; infinite where it is not."""
        ...


@dataclass(frozen=True, eq=False)
class Settled:
    """An answer on one mesh, in thicknesses and Young's moduli.

    Attributes
    ----------
    owner : (nx, ny) array of int
        The body that a node of the surface touches, or -1.
    u : (3, nx, ny, nz) array
    p : (px, py, pz) array
    forces : (nx, ny) array
        On the nodes of the surface.
    depths : (bodies,) array
    """

    owner: Ints
    u: Floats
    p: Floats
    forces: Floats
    depths: Floats


@dataclass(frozen=True, eq=False)
class ContactSearch:
    """Bodies above one mesh.

    Attributes
    ----------
    layer : Layer
    box : Box
    heights : (bodies, nx, ny) array
        Above the bodies' lowest points, in thicknesses.
    loads : list of Load
    """

    layer: Layer
    box: Box
    heights: Floats
    loads: list[Load]

    @classmethod
    def on(
        cls, layer: Layer, bodies: Sequence[Body], zones: Zones, cell: float, mirror: bool
    ) -> "ContactSearch":
        """Mesh the layer finely where the zones are, and look at the bodies from its nodes."""
        h = layer.thickness
        lines = (_line(zones[0], cell, False), _line(zones[1], cell, mirror), _upwards(cell))
        x, y = np.meshgrid(lines[0].nodes * h, lines[1].nodes * h, indexing="ij")
        heights = np.stack([np.asarray(body.height(x, y)) / h for body in bodies])
        if mirror:
            other = np.stack([np.asarray(body.height(x, -y)) / h for body in bodies])
            if not np.allclose(heights, other, atol=1e-9):
                raise InputError(
                    "mirror is True, but the bodies are not symmetric about y = 0: place their "
                    "axes on it, or leave mirror out"
                )
        newton = layer.young_modulus * h**2 * (2 if mirror else 1)
        loads = [
            Load(None if body.force is None else body.force / newton,
                 None if body.depth is None else body.depth / h)
            for body in bodies
        ]  # fmt: skip
        return cls(layer, Box(lines, mirror, *moduli(layer)), heights, loads)

    def guess(self) -> Ints:
        """Which nodes touch (nx, ny), by the scalar operators and each body alone."""
        owner = np.full(self.heights.shape[1:], -1)
        for index, (heights, load) in enumerate(zip(self.heights, self.loads, strict=True)):
            near = np.array(np.nonzero(heights < LOW))
            if not near.size:
                raise InputError(
                    f"bodies[{index}] has no node of the mesh below it, expected a body that is "
                    "wider than a cell"
                )
            flexibility = self.box.surface_yielding(*near)
            if load.depth is None:
                pushes = push_with_force(flexibility, heights[*near], load.force or 0.0)[1]
            else:
                pushes = push_to_depth(flexibility, heights[*near], load.depth)
            owner[*near[:, pushes > 0]] = index
        return owner

    def like(self, coarse: "ContactSearch", found: Settled) -> Ints:
        """Which nodes touch (nx, ny), by the nearest node of a coarser mesh."""
        x, y = (
            np.abs(fine.nodes[:, None] - rough.nodes).argmin(axis=1)
            for fine, rough in zip(self.box.lines[:2], coarse.box.lines[:2], strict=True)
        )
        return np.asarray(found.owner[np.ix_(x, y)])

    def settle(self, owner: Ints) -> Settled:
        """Let nodes come and go until forces only push and no node is inside a body.

        Raises
        ------
        InputError
            If a body loses touch, sinks to the base, or nodes come and go for ever.
        """
        start, tolerance = None, 1e-6
        for _ in range(CHANGES):
            found, start = self._hold(owner, start, tolerance)
            gaps = self.heights - found.depths[:, None, None] - found.u[2, :, :, -1]
            inside = np.where(gaps.min(axis=0) < -1e-9, gaps.argmin(axis=0), -1)
            chosen = np.where(owner >= 0, np.where(found.forces > 0, owner, -1), inside)
            if np.array_equal(chosen, owner):
                if tolerance < 1e-8:
                    return found
                tolerance = 1e-9
            owner = chosen
        raise InputError(f"{CHANGES} changes of the contact did not settle: use smaller cells")

    def _hold(self, owner: Ints, start: Floats | None, tolerance: float) -> tuple[Settled, Floats]:
        """Answer for given nodes in touch, and where to start from next time."""
        nodes = np.array(np.nonzero(owner >= 0))
        mine = owner[*nodes]
        for body in range(len(self.loads)):
            if not (mine == body).any():
                raise InputError(f"bodies[{body}] touches no node: use smaller cells")
        heights, flexibility = self.heights[(mine, *nodes)], self.box.surface_yielding(*nodes)
        held = HeldBox(self.box, nodes, mine, heights, self.loads, flexibility)
        unknowns, pushes, depths = held.solve(start, tolerance)
        if depths.max() >= 1.0:
            raise InputError(
                f"bodies[{depths.argmax()}] sinks by {depths.max():.2f} of the layer's thickness, "
                "expected less than 1: lower its force, or raise the modulus"
            )
        u, p = held.fields(unknowns, depths)
        forces = np.zeros(owner.shape)
        forces[*nodes] = pushes
        return Settled(owner, u, p, forces, depths), held.unknowns(u, p, depths)

    def zones(self, found: Settled) -> Zones:
        """Where the bodies touch, along x and along y, and a little around."""
        around: Zones = ([], [])
        for body in range(len(self.loads)):
            touching = np.nonzero(found.owner == body)
            for axis in range(2):
                at = self.box.lines[axis].nodes[touching[axis]]
                around[axis].append((float(at.min()) - 0.15, float(at.max()) + 0.15))
        return around

    def solution(self, found: Settled) -> BoxSolution:
        """In metres and newtons."""
        h, modulus = self.layer.thickness, self.layer.young_modulus
        lines = self.box.lines[:2]
        per_body = np.array(
            [found.forces[found.owner == body].sum() for body in range(len(self.loads))]
        )
        base = self.box.forces(found.u, found.p)[0][2, :, :, 0]
        return BoxSolution(
            layer=self.layer,
            depths=found.depths * h,
            forces=per_body * modulus * h**2 * (2 if self.box.mirror else 1),
            lines=lines,
            mirror=self.box.mirror,
            surface=found.u[..., -1] * h,
            nodal_force=found.forces * modulus * h**2,
            nodal_base_stress=densities(lines, base) * modulus,
            contact=found.owner >= 0,
        )


def rough_zones(layer: Layer, bodies: Sequence[Body]) -> Zones:
    """Where the bodies are low, along x and along y through their axes."""
    h = layer.thickness
    reach = np.linspace(-10.0, 10.0, 2001)
    still = np.zeros_like(reach)
    around: Zones = ([], [])
    for index, body in enumerate(bodies):
        px, py = (value / h for value in body.position)
        for axis, (x, y) in enumerate(((reach, still), (still, reach))):
            low = np.asarray(body.height((px + x) * h, (py + y) * h)) < LOW * h
            if not low.any():
                raise InputError(
                    f"bodies[{index}] is nowhere below {LOW * h:g} m on the lines through its "
                    "position, expected its lowest point there or near"
                )
            centre = (px, py)[axis]
            around[axis].append(
                (centre + float(reach[low].min()), centre + float(reach[low].max()))
            )
    return around


def _line(zones: list[tuple[float, float]], cell: float, mirror: bool) -> Line:
    """Elements of one size in the zones, growing away from them; from 0 on if mirrored."""
    low, high = min(start for start, _ in zones), max(stop for _, stop in zones)

    def size(at: Floats) -> Floats:
        away = [np.maximum(np.maximum(start - at, at - stop), 0.0) for start, stop in zones]
        return np.minimum(cell + 0.35 * np.asarray(np.min(away, axis=0)), 1.0)

    first = 0.0 if mirror else low - MARGIN
    return Line.along(graded([first, high + MARGIN], size))


def _upwards(cell: float) -> Line:
    depths = graded([0.0, 1.0], towards([0.0], 0.6 * cell, 0.3, 0.25))
    return Line.along(1.0 - depths[::-1])
