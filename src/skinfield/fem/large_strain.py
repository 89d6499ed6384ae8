"""One round, rigid, frictionless body on a neo-Hookean layer: large strain, step by step."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from skinfield.errors import InputError, check_positive
from skinfield.fem.linear import LinearSection, law_of
from skinfield.fem.newton import Balance, Newton, NoBalance
from skinfield.fem.profiles import Profile
from skinfield.fem.section import Section
from skinfield.fem.shape import Shape, SmoothShape
from skinfield.fem.small_strain import check_load, contact_edges, indent, mesh_around
from skinfield.fem.solution import AxisymmetricSolution
from skinfield.fem.trace import Trace
from skinfield.fem.unilateral import push_to_depth, push_with_force
from skinfield.mechanics import Layer

FINEST = 0.04  # thicknesses; all over the contact, as its edge moves
SHORTEST = 1e-3  # of the load; the path ends where even such a step finds no balance


@dataclass(frozen=True, eq=False)
class LargeStrainPath:
    """Presses of growing load, up to the wanted one or to the last that was found.

    Attributes
    ----------
    solutions : tuple of AxisymmetricSolution
    wanted : float
        Force in N or depth in m that was asked for.
    stopped : str
        Why the path ended early; empty when it did not.
    """

    solutions: tuple[AxisymmetricSolution, ...]
    wanted: float
    stopped: str

    @property
    def complete(self) -> bool:
        """Whether the wanted load was reached."""
        return not self.stopped

    @property
    def last(self) -> AxisymmetricSolution:
        """The press of the greatest load; see `complete`."""
        return self.solutions[-1]


def indent_large(
    layer: Layer,
    profile: Profile,
    *,
    force: float | None = None,
    depth: float | None = None,
    steps: int = 10,
    finest: float = FINEST,
) -> LargeStrainPath:
    """Press a round body into a neo-Hookean layer, at large strain and without friction.

    The load grows in steps, shorter ones where Newton's method fails. Where it fails for good the
    path ends and says so: nothing that is not in equilibrium is returned.

    Parameters
    ----------
    layer : Layer
        Its modulus is that at small strain; incompressible at a Poisson's ratio of 0.5.
    profile : callable
        Heights (N,) m of the body above its lowest point at radii (N,) m, infinite where it is
        not. Round the edges of flat ends: what slides over a sharp one finds no slope there.
    force : float, N
    depth : float, m
        Of the body's lowest point. Exactly one of the two is given.
    steps : int
        Of equal load, to begin with.
    finest : float
        Length of the elements below the contact, in thicknesses.

    Returns
    -------
    LargeStrainPath

    Raises
    ------
    InputError
        If not exactly one load is given, not even the first step converges, or scikit-fem is
        missing.
    """
    check_load(layer, force, depth)
    check_positive("steps", steps, "of the load")
    check_positive("finest", finest, "length of the smallest elements, in thicknesses")
    shape = Shape(profile, layer.thickness)
    wanted, smooth = force or depth or 0.0, SmoothShape.of(shape)
    mesh = _mesh(layer, shape, force, depth, finest)
    newton = Newton(law_of(layer, mesh), smooth)
    unit = layer.young_modulus * layer.thickness**2 if force else layer.thickness
    found, stopped = [], ""
    try:
        for balance in _climb(newton, wanted / unit, steps, force is not None):
            touched = (mesh.trace.nodes + balance.state[mesh.top_r])[balance.touching]
            if not smooth.held(touched).all():
                raise NoBalance("the surface slid over the body's edge")
            found.append(_solution(layer, newton, balance))
    except NoBalance as failure:
        stopped = str(failure)
    if not found:
        raise InputError(
            f"load is {wanted!r}, of which not even the first of {steps} steps converged: "
            f"{stopped}; expected a lower load, more steps or rounder edges"
        )
    return LargeStrainPath(tuple(found), wanted, stopped)


def _climb(newton: Newton, wanted: float, steps: int, by_force: bool) -> Iterator[Balance]:
    """Balances at growing loads; raises NoBalance where it cannot go on."""
    share, step = 0.0, 1.0 / steps
    before, here = None, None
    while share < 1.0:
        step = min(step, 1.0 - share)
        load = (share + step) * wanted
        if here is None:
            guess = _linear_guess(newton, load, by_force)
        elif before is None:
            guess = here[1]
        else:
            guess = before[1].towards(here[1], step / (here[0] - before[0]))
        try:
            if by_force:
                balance = newton.solve(guess, load)
            else:
                balance = newton.solve(replace(guess, depth=load), None)
        except NoBalance:
            step /= 2
            if step < SHORTEST:
                raise
            continue
        share = 1.0 if share + step > 1.0 - 1e-9 else share + step
        before, here = here, (share, balance)
        step = min(1.5 * step, 1.0 / steps)
        yield balance


def _linear_guess(newton: Newton, load: float, by_force: bool) -> Balance:
    """Hooke's answer to the first load."""
    mesh = newton.law.section
    heights = newton.shape.heights(mesh.trace.nodes)
    near = np.flatnonzero(newton.shape.held(mesh.trace.nodes) & (heights < 0.5))
    near = near[near > 0]
    linear = LinearSection.prepare(newton.law)
    flexibility = linear.flexibility(near)
    if by_force:
        depth, pushes = push_with_force(flexibility, heights[near], load)
    else:
        depth, pushes = load, push_to_depth(flexibility, heights[near], load)
    forces = np.zeros(len(heights))
    forces[near] = pushes
    return Balance(linear.respond(forces), forces, depth)


def _mesh(
    layer: Layer, shape: Shape, force: float | None, depth: float | None, finest: float
) -> Section:
    """Elements of one size below the whole contact, smaller at the body's own edges."""
    edges = shape.edges()
    try:
        last = indent(layer, shape.profile, force=force, depth=depth, finest=finest)
    except InputError:  # Hooke's law sinks the body to the base
        last = indent(layer, shape.profile, depth=0.9 * layer.thickness, finest=finest)
    reach = max(contact_edges(last))
    inside = [edge for edge in edges if edge < 1.2 * reach]
    return mesh_around(inside, reach, finest / 4 if inside else finest, finest)


def _solution(layer: Layer, newton: Newton, balance: Balance) -> AxisymmetricSolution:
    """One step, in metres and newtons."""
    mesh, h, state = newton.law.section, layer.thickness, balance.state
    newtons = layer.young_modulus * h**2
    return AxisymmetricSolution(
        layer=layer,
        force=float(balance.forces.sum()) * newtons,
        depth=balance.depth * h,
        surface=Trace(mesh.trace.nodes * h),
        nodal_displacement=np.stack([state[mesh.top_r], state[mesh.top_z]], axis=-1) * h,
        nodal_force=balance.forces * newtons,
        nodal_base_stress=mesh.trace.density(newton.law.forces(state)[mesh.base_z])
        * layer.young_modulus,
        contact=balance.touching,
        large=True,
    )
