"""Contact at small strain of one round, rigid, frictionless body with the bonded layer.

Forces only push: a small dense problem of what the surface yields to each of them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic import Layer
from skinfield.errors import Floats, InputError, as_floats, check_positive
from skinfield.lab.fem.elasticity import LinearSection, law_of
from skinfield.lab.fem.mesh import Section, Trace, graded, mesh_section, towards
from skinfield.lab.fem.profiles import Profile, Shape


@dataclass(frozen=True, eq=False)
class AxisymmetricSolution:
    """A round body at rest on the layer; pressure and compression are positive.

    Attributes
    ----------
    layer : Layer
    force : float, N
        Into the layer.
    depth : float, m
        Of the body's lowest point below the undeformed surface.
    surface : Trace
        Radii (n,) m of the nodes of the surface and of the base before the press.
    nodal_displacement : (n, 2) array, m
        Of the surface, outwards and upwards.
    nodal_force : (n,) array, N
        Into the layer, consistent with the elements.
    nodal_base_stress : (n,) array, Pa
        From the reactions of the base.
    contact : (n,) array of bool
        Nodes that touch.
    large : bool
        Whether surface and pressure belong to the deformed places of the nodes.
    """

    layer: Layer
    force: float
    depth: float
    surface: Trace
    nodal_displacement: Floats
    nodal_force: Floats
    nodal_base_stress: Floats
    contact: NDArray[np.bool_]
    large: bool = False

    @property
    def deformed(self) -> Trace:
        """Radii of the surface's nodes during the press; those before it at small strain."""
        moved = self.nodal_displacement[:, 0] if self.large else 0.0
        return Trace(self.surface.nodes + moved)

    @property
    def contact_radius(self) -> float:
        """Outermost place of touch, m: midway between the last node that does and the next."""
        touching = np.flatnonzero(self.contact)
        if not len(touching):
            return 0.0
        nodes, last = self.deformed.nodes, touching[-1]
        return float((nodes[last] + nodes[last + 1]) / 2)

    def pressure(self, radius: ArrayLike) -> Floats:
        """Contact pressure (N,) Pa at radii (N,) m of the deformed surface; zero outside."""
        at, nodes = as_floats("radius", radius), self.deformed
        touched = self._span(at)
        return np.where(touched, nodes.at(self._nodal_pressure(), at), 0.0)

    def displacement(self, radius: ArrayLike) -> Floats:
        """Displacement (N, 2) m, outwards and upwards, of points first at radii (N,) m."""
        at = as_floats("radius", radius)
        parts = [self.surface.at(column, at) for column in self.nodal_displacement.T]
        return np.stack(parts, axis=-1)

    def indentation(self, radius: ArrayLike) -> Floats:
        """Depth (N,) m of the deformed surface at the radii (N,) m."""
        return -self.deformed.at(self.nodal_displacement[:, 1], as_floats("radius", radius))

    def base_stress(self, radius: ArrayLike) -> Floats:
        """Normal stress (N,) Pa on the base at radii (N,) m."""
        return self.surface.at(self.nodal_base_stress, as_floats("radius", radius))

    def pad_stress(self, distance: ArrayLike, pad_diameter: float) -> Floats:
        """Mean normal stress (N,) Pa below round pads at distances (N,) m from the axis."""
        check_positive("pad_diameter", pad_diameter, "of the electrode, in metres")
        return disc_mean(self.base_stress, as_floats("distance", distance), pad_diameter)

    def _nodal_pressure(self) -> Floats:
        return self.deformed.density(self.nodal_force)

    def _span(self, at: Floats) -> NDArray[np.bool_]:
        """Whether a radius lies in an element that touches at one end or in the middle."""
        touched = self.contact[:-2:2] | self.contact[1::2] | self.contact[2::2]
        corners = self.deformed.nodes[::2]
        element = np.clip(np.searchsorted(corners, at, "right") - 1, 0, len(touched) - 1)
        return touched[element]


def disc_mean(function: Callable[[Floats], Floats], distance: Floats, diameter: float) -> Floats:
    """Mean of a function of the radius over discs whose centres are at distances (N,) m."""
    points, weights = np.polynomial.legendre.leggauss(24)
    radius = diameter / 4 * (points + 1)
    angle = (np.arange(48) + 0.5) * np.pi / 48
    weight = (weights * radius)[:, None] * np.ones(48)
    along = distance[:, None, None] + radius[:, None] * np.cos(angle)
    across = radius[:, None] * np.sin(angle)
    values = function(np.hypot(along, across))
    return np.asarray((values * weight).sum(axis=(1, 2)) / weight.sum())


