"""Contact at large strain: one round body on a neo-Hookean layer, by Newton's method, step by step.

Nodes slide along the body, and come and go between the steps.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bmat, coo_matrix, csc_matrix

from skinfield.elastic import Layer
from skinfield.errors import Floats, InputError, Ints, check_positive
from skinfield.lab.fem.elasticity import Elasticity, LinearSection, free_unknowns, law_of
from skinfield.lab.fem.mesh import Section, Trace
from skinfield.lab.fem.profiles import Profile, Shape, SmoothShape
from skinfield.lab.fem.small_strain import (
    AxisymmetricSolution,
    check_load,
    contact_edges,
    indent,
    mesh_around,
    push_to_depth,
    push_with_force,
)

STIFFNESS = 10.0  # moduli per thickness: weighs a gap against a pressure in the choice of touch


@dataclass(frozen=True, eq=False)
class Touch:
    """Where the surface is, seen from the body, at one state.

    A node is at radius R + u_r and below the body by g = H(R + u_r) - depth - u_z. The body pushes
    with forces -f dg/du: downwards and, on a flank, outwards; it is frictionless.

    Attributes
    ----------
    section : Section
    gap, slope, curvature : (nodes,) arrays
        g, H' and H'' at the nodes.
    """

    section: Section
    gap: Floats
    slope: Floats
    curvature: Floats

    @classmethod
    def of(cls, section: Section, shape: SmoothShape, state: Floats, depth: float) -> "Touch":
        """Look at the surface."""
        radius = section.trace.nodes + state[section.top_r]
        height, slope, curvature = shape.derivatives(radius)
        return cls(section, height - depth - state[section.top_z], slope, curvature)

    def chosen(self, forces: Floats) -> NDArray[np.bool_]:
        """Nodes (nodes,) that touch: pressed more than they are away, or too deep."""
        areas = self.section.trace.mass.sum(axis=1)
        touching = forces > STIFFNESS * self.gap * areas
        touching[0] = touching[1]  # the axis has no area, so its force tells nothing
        touching[-1] = False
        return np.asarray(touching)

    def pushes(self, forces: Floats) -> Floats:
        """Derivative of the body's potential by the unknowns, (unknowns,)."""
        total = np.zeros(self.section.unknowns)
        total[self.section.top_r] = -forces * self.slope
        total[self.section.top_z] = forces
        return total

    def directions(self, touching: Ints) -> csc_matrix:
        """Derivatives -dg/du of the nodes that touch, (unknowns, n)."""
        count = np.arange(len(touching))
        rows = np.concatenate([self.section.top_r[touching], self.section.top_z[touching]])
        values = np.concatenate([-self.slope[touching], np.ones(len(touching))])
        size = (self.section.unknowns, len(touching))
        return csc_matrix(coo_matrix((values, (rows, np.tile(count, 2))), shape=size))

    def bending(self, forces: Floats) -> csc_matrix:
        """What the body's curvature adds to the stiffness."""
        where, n = self.section.top_r, self.section.unknowns
        return csc_matrix(coo_matrix((-forces * self.curvature, (where, where)), shape=(n, n)))


def bordered(stiffness: Any, directions: Any, force: float | None) -> csc_matrix:
    """Equations of displacements, forces and, where the total force is given, depth."""
    n = directions.shape[1]
    if force is None:
        return csc_matrix(bmat([[stiffness, directions], [directions.T, None]]))
    ones = csc_matrix(np.ones((n, 1)))
    rows = [[stiffness, directions, None], [directions.T, None, ones], [None, ones.T, None]]
    return csc_matrix(bmat(rows))


ITERATIONS = 25
CLOSE = 1e-9  # of forces in E h² and of gaps in h


class NoBalance(Exception):
    """No equilibrium was found; the text says why."""


@dataclass(frozen=True, eq=False)
class Balance:
    """A layer in touch, in thicknesses and Young's moduli.

    Attributes
    ----------
    state : (unknowns,) array
    forces : (nodes,) array
        Vertical, of the body into the surface.
    depth : float
    """

    state: Floats
    forces: Floats
    depth: float

    @property
    def touching(self) -> NDArray[np.bool_]:
        """Nodes that touch, (nodes,)."""
        found = self.forces > 0
        found[0] = found[1]
        return found

    def towards(self, other: "Balance", share: float) -> "Balance":
        """A guess beyond `other` on the line through both."""
        state = other.state + share * (other.state - self.state)
        forces = np.maximum(other.forces + share * (other.forces - self.forces), 0.0)
        return Balance(state, forces, other.depth + share * (other.depth - self.depth))


@dataclass(frozen=True, eq=False)
class Newton:
    """What stays the same while the load grows.

    Parameters
    ----------
    law : Elasticity
    shape : SmoothShape
    """

    law: Elasticity
    shape: SmoothShape

    def solve(self, guess: Balance, force: float | None) -> Balance:
        """Equilibrium at a given force, or at the depth of the guess.

        Nodes come into touch and leave it between the steps (Hüeber and Wohlmuth, Comput. Methods
        Appl. Mech. Engrg. 194 (2005) 3147).

        Raises
        ------
        NoBalance
            If the steps do not end.
        """
        balance, touching = guess, np.flatnonzero(guess.touching)
        for _ in range(ITERATIONS):
            balance = self._step(balance, touching, force)
            touch = Touch.of(self.law.section, self.shape, balance.state, balance.depth)
            rest = self._unbalanced(balance, touch)
            chosen = np.flatnonzero(touch.chosen(balance.forces))
            if np.array_equal(chosen, touching) and rest < CLOSE:
                return balance
            if not len(chosen):
                raise NoBalance("the surface left the body")
            touching = chosen
        raise NoBalance(f"{ITERATIONS} steps of Newton's method were not enough")

    def _step(self, balance: Balance, touching: Ints, force: float | None) -> Balance:
        from scipy.sparse.linalg import splu

        mesh, free = self.law.section, free_unknowns(self.law.section)
        touch = Touch.of(mesh, self.shape, balance.state, balance.depth)
        held = np.zeros(len(balance.forces))
        held[touching] = balance.forces[touching]
        stiffness = (self.law.stiffness(balance.state) + touch.bending(held))[free][:, free]
        matrix = bordered(stiffness, touch.directions(touching)[free], force)
        right = np.concatenate([-self.law.forces(balance.state)[free], touch.gap[touching]])
        if force is not None:
            right = np.append(right, force)
        try:
            found = splu(matrix).solve(right)
        except RuntimeError:
            raise NoBalance("the stiffness became singular") from None
        step, forces = np.zeros(mesh.unknowns), np.zeros_like(held)
        step[free] = found[: len(free)]
        forces[touching] = found[len(free) : len(free) + len(touching)]
        share = self._longest(balance.state, step)
        sunk = float(found[-1]) if force else 0.0
        return Balance(
            balance.state + share * step,
            balance.forces + share * (forces - balance.forces),
            balance.depth + share * sunk,
        )

    def _longest(self, state: Floats, step: Floats) -> float:
        """Share of a step that turns no element inside out."""
        share = 1.0
        while not self.law.valid(state + share * step):
            share /= 2
            if share < 0.01:
                raise NoBalance("an element turned inside out")
        return share

    def _unbalanced(self, balance: Balance, touch: Touch) -> float:
        """Greatest force without a counterpart, or gap where there is touch."""
        rest = self.law.forces(balance.state) + touch.pushes(balance.forces)
        gaps = touch.gap[balance.touching]
        return float(max(np.abs(rest[free_unknowns(self.law.section)]).max(), np.abs(gaps).max()))


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
