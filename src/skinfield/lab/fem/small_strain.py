"""Contact at small strain of one round, rigid, frictionless body with the bonded layer.

Forces only push: a small dense problem of what the surface yields to each of them. That comes from
linear elasticity of a round piece of layer: Taylor-Hood elements, Q2 displacement, Q1 pressure.

Lengths are in thicknesses of the layer and stresses in Young's moduli; the layer fills 0 <= z <= 1.
Displacement u and pressure p make the energy per volume

    W = μ ε:ε + p div u - p²/(2λ)

stationary, with Lamé's λ infinite for ν = 1/2. The stiffness is factorised once, for any
forces on the surface.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import bmat, csc_matrix

from skinfield.elastic import Layer
from skinfield.errors import Floats, InputError, Ints, as_floats, check_positive
from skinfield.lab.fem.mesh import Trace, graded, scikit_fem, towards


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


Profile = Callable[[Floats], Floats]
REACH = 20.0  # thicknesses; bodies may be wider, contacts not
SAMPLES = 4001


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
    """

    layer: Layer
    force: float
    depth: float
    surface: Trace
    nodal_displacement: Floats
    nodal_force: Floats
    nodal_base_stress: Floats
    contact: NDArray[np.bool_]

    @property
    def contact_radius(self) -> float:
        """Outermost place of touch, m: midway between the last node that does and the next."""
        touching = np.flatnonzero(self.contact)
        if not len(touching):
            return 0.0
        nodes, last = self.surface.nodes, touching[-1]
        return float((nodes[last] + nodes[last + 1]) / 2)

    def pressure(self, radius: ArrayLike) -> Floats:
        """Contact pressure (N,) Pa at radii (N,) m; zero outside."""
        at, corners = as_floats("radius", radius), self.surface.nodes[::2]
        touched = self.contact[:-2:2] | self.contact[1::2] | self.contact[2::2]
        element = np.clip(np.searchsorted(corners, at, "right") - 1, 0, len(touched) - 1)
        pressure = self.surface.at(self.surface.density(self.nodal_force), at)
        return np.where(touched[element], pressure, 0.0)

    def indentation(self, radius: ArrayLike) -> Floats:
        """Depth (N,) m of the surface at radii (N,) m."""
        return -self.surface.at(self.nodal_displacement[:, 1], as_floats("radius", radius))

    def base_stress(self, radius: ArrayLike) -> Floats:
        """Normal stress (N,) Pa on the base at radii (N,) m."""
        return self.surface.at(self.nodal_base_stress, as_floats("radius", radius))


@dataclass(frozen=True)
class ScaledBody:
    """A body over the radius, both in thicknesses.

    Parameters
    ----------
    profile : callable
        Heights in m at radii in m.
    thickness : float, m
    """

    profile: Profile
    thickness: float

    def heights(self, radius: Floats) -> Floats:
        """Above the lowest point, infinite where the body is not."""
        found = np.asarray(self.profile(radius * self.thickness), dtype=float) / self.thickness
        if found.shape != radius.shape or np.isnan(found).any() or (found < 0).any():
            raise InputError(
                f"profile gives {found!r} for {radius.shape} radii, expected as many heights of "
                "0 or more: metres above the lowest point, infinite where the body is not"
            )
        return found

    def outermost(self) -> float:
        """Where the body may touch at most: it is there, and no higher than the layer."""
        radius = np.linspace(0.0, REACH, SAMPLES)
        below = np.flatnonzero(self.heights(radius) < 1.0)
        if not len(below):
            raise InputError(
                f"profile is nowhere below {self.thickness:g} m within a radius of "
                f"{REACH * self.thickness:g} m, expected heights above the body's lowest point, 0"
            )
        return float(radius[min(below[-1] + 1, SAMPLES - 1)])

    def edges(self) -> list[float]:
        """Radii within the body at which it ends, by bisection."""
        radius = np.linspace(0.0, REACH, SAMPLES)
        there = np.isfinite(self.heights(radius))
        rims = np.flatnonzero(there[1:] != there[:-1])
        inside, outside = (radius[np.where(there[rims] == way, rims, rims + 1)] for way in (1, 0))
        for _ in range(60):
            middle = (inside + outside) / 2
            within = np.isfinite(self.heights(middle))
            inside, outside = np.where(within, middle, inside), np.where(within, outside, middle)
        return [float(edge) for edge in inside]


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