def push_to_depth(flexibility: Floats, heights: Floats, depth: float) -> Floats:
    """Forces (n,) >= 0 that keep every node below a body whose lowest point is at a depth.

    With C the flexibility they minimise f.C.f/2 - (depth - heights).f, which is a least-squares
    problem in the Cholesky factor of C, and which Lawson and Hanson's method ends exactly.

    Parameters
    ----------
    flexibility : (n, n) array
        Displacement into the layer per force.
    heights : (n,) array
        Of the body above its lowest point.
    depth : float
    """
    from scipy.linalg import cholesky, solve_triangular
    from scipy.optimize import nnls

    factor = cholesky((flexibility + flexibility.T) / 2, lower=True)
    wanted = solve_triangular(factor, depth - heights, lower=True)
    forces, _ = nnls(factor.T, wanted, maxiter=30 * len(heights))
    return np.asarray(forces)


def push_with_force(flexibility: Floats, heights: Floats, force: float) -> tuple[float, Floats]:
    """Depth of the body, and the forces (n,) whose sum is given.

    The sum grows with the depth, at a rate that the nodes in touch fix: Newton's method.
    """
    depth = float(heights.min()) + force * float(flexibility.diagonal().mean())
    for _ in range(60):
        forces = push_to_depth(flexibility, heights, depth)
        touching = forces > 0
        if touching.any():
            inverse = np.linalg.inv(flexibility[np.ix_(touching, touching)])
            step = (force - forces.sum()) / inverse.sum()
        else:
            step = depth - heights.min()
        depth += float(step)
        if abs(step) <= 1e-12 * max(abs(depth), 1e-12):
            return depth, forces
    raise InputError(f"force is {force!r} in units of E h², expected one that a contact can carry")


MARGIN = 12.0  # thicknesses of layer around the contact; what is felt falls as exp(-0.8 r/h)
FINEST = 0.01  # thicknesses; the elements at the edge of the contact
COARSEST = 0.05


def indent(
    layer: Layer,
    profile: Profile,
    *,
    force: float | None = None,
    depth: float | None = None,
    finest: float = FINEST,
) -> AxisymmetricSolution:
    """Press a round body into the layer, linear elastic and without friction.

    Mixed elements (Q2 displacement, Q1 pressure) take every Poisson's ratio up to 0.5. A first
    mesh finds the edge of the contact, a second one is graded towards it. Contact is exact for the
    mesh: forces of the nodes are zero or more, and nodes are on or below the body.

    Parameters
    ----------
    layer : Layer
        Bonded at its base and held far away.
    profile : callable
        Heights (N,) m of the body above its lowest point at radii (N,) m, infinite where it is
        not.
    force : float, N
    depth : float, m
        Of the body's lowest point. Exactly one of the two is given.
    finest : float
        Length of the elements at the contact's edge, in thicknesses.

    Returns
    -------
    AxisymmetricSolution

    Raises
    ------
    InputError
        If not exactly one load is given, the body reaches the base, or scikit-fem is missing.
    """
    check_load(layer, force, depth)
    check_positive("finest", finest, "length of the smallest elements, in thicknesses")
    shape = Shape(profile, layer.thickness)
    edges, reach = shape.edges(), shape.outermost()
    mesh = mesh_around(edges, reach, 0.05, reach / 30)
    found = contact_edges(_solve(layer, shape, reach, mesh, force, depth))
    reach = min(reach, max(found) + 0.5)
    mesh = mesh_around([*found, *edges], reach, finest, reach / 15)
    return _solve(layer, shape, reach, mesh, force, depth)


