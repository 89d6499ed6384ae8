r"""Contact of rigid bodies with the skin: pressure that pushes, gaps that stay open, and friction.

Normal contact, with u = C p the indentation, g the height of the bodies and d the approach of each:

.. math:: u + g - d \ge 0, \qquad p \ge 0, \qquad p\,(u + g - d) = 0,

and for each body either d is prescribed or the integral of p is. Conjugate gradients with the
contact as an active set (Polonsky and Keer, Wear 231, 1999), the mean gap held apart where a force
is prescribed.

Friction, in one step of a load from a state in which the surface is displaced along the plane by u0
(Goodman's way). With q the tangential traction after it, A q + c the displacement, c that by the
pressure, and P the disc of radius mu p on each cell,

.. math:: q = P\left[q + \tau (d - A q - c + u_0)\right], \qquad \int q = T

for the translation d of each body in this step and its tangential force T; without a limit it is
A q + c - u0 = d where there is touch (Cattaneo 1938, Mindlin 1949).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, SkinfieldError

EDGE = 0.1  # cells that a sharp edge must stand out for a flat punch to be exact; measured
RIM = 0.1  # cells by which touch is found too wide where a body curves away; measured
TOLERANCE = 1e-6
MOST_ITERATIONS = 2000


@dataclass(frozen=True, eq=False)
class ContactProblem:
    """Rigid bodies over a set of cells of any arrangement.

    Attributes
    ----------
    indent : function
        From pressure on the cells, Pa, to the indentation at their centres, m; same shape.
    own : array of that shape, m/Pa
        Indentation of a cell by its own pressure, part of `indent`.
    heights : array, m
        Of the body over each cell above the body's lowest point; infinite under none.
    bodies : int array
        Which body a cell belongs to.
    area : array, m²
        Of each cell.
    forces, depths : (bodies,) array, N and m
        One of the two for each body; NaN stands for the one that follows.
    """

    indent: Callable[[Floats], Floats]
    own: Floats
    heights: Floats
    bodies: NDArray[np.int64]
    area: Floats
    forces: Floats
    depths: Floats

    def __post_init__(self) -> None:
        given = np.isfinite(self.forces).astype(int) + np.isfinite(self.depths)
        if (given != 1).any():
            body = int(np.argmax(given != 1))
            raise InputError(
                f"forces[{body}] is {self.forces[body]} and depths[{body}] is "
                f"{self.depths[body]}, expected one number and one NaN: the other follows from it"
            )


@dataclass(frozen=True, eq=False)
class ContactSolution:
    """Solution of a `ContactProblem`.

    Attributes
    ----------
    pressure : array, Pa
        Force over the area of the whole cell, also where the body covers a part of it.
    gap : array, m
        Between body and surface; infinite under none.
    approach : (bodies,) array, m
        Depth of each body's lowest point below the undeformed surface.
    residual : float
        The largest of these: gap where there is pressure, and overlap where there is none, each
        over the largest indentation under that body; work of the pressure through the gap over
        its work through the indentation; and error of a given force over that force.
    iterations : int
    """

    pressure: Floats
    gap: Floats
    approach: Floats
    residual: float
    iterations: int


def edge_softness(coverage: Floats) -> Floats:
    """Further indentation of a cell by its own pressure, over `own`, at the edge of a body.

    Parameters
    ----------
    coverage : array
        Fraction of each cell below the body, its sharp edges moved out by `EDGE` cells.

    Returns
    -------
    array
        1/coverage - 1: a load on a part of a cell acts on a smaller area. A piecewise constant
        pressure misses the singularity of a sharp edge as if the edge were `EDGE` cells further in,
        hence the shift. Measured with flat round punches on the half-space; the edge's singularity
        is the same on a layer.
    """
    return 1.0 / np.maximum(coverage, 1e-6) - 1.0


def rim(inside: NDArray[np.bool_]) -> Floats:
    """Size of the gradient (rows, columns) per cell of a picture of 1 and 0, which is 0 around.

    Its sum is the length of the border in cells.
    """
    around = np.pad(inside.astype(np.float64), 1)
    across = (around[1:-1, 2:] - around[1:-1, :-2]) / 2
    along = (around[2:, 1:-1] - around[:-2, 1:-1]) / 2
    return np.asarray(np.hypot(across, along))


def solve_contact(
    problem: ContactProblem,
    pressure: Floats,
    softness: Floats,
    tolerance: float = TOLERANCE,
    most_iterations: int = MOST_ITERATIONS,
) -> ContactSolution:
    """Pressure under rigid bodies, each with a given force or at a given depth.

    Parameters
    ----------
    problem : ContactProblem
    pressure : array, Pa
        A start; zero will do.
    softness : array
        From `edge_softness`; 0 where no sharp edge is near.
    tolerance : float
        On `ContactSolution.residual`.
    most_iterations : int

    Returns
    -------
    Contact
        A body at a given depth that the surface stays clear of has no pressure at all.

    Raises
    ------
    SkinfieldError
        If it does not converge.
    """
    search = _Search(problem, softness)
    pressure = search.started(pressure)
    direction, previous, conjugate = np.zeros_like(pressure), 1.0, 0.0
    for iteration in range(most_iterations):
        gap, approach, error = search.state(pressure)
        if error <= tolerance:
            return ContactSolution(pressure, search.open(gap), approach, error, iteration)
        touching = pressure > 0
        downhill = search.trust * gap
        work = float(np.sum((problem.area * gap * downhill)[touching]))
        direction = np.where(touching, downhill + conjugate * work / previous * direction, 0.0)
        previous = work or 1.0
        step = search.step(gap, direction, touching)
        pressure = np.maximum(pressure - step * direction, 0.0)
        overlap = search.reachable & (pressure == 0.0) & (gap < 0.0)
        conjugate = 0.0 if overlap.any() else 1.0
        pressure[overlap] -= (step or 1.0 / problem.own[overlap]) * downhill[overlap]
        pressure = search.balanced(pressure, gap)
    raise SkinfieldError(
        f"contact reached a residual of {error:.1e} in {most_iterations} iterations, "
        f"expected {tolerance:.1e}: use finer cells or a lower load"
    )


class _Search:
    """What one problem's iterations share: the operator with its edges, and sums by body."""

    def __init__(self, problem: ContactProblem, softness: Floats) -> None:
        self.problem = problem
        self.reachable = np.isfinite(problem.heights)
        self.level = np.where(self.reachable, problem.heights, 0.0)
        self.softness = np.where(self.reachable, problem.own * softness, 0.0)
        # Soft cells take small steps, which is a preconditioner by the diagonal.
        self.trust = 1.0 / (1.0 + np.where(self.reachable, softness, 0.0))
        self.count = len(problem.forces)
        self.members = [np.flatnonzero(self.reachable & (problem.bodies == body))
                        for body in range(self.count)]  # fmt: skip
        self.free = np.isfinite(problem.forces)  # bodies whose depth follows

    def indent(self, pressure: Floats) -> Floats:
        return self.problem.indent(pressure) + self.softness * pressure

    def sums(self, values: Floats) -> Floats:
        return np.array([values.ravel()[cells].sum() for cells in self.members])

    def means(self, values: Floats, touching: NDArray[np.bool_]) -> Floats:
        """Over the touching cells of each body; 0 where none touches.

        Weighted by area and trust, so that a step along trust times the rest sums to zero.
        """
        weight = np.where(touching, self.problem.area * self.trust, 0.0)
        return self.sums(weight * values) / np.maximum(self.sums(weight), 1e-300)

    def open(self, gap: Floats) -> Floats:
        return np.where(self.reachable, gap, np.inf)

    def started(self, pressure: Floats) -> Floats:
        """A start with the given forces, or with the push that suits the given depths."""
        problem = self.problem
        pressure = np.where(self.reachable, np.maximum(pressure, 0.0), 0.0)
        for body in np.flatnonzero(~self.free):
            cells = self.members[body]
            if pressure.ravel()[cells].any():
                continue
            shape = np.zeros(pressure.shape)
            shape.ravel()[cells] = np.maximum(problem.depths[body] - self.level.ravel()[cells], 0)
            push = float(np.sum(problem.area * shape * self.indent(shape)))
            pressure += shape * (np.sum(problem.area * shape**2) / push if push > 0 else 0.0)
        return self.balanced(pressure, self.level)

    def balanced(self, pressure: Floats, gap: Floats) -> Floats:
        """Scale to the given forces; a body that has lost touch touches where it is nearest."""
        factor = np.ones(self.count)
        sums = self.sums(self.problem.area * pressure)
        for body in np.flatnonzero(self.free & ~(sums > 0)):
            cells = self.members[body]
            nearest = cells[gap.ravel()[cells].argmin()]
            pressure.ravel()[nearest] = 1.0
            sums[body] = self.problem.area.ravel()[nearest]
        factor[self.free] = self.problem.forces[self.free] / sums[self.free]
        return pressure * factor[self.problem.bodies]

    def state(self, pressure: Floats) -> tuple[Floats, Floats, float]:
        """Gap (0 where no body is), approach and residual of a pressure."""
        problem, touching = self.problem, pressure > 0
        sunk = self.indent(pressure)
        gap = sunk + self.level
        approach = np.where(self.free, self.means(gap, touching), problem.depths)
        gap = np.where(self.reachable, gap - approach[problem.bodies], 0.0)
        worst = [0.0]
        flat, wrong = touching.ravel(), np.where(touching, np.abs(gap), np.maximum(-gap, 0.0))
        for body, cells in enumerate(self.members):
            loaded = cells[flat[cells]]
            deepest = np.abs(sunk.ravel()[loaded]).max(initial=1e-300)
            if not len(loaded):
                deepest = problem.depths[body]
            worst.append(float(wrong.ravel()[cells].max(initial=0.0)) / deepest)
        load = problem.area * pressure
        worst.append(float(np.sum(load * np.abs(gap)) / max(np.sum(load * np.abs(sunk)), 1e-300)))
        forces = problem.forces[self.free]
        worst.extend(np.abs(self.sums(load)[self.free] / forces - 1.0))
        return gap, approach, max(worst)

    def step(self, gap: Floats, direction: Floats, touching: NDArray[np.bool_]) -> float:
        """Length of the step that makes the work least along a direction; 0 for no direction."""
        curved = self.indent(direction)
        means = np.where(self.free, self.means(curved, touching), 0.0)
        curved -= means[self.problem.bodies]
        area = self.problem.area[touching]
        curvature = float(np.sum(area * curved[touching] * direction[touching]))
        down = float(np.sum(area * gap[touching] * direction[touching]))
        return down / curvature if curvature > 0 and down > 0 else 0.0