def depth_under(force: float, flexibility: Floats, heights: Floats) -> float:
    """Depth at which the forces of `push_to_depth` sum to a force, which a thickness bears."""
    from scipy.optimize import brentq

    def more(depth: float) -> float:
        return float(push_to_depth(flexibility, heights, depth).sum()) - force

    if more(1.0) < 0.0:
        raise InputError(
            f"force is {force:.3g} times E h², which sinks the body through the layer, expected "
            "less: lower it, or raise the modulus"
        )
    return float(brentq(more, float(heights.min()), 1.0, xtol=1e-14))


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
    check_positive("finest", finest, "length of the smallest elements, in thicknesses")
    shape = ScaledBody(profile, layer.thickness)
    edges, reach = shape.edges(), shape.outermost()
    section = section_around(layer, edges, reach, 0.05, reach / 30)
    found = _contact_edges(_solve(layer, shape, reach, section, force, depth))
    reach = min(reach, max(found) + 0.5)
    section = section_around(layer, [*found, *edges], reach, finest, reach / 15)
    return _solve(layer, shape, reach, section, force, depth)


def section_around(
    layer: Layer, edges: Sequence[float], reach: float, finest: float, coarsest: float
) -> LayerSection:
    """Elements that shrink towards some radii and the surface, all in thicknesses."""
    near = towards(edges or [0.0], finest, 0.3, min(coarsest, COARSEST))

    def along(radius: Floats) -> Floats:
        return near(radius) + 0.15 * np.maximum(radius - reach - 1.0, 0.0)

    stops = sorted({0.0, reach + MARGIN, *(edge for edge in edges if edge > 0)})
    depths = graded([0.0, 1.0], towards([0.0], min(2 * finest, 0.1), 0.4, 0.2))
    return LayerSection.of(layer, graded(stops, along), 1.0 - depths[::-1])


def _contact_edges(found: AxisymmetricSolution) -> list[float]:
    """Radii between nodes that touch and nodes that do not, in thicknesses."""
    touching, nodes = found.contact, found.surface.nodes / found.layer.thickness
    change = np.flatnonzero(touching[1:] != touching[:-1])
    return [float((nodes[i] + nodes[i + 1]) / 2) for i in change]


def _solve(
    layer: Layer,
    shape: ScaledBody,
    reach: float,
    section: LayerSection,
    force: float | None,
    depth: float | None,
) -> AxisymmetricSolution:
    """Find the forces of the nodes on one mesh."""
    h, newton = layer.thickness, layer.young_modulus * layer.thickness**2
    nodes = section.trace.nodes
    heights = shape.heights(nodes)
    near = np.flatnonzero(np.isfinite(heights) & (nodes <= reach))
    near = near[near > 0]  # the axis has no area: a pressure near it gives its node no force
    flexibility = section.flexibility(near)
    sunk = depth / h if depth else depth_under((force or 0.0) / newton, flexibility, heights[near])
    forces = np.zeros(len(nodes))
    forces[near] = push_to_depth(flexibility, heights[near], sunk)
    return _solution(layer, section, forces, sunk)


def _solution(
    layer: Layer, section: LayerSection, forces: Floats, sunk: float
) -> AxisymmetricSolution:
    """The layer under given forces of its surface's nodes, in metres and newtons."""
    h, state = layer.thickness, section.respond(forces)
    reactions = (section.stiffness @ state)[section.base_z]
    contact = forces > 0
    contact[0] = contact[1]
    return AxisymmetricSolution(
        layer=layer,
        force=float(forces.sum()) * layer.young_modulus * h**2,
        depth=sunk * h,
        surface=Trace(section.trace.nodes * h),
        nodal_displacement=np.stack([state[section.top_r], state[section.top_z]], axis=-1) * h,
        nodal_force=forces * layer.young_modulus * h**2,
        nodal_base_stress=section.trace.density(reactions) * layer.young_modulus,
        contact=contact,
    )
