"""One round, rigid, frictionless body on the bonded layer, at small strain."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from skinfield.errors import Floats, InputError, check_positive
from skinfield.fem.grading import graded, towards
from skinfield.fem.linear import LinearSection, law_of
from skinfield.fem.profiles import Profile
from skinfield.fem.section import Section, mesh_section
from skinfield.fem.shape import Shape
from skinfield.fem.solution import AxisymmetricSolution
from skinfield.fem.trace import Trace
from skinfield.fem.unilateral import push_to_depth, push_with_force
from skinfield.mechanics import Layer

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