SHEAR_TOLERANCE = 1e-5
MOST_SHEAR_ITERATIONS = 5000


@dataclass(frozen=True, eq=False)
class ShearProblem:
    """Tangential forces on bodies that touch, after one step of a load.

    Attributes
    ----------
    slide : function
        From tangential traction (2, N) Pa on cells to tangential displacement (2, N) m; symmetric
        and positive for cells of one size.
    touching : (N,) bool array
        Cells that can carry traction.
    bodies : (N,) int array
    area : (N,) array, m²
        Of each cell.
    forces : (bodies, 2) array, N
        On the skin.
    ahead : (2, N) array, m, optional
        By how far the surface is ahead of where it was, without tangential traction: c - u0 in the
        terms of this module. Default nowhere.
    start : (2, N) array, Pa, optional
        Tractions to start from.
    """

    slide: Callable[[Floats], Floats]
    touching: NDArray[np.bool_]
    bodies: NDArray[np.int64]
    area: Floats
    forces: Floats
    ahead: Floats | None = None
    start: Floats | None = None

    def __post_init__(self) -> None:
        loose = [
            body
            for body, force in enumerate(self.forces)
            if force.any() and not (self.touching & (self.bodies == body)).any()
        ]
        if loose:
            raise InputError(
                f"forces[{loose[0]}] is {self.forces[loose[0]]} N, expected zero: the body does "
                "not touch the skin, press it deeper"
            )

    def moved(self, traction: Floats) -> Floats:
        """Displacement (2, N) m of the surface in this step under a traction (2, N) Pa."""
        slid = self.slide(traction)
        return slid if self.ahead is None else slid + self.ahead

    def first(self) -> Floats:
        """Traction (2, N) to start from, with the given forces: each force spread evenly."""
        start = np.zeros((2, len(self.area))) if self.start is None else self.start
        start = np.where(self.touching, start, 0.0)
        area = self.sums(np.ones_like(start))
        missing = (self.forces - self.sums(start)) / np.maximum(area, 1e-300)
        return np.where(self.touching, start + missing.T[:, self.bodies], 0.0)

    def sums(self, values: Floats) -> Floats:
        """Sum over the touching cells of each body, (bodies, 2), of values (2, N) times area."""
        weighted = np.where(self.touching, values * self.area, 0.0)
        count = len(self.forces)
        return np.stack(
            [np.bincount(self.bodies, weights=row, minlength=count) for row in weighted], axis=1
        )

    def means(self, values: Floats) -> Floats:
        """Over the touching cells of each body, (bodies, 2); 0 where none touches."""
        return self.sums(values) / np.maximum(self.sums(np.ones((2, len(self.area)))), 1e-300)


