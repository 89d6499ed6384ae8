r"""Tangential loads on a contact that is known: bodies stick, or slip where Coulomb's limit is met.

A second stage after the normal contact (Goodman's way): below each body the skin moves along with
it, by one translation, and what the normal pressure alone moved tangentially is neither undone nor
opposed. With q the tangential traction, u = A q, and P the disc of radius mu p on each cell,

.. math:: q = P\left[q + \tau (d - A q)\right], \qquad \int q = T

for each body's translation d and force T; without a limit it is A q = d (Cattaneo 1938, Mindlin
1949). One step from rest: the history of a load that turns or falls is not followed.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, SkinfieldError

TOLERANCE = 1e-5
MOST_ITERATIONS = 5000


@dataclass(frozen=True, eq=False)
class ShearProblem:
    """Tangential forces on bodies that touch.

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
    """

    slide: Callable[[Floats], Floats]
    touching: NDArray[np.bool_]
    bodies: NDArray[np.int64]
    area: Floats
    forces: Floats

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
        Of each body.
    slipping : (N,) bool array
        Cells at Coulomb's limit.
    residual : float
        The largest difference, over the largest translation, between what each cell moves and what
        it should: as its body where it sticks; where it slips, behind it and against the traction.
    iterations : int
    """

    traction: Floats
    translation: Floats
    slipping: NDArray[np.bool_]
    residual: float
    iterations: int


def solve_stick(
    problem: ShearProblem,
    tolerance: float = TOLERANCE,
    most_iterations: int = MOST_ITERATIONS,
) -> Shear:
    """Traction if nothing slips: conjugate gradients with each body's force held.

    The traction is infinite at the contact's border, so near it some slip is inevitable in nature:
    `solve_slip` has that.

    Raises
    ------
    SkinfieldError
        If it does not converge.
    """
    traction = _uniform(problem)
    moved, fresh = problem.slide(traction), True
    direction, previous = np.zeros_like(traction), np.inf
    for iteration in range(most_iterations):
        translation, apart, error = _left(problem, moved)
        if error <= tolerance and not fresh:  # certify with what was not summed up
            moved, fresh = problem.slide(traction), True
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
    tolerance: float = 10 * TOLERANCE,
    most_iterations: int = MOST_ITERATIONS,
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
    _check_holds(problem, limit)
    rate = 1.0 / (1.05 * _largest(problem))
    traction = _uniform(problem)
    ahead, momentum = traction.copy(), 1.0
    translation = np.zeros((len(problem.forces), 2))
    for iteration in range(most_iterations):
        wanted = ahead - rate * problem.slide(ahead)
        translation = _held(problem, wanted, limit, translation, rate)
        new = _within(wanted + rate * translation.T[:, problem.bodies], limit)
        error = _relative((new - ahead) / rate, translation)
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


def _uniform(problem: ShearProblem) -> Floats:
    """Each force spread evenly over the touching cells of its body, (2, N)."""
    area = problem.sums(np.ones((2, len(problem.area))))
    spread = problem.forces / np.maximum(area, 1e-300)
    return np.where(problem.touching, spread.T[:, problem.bodies], 0.0)


def _left(problem: ShearProblem, moved: Floats) -> tuple[Floats, Floats, float]:
    """Translation of each body, what its cells lack of it, and that relative to it."""
    translation = problem.means(moved)
    apart = np.where(problem.touching, translation.T[:, problem.bodies] - moved, 0.0)
    return translation, apart, _relative(apart, translation)


def _relative(apart: Floats, translation: Floats) -> float:
    return float(np.hypot(*apart).max() / max(np.hypot(*translation.T).max(), 1e-300))


def _within(traction: Floats, limit: Floats) -> Floats:
    """The nearest traction (2, N) within the limit."""
    size = np.maximum(np.hypot(*traction), 1e-300)
    return np.asarray(traction * np.minimum(1.0, limit / size))


def _held(
    problem: ShearProblem, wanted: Floats, limit: Floats, translation: Floats, rate: float
) -> Floats:
    """Translations for which the limited traction has the given forces, by Newton's steps.

    The force is the gradient of a convex function of the translation, with the derivative 1 times
    area where a cell sticks and limit/size times area across the traction where it slips.
    """
    for _ in range(60):
        raw = wanted + rate * translation.T[:, problem.bodies]
        size = np.maximum(np.hypot(*raw), 1e-300)
        short = np.minimum(1.0, limit / size)
        missing = problem.forces - problem.sums(raw * short)
        if np.abs(missing).max() <= 1e-10 * np.abs(problem.forces).max():
            break
        x, y = raw / size
        slips = short < 1.0
        xx = problem.sums(np.stack([np.where(slips, short * y * y, 1.0),
                                    np.where(slips, short * x * x, 1.0)]))  # fmt: skip
        xy = problem.sums(np.stack([np.where(slips, -short * x * y, 0.0)] * 2))[:, 0]
        floor = 1e-3 * problem.sums(np.ones_like(raw))[:, 0]
        a, d = xx[:, 0] + floor, xx[:, 1] + floor
        determinant = np.maximum(a * d - xy**2, 1e-300)
        translation = translation + np.column_stack(
            [
                (d * missing[:, 0] - xy * missing[:, 1]) / determinant,
                (a * missing[:, 1] - xy * missing[:, 0]) / determinant,
            ]
        ) / rate  # fmt: skip
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


def _check_holds(problem: ShearProblem, limit: Floats) -> None:
    most = problem.sums(np.stack([limit, limit]))[:, 0]
    force = np.hypot(*problem.forces.T)
    over = force >= most * (1 - 1e-6)
    over &= force > 0
    if over.any():
        body = int(np.argmax(over))
        raise InputError(
            f"the shear of indenters[{body}] is {force[body]:g} N, expected less than friction "
            f"times its force, {most[body]:g} N: it would slide; press harder or shear less"
        )


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