def apply_pressure(
    layer: Layer, pressure: Profile, radius: float, *, finest: float = FINEST
) -> AxisymmetricSolution:
    """Load the layer with a given pressure inside a circle.

    Parameters
    ----------
    layer : Layer
    pressure : callable
        Pressures (N,) Pa at radii (N,) m.
    radius : float, m
        Of the circle.
    finest : float
        Length of the elements at its edge, in thicknesses.

    Returns
    -------
    AxisymmetricSolution
        Its depth is that of the surface at the axis.
    """
    check_positive("radius", radius, "of the loaded circle, in metres")
    h = layer.thickness
    mesh = mesh_around([radius / h], radius / h, finest, COARSEST)
    places = mesh.trace.gauss_radii
    loaded = np.where(places < radius / h, pressure(places.ravel() * h).reshape(places.shape), 0.0)
    linear = LinearSection.prepare(law_of(layer, mesh))
    found = linear_solution(layer, linear, mesh.trace.loads(loaded / layer.young_modulus), 0.0)
    return replace(found, depth=float(found.indentation(np.zeros(1))[0]))


def mesh_around(edges: Sequence[float], reach: float, finest: float, coarsest: float) -> Section:
    """Elements that shrink towards some radii and the surface, all in thicknesses."""
    near = towards(edges or [0.0], finest, 0.3, min(coarsest, COARSEST))

    def along(radius: Floats) -> Floats:
        return near(radius) + 0.15 * np.maximum(radius - reach - 1.0, 0.0)

    stops = sorted({0.0, reach + MARGIN, *(edge for edge in edges if edge > 0)})
    depths = graded([0.0, 1.0], towards([0.0], min(2 * finest, 0.1), 0.4, 0.2))
    return mesh_section(graded(stops, along), 1.0 - depths[::-1])


def contact_edges(found: AxisymmetricSolution) -> list[float]:
    """Radii between nodes that touch and nodes that do not, in thicknesses."""
    touching, nodes = found.contact, found.surface.nodes / found.layer.thickness
    change = np.flatnonzero(touching[1:] != touching[:-1])
    return [float((nodes[i] + nodes[i + 1]) / 2) for i in change]


def check_load(layer: Layer, force: float | None, depth: float | None) -> None:
    """Raise InputError unless exactly one is given and can be."""
    if (force is None) == (depth is None):
        raise InputError(f"force is {force!r} and depth is {depth!r}, expected exactly one of them")
    if force is not None:
        check_positive("force", force, "into the layer, in newtons")
    if depth is not None:
        check_positive("depth", depth, "of the lowest point below the surface, in metres")
        if depth >= layer.thickness:
            raise InputError(
                f"depth is {depth!r} m, expected less than the layer's {layer.thickness!r} m"
            )


def _solve(
    layer: Layer,
    shape: Shape,
    reach: float,
    mesh: Section,
    force: float | None,
    depth: float | None,
) -> AxisymmetricSolution:
    """Find the forces of the nodes on one mesh."""
    h, newton = layer.thickness, layer.young_modulus * layer.thickness**2
    nodes = mesh.trace.nodes
    heights = shape.heights(nodes)
    near = np.flatnonzero(np.isfinite(heights) & (nodes <= reach))
    near = near[near > 0]  # the axis has no area: a pressure near it gives its node no force
    linear = LinearSection.prepare(law_of(layer, mesh))
    flexibility = linear.flexibility(near)
    if depth is None:
        sunk, pushes = push_with_force(flexibility, heights[near], (force or 0.0) / newton)
    else:
        sunk, pushes = depth / h, push_to_depth(flexibility, heights[near], depth / h)
    if sunk >= 1.0:
        raise InputError(
            f"force is {force!r} N, which sinks the body by {sunk:.2f} of the layer's thickness, "
            "expected less than 1: lower it, or raise the modulus"
        )
    forces = np.zeros(len(nodes))
    forces[near] = pushes
    return linear_solution(layer, linear, forces, sunk)


def linear_solution(
    layer: Layer, linear: LinearSection, forces: Floats, sunk: float
) -> AxisymmetricSolution:
    """The layer under given forces of its surface's nodes, in metres and newtons."""
    mesh, h = linear.section, layer.thickness
    state = linear.respond(forces)
    reactions = (linear.stiffness @ state)[mesh.base_z]
    contact = forces > 0
    contact[0] = contact[1]
    return AxisymmetricSolution(
        layer=layer,
        force=float(forces.sum()) * layer.young_modulus * h**2,
        depth=sunk * h,
        surface=Trace(mesh.trace.nodes * h),
        nodal_displacement=np.stack([state[mesh.top_r], state[mesh.top_z]], axis=-1) * h,
        nodal_force=forces * layer.young_modulus * h**2,
        nodal_base_stress=mesh.trace.density(reactions) * layer.young_modulus,
        contact=contact,
    )