@dataclass(frozen=True, eq=False)
class Shear:
    """Solution of a `ShearProblem`.

    Attributes
    ----------
    traction : (2, N) array, Pa
        On the skin.
    translation : (bodies, 2) array, m
        Of each body in this step; of one that slides, the mean of the skin's below it.
    slipping : (N,) bool array
        Cells at Coulomb's limit.
    residual : float
        The largest difference, over the largest movement, between what each cell moves and what it
        should: as its body where it sticks; where it slips, behind it and against the traction.
    iterations : int
    """

    traction: Floats
    translation: Floats
    slipping: NDArray[np.bool_]
    residual: float
    iterations: int


def solve_stick(
    problem: ShearProblem,
    tolerance: float = SHEAR_TOLERANCE,
    most_iterations: int = MOST_SHEAR_ITERATIONS,
) -> Shear:
    """Traction if nothing slips: conjugate gradients with each body's force held.

    The traction is infinite at the contact's border, so near it some slip is inevitable in nature:
    `solve_slip` has that.

    Raises
    ------
    SkinfieldError
        If it does not converge.
    """
    traction = problem.first()
    moved, fresh = problem.moved(traction), True
    direction, previous = np.zeros_like(traction), np.inf
    for iteration in range(most_iterations):
        translation, apart, error = _left(problem, moved)
        if error <= tolerance and not fresh:  # certify with what was not summed up
            moved, fresh = problem.moved(traction), True
            translation, apart, error = _left(problem, moved)
        if problem.forces.any() and not translation.any():
            raise _stiff()
        if error <= tolerance:
            none = np.zeros(len(problem.touching), dtype=bool)
            return Shear(traction, translation, none, error, iteration)
        work = float(np.sum(problem.area * apart**2))
        direction = apart + work / previous * direction
        previous = work
        bent = problem.slide(direction)
        # Directions sum to zero over each body, so that the means of `bent` do no work.
        curvature = float(np.sum(np.where(problem.touching, problem.area * bent * direction, 0.0)))
        if curvature <= 0.0:
            raise _stiff()
        traction += work / curvature * direction
        moved, fresh = moved + work / curvature * bent, False
    raise _unsettled(error, most_iterations, tolerance)


def solve_slip(
    problem: ShearProblem,
    limit: Floats,
    tolerance: float = 10 * SHEAR_TOLERANCE,
    most_iterations: int = MOST_SHEAR_ITERATIONS,
) -> Shear:
    """Traction that nowhere exceeds Coulomb's limit, by accelerated projected gradients.

    Parameters
    ----------
    problem : ShearProblem
    limit : (N,) array, Pa
        Friction coefficient times pressure.
    tolerance : float
        On `Shear.residual`.
    most_iterations : int

    Raises
    ------
    InputError
        If a body would slide altogether.
    SkinfieldError
        If it does not converge.
    """
    limit = np.where(problem.touching, limit, 0.0)
    sliding = _sliding(problem, limit)
    if sliding.any():
        return _slide(problem, limit, sliding, tolerance, most_iterations)
    rate = 1.0 / (1.05 * _largest(problem))
    traction = problem.first()
    ahead, momentum = traction.copy(), 1.0
    translation = np.zeros((len(problem.forces), 2))
    for iteration in range(most_iterations):
        moved = problem.moved(ahead)
        wanted = ahead - rate * moved
        translation = _balanced(problem, wanted, limit, translation, rate)
        new = _within(wanted + rate * translation.T[:, problem.bodies], limit)
        error = _relative(np.where(problem.touching, (new - ahead) / rate, 0.0), translation, moved)
        if error <= tolerance:
            size = np.hypot(*new)
            slipping = problem.touching & (size >= limit * (1 - 1e-9))
            return Shear(new, translation, slipping, error, iteration)
        if float(np.sum(problem.area * (ahead - new) * (new - traction))) > 0:
            momentum = 1.0  # the last steps went too far
        next_momentum = (1 + np.sqrt(1 + 4 * momentum**2)) / 2
        ahead = new + (momentum - 1) / next_momentum * (new - traction)
        traction, momentum = new, next_momentum
    raise _unsettled(error, most_iterations, tolerance)


def _left(problem: ShearProblem, moved: Floats) -> tuple[Floats, Floats, float]:
    """Translation of each body, what its cells lack of it, and that relative to it."""
    translation = problem.means(moved)
    apart = np.where(problem.touching, translation.T[:, problem.bodies] - moved, 0.0)
    return translation, apart, _relative(apart, translation, np.where(problem.touching, moved, 0.0))


def _relative(apart: Floats, translation: Floats, moved: Floats) -> float:
    most = max(float(np.hypot(*translation.T).max()), float(np.hypot(*moved).max()), 1e-300)
    return float(np.hypot(*apart).max()) / most


def _within(traction: Floats, limit: Floats) -> Floats:
    """The nearest traction (2, N) within the limit."""
    size = np.maximum(np.hypot(*traction), 1e-300)
    return np.asarray(traction * np.minimum(1.0, limit / size))


def _balanced(
    problem: ShearProblem, wanted: Floats, limit: Floats, translation: Floats, rate: float
) -> Floats:
    """Translations for which the limited traction has the given forces, by Newton's steps.

    The force is the gradient of a convex function of the translation, with the derivative 1 times
    area where a cell sticks and limit/size times area across the traction where it slips.
    """
    most = np.abs(problem.forces).max() + float(np.sum(problem.area * limit))
    for _ in range(60):
        raw = wanted + rate * translation.T[:, problem.bodies]
        size = np.maximum(np.hypot(*raw), 1e-300)
        short = np.minimum(1.0, limit / size)
        missing = problem.forces - problem.sums(raw * short)
        if np.abs(missing).max() <= 1e-10 * most:
            break
        x, y = raw / size
        slips = short < 1.0
        slope = np.empty((len(missing), 2, 2))
        slope[:, 0] = problem.sums(
            np.stack([np.where(slips, short * y * y, 1.0), np.where(slips, -short * x * y, 0.0)])
        )
        slope[:, 1] = slope[:, 0, ::-1]
        slope[:, 1, 1] = problem.sums(np.stack([np.where(slips, short * x * x, 1.0)] * 2))[:, 0]
        floor = np.maximum(1e-3 * problem.sums(np.ones_like(raw))[:, 0], 1e-300)
        slope += floor[:, None, None] * np.eye(2)
        step = np.linalg.solve(slope, missing[..., None])[..., 0]
        translation = translation + step / rate
    return translation


def _largest(problem: ShearProblem) -> float:
    """Largest eigenvalue of `slide` on the touching cells, m/Pa, by powers."""
    vector = np.where(problem.touching, np.ones((2, len(problem.area))), 0.0)
    vector[1] *= 0.5
    value = 0.0
    for _ in range(20):
        bent = np.where(problem.touching, problem.slide(vector), 0.0)
        value = float(np.sqrt(np.sum(bent**2) / np.sum(vector**2)))
        if value == 0.0:
            raise _stiff()
        vector = bent / value
    return value


HELD = 1e-5  # of Coulomb's limit: a force as near to it slides


def _sliding(problem: ShearProblem, limit: Floats) -> NDArray[np.bool_]:
    """Bodies (bodies,) at Coulomb's limit; InputError for one beyond."""
    most = problem.sums(np.stack([limit, limit]))[:, 0]
    force = np.hypot(*problem.forces.T)
    over = (force > most * (1 + HELD)) & (force > 0)
    if over.any():
        body = int(np.argmax(over))
        raise InputError(
            f"the shear of indenters[{body}] is {force[body]:g} N, expected at most friction "
            f"times its force, {most[body]:g} N: no skin holds more; press harder or shear less"
        )
    return np.asarray((force >= most * (1 - HELD)) & (force > 0))


def _slide(
    problem: ShearProblem,
    limit: Floats,
    sliding: NDArray[np.bool_],
    tolerance: float,
    most_iterations: int,
) -> Shear:
    """Some bodies slide: all of their cells are at the limit, along the force. Others hold."""
    along = problem.forces / np.maximum(np.hypot(*problem.forces.T), 1e-300)[:, None]
    gone = problem.touching & sliding[problem.bodies]
    full = np.where(gone, limit * along.T[:, problem.bodies], 0.0)
    held = replace(
        problem,
        touching=problem.touching & ~gone,
        forces=np.where(sliding[:, None], 0.0, problem.forces),
        ahead=problem.moved(full),
    )
    if not held.touching.any():
        rest = Shear(np.zeros_like(full), np.zeros(problem.forces.shape), gone, 0.0, 0)
    else:
        rest = solve_slip(held, limit, tolerance, most_iterations)
    traction = rest.traction + full
    below = problem.means(problem.moved(traction))
    translation = np.where(sliding[:, None], below, rest.translation)
    return Shear(traction, translation, rest.slipping | gone, rest.residual, rest.iterations)


def _stiff() -> SkinfieldError:
    return InputError(
        "the skin does not move tangentially, expected it to: under an inextensible cover the "
        "cover takes every shear; set the shear to zero or use a free surface"
    )


def _unsettled(error: float, iterations: int, tolerance: float) -> SkinfieldError:
    return SkinfieldError(
        f"shear reached a residual of {error:.1e} in {iterations} iterations, expected "
        f"{tolerance:.1e}: use finer cells"
    )
