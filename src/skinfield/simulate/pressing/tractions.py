"""Tractions on the skin in windows, normal and tangential: sums over them, and friction."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic.contact import (
    RIM,
    SHEAR_TOLERANCE,
    ContactSolution,
    Shear,
    ShearProblem,
    rim,
    solve_contact,
    solve_slip,
    solve_stick,
)
from skinfield.errors import Floats, SkinfieldError, check_positive
from skinfield.simulate.indenters.body import Indenter
from skinfield.simulate.pressing.contact import (
    Coverings,
    Settled,
    check_border,
    check_depth,
    problem_of,
    reaches_border,
    shared,
    widened,
)
from skinfield.simulate.pressing.windows import (
    DRAGGED,
    LIFTED,
    TANGENTIAL,
    Medium,
    Window,
    Yielding,
    coarsened,
)


@dataclass(frozen=True, eq=False)
class Traction:
    """Traction on the squares of a window.

    Attributes
    ----------
    window : Window
    traction : (3, rows, columns) array, Pa
        On the skin; z is outward, so a push is negative. Force over the whole area of a square.
    body : (rows, columns) int array
        The indenter that can touch.
    coverage : (rows, columns) array
        Fraction of each square below that indenter.
    """

    window: Window
    traction: Floats
    body: NDArray[np.int64]
    coverage: Floats

    @property
    def touching(self) -> NDArray[np.bool_]:
        """Squares that carry pressure."""
        return np.asarray(self.traction[2] < 0)

    @property
    def share(self) -> Floats:
        """Touched fraction of each square.

        Below a sharp edge it is the covered one. Where a body curves away, the solution touches as
        far as `RIM` squares beyond the true border (measured against Hertz and the layer's exact
        solution), which is taken off.
        """
        from scipy.ndimage import binary_dilation

        touching = self.touching
        sharp = binary_dilation(self.coverage < 1, np.ones((3, 3), dtype=bool))
        beyond = np.where(sharp, 0.0, RIM * rim(touching))
        return np.asarray(np.where(touching, self.coverage, 0.0) - beyond)

    def area(self, side: float) -> float:
        """Touched, m², for squares of a side in m."""
        return float(self.share.sum() * side**2)


@dataclass(frozen=True, eq=False)
class Sources:
    """Uniform squares that stand for touches; a window's own squares are too many for most uses.

    Attributes
    ----------
    places : (N, 2) array, m
        Each square's centre of pressure, so that no moment is lost.
    traction : (N, 3) array, Pa
    side : float, m
    """

    places: Floats
    traction: Floats
    side: float


def sources(skin: Medium, touch: Traction, widest: float) -> Sources:
    """Join squares of a touch to larger ones, up to a side of `widest` m."""
    split = touch.window.split
    while split > 1 and skin.grid.pitch / (split // 3) <= widest:
        split //= 3
    factor = touch.window.split // split
    y, x = skin.axes(touch.window)
    push = -touch.traction[2]
    moments = np.stack([push, push * x, push * y[:, None]])
    total, at_x, at_y = (part.ravel() for part in coarsened(moments, factor))
    loaded = total > 0
    places = np.column_stack([at_x[loaded], at_y[loaded]]) / total[loaded, None]
    traction = coarsened(touch.traction, factor).reshape(3, -1)[:, loaded].T
    return Sources(places, traction, skin.grid.pitch / split)


def resultants(skin: Medium, touches: tuple[Traction, ...], bodies: int) -> tuple[Floats, Floats]:
    """Force (bodies, 3) N on the skin and its moment (bodies, 3) N m about the grid's origin."""
    forces, moments = np.zeros((bodies, 3)), np.zeros((bodies, 3))
    for touch in touches:
        y, x = skin.axes(touch.window)
        area = skin.side(touch.window) ** 2
        fx, fy, fz = touch.traction * area
        arms = np.stack([y[:, None] * fz, -x * fz, x * fy - y[:, None] * fx])
        for body in range(bodies):
            own = touch.body == body
            forces[body] += np.sum(np.stack([fx, fy, fz])[:, own], axis=1)
            moments[body] += np.sum(arms[:, own], axis=1)
    return forces, moments


def bare(settled: Settled) -> tuple[Traction, ...]:
    """Touches with pressure alone."""
    coverings, pictures = settled.coverings, settled.indenting.pictures
    return tuple(
        Traction(window, np.stack([np.zeros_like(p), np.zeros_like(p), 0.0 - p]), body, coverage)
        for window, p, body, coverage in zip(
            coverings.windows,
            pictures(settled.contact.pressure),
            pictures(coverings.bodies),
            pictures(coverings.coverage),
            strict=True,
        )
    )


ROUNDS = 40
FREE = 5  # rounds in which squares may come to hold the body, and let go
SAME = 1e-4  # of the force: by which the pressure may still change from round to round
EASE = 10.0  # by which tolerances are wider while the pressure still changes
WIDER = 3  # cells
MARGINS = 3, 8  # cells around the touches of a path


@dataclass(frozen=True, eq=False)
class Rubbed:
    """Contact with friction on windows.

    Attributes
    ----------
    settled : Settled
        Its pressure is that of the whole load.
    shear : Shear
    moved : (2, N) array, m
        Displacement of the surface along the plane.
    """

    settled: Settled
    shear: Shear
    moved: Floats

    @property
    def touches(self) -> tuple[Traction, ...]:
        """Touches with pressure and tangential traction."""
        along = self.settled.indenting.pictures(self.shear.traction)
        return tuple(
            replace(touch, traction=np.stack([*each, touch.traction[2]]))
            for touch, each in zip(bare(self.settled), along, strict=True)
        )


class Surface:
    """What tractions along the plane and across it do to each other on windows."""

    def __init__(self, coverings: Coverings) -> None:
        skin, windows = coverings.skin, coverings.windows
        self.coverings = coverings
        self.sliding = Yielding(skin, windows, TANGENTIAL)
        self.lifting = Yielding(skin, windows, LIFTED)
        self.dragging = Yielding(skin, windows, DRAGGED)

    def lifted(self, traction: Floats) -> Floats:
        """Displacement (N,) m outwards by tangential traction (2, N) Pa."""
        return np.asarray(self.lifting(traction)[0])

    def dragged(self, pressure: Floats) -> Floats:
        """Displacement (2, N) m along the plane by pressure (N,) Pa."""
        return self.dragging(-pressure[None])

    def shear(
        self,
        pressure: Floats,
        touching: NDArray[np.bool_],
        forces: Floats,
        friction: float | None,
        before: Floats,
        start: Floats | None,
        ease: float,
    ) -> Shear:
        """Tangential tractions where it touches, in a step from the displacement `before`.

        To the usual tolerances times `ease`.
        """
        coverings = self.coverings
        # The limits of a touch that ends smoothly need no softness: it is found as much too wide as
        # the border's singularity makes it act too narrow.
        softness = np.where(touching, self.sliding.own * coverings.softness, 0.0)
        problem = ShearProblem(
            lambda traction: self.sliding(traction) + softness * traction,
            touching,
            coverings.bodies,
            coverings.area,
            forces,
            self.dragged(pressure) - before,
            start,
        )
        if friction is None:
            return solve_stick(problem, ease * SHEAR_TOLERANCE)
        return solve_slip(problem, friction * pressure, 10 * ease * SHEAR_TOLERANCE)


def rub(settled: Settled, indenters: Sequence[Indenter], friction: float | None) -> Rubbed:
    """Push bodies along the plane that were pressed on without friction before.

    Tangential tractions raise the skin ahead and lower it behind, so pressure and place of touch
    change, and with them the tractions: the two problems are solved in turn (Panagiotopoulos 1975).
    """
    if friction is not None:
        check_positive("friction", friction, "Coulomb's coefficient; None is for no limit")
    while True:
        rubbed = _rubbed(settled, indenters, friction, None)
        check_depth(indenters, rubbed.settled)
        if not reaches_border(rubbed.settled):
            return rubbed
        check_border(rubbed.settled)
        settled = widened(settled, indenters, WIDER)


def follow(
    states: Sequence[Settled], path: Sequence[Sequence[Indenter]], friction: float | None
) -> list[Rubbed]:
    """Follow a path of loads and places with friction from the first touch on, step by step.

    Skin that sticks keeps its place below the body, and what comes to touch is held from then on.

    Parameters
    ----------
    states : sequence of Settled
        Contacts of the steps without friction.
    path : sequence of sequences of Indenter
        The same bodies in each step.
    friction : float, optional
    """
    for margin in MARGINS:
        done: list[Rubbed] = []
        for settled, indenters in zip(shared(states, path, margin), path, strict=True):
            done.append(_rubbed(settled, indenters, friction, done[-1] if done else _rest(settled)))
            check_depth(indenters, done[-1].settled)
            check_border(done[-1].settled)
        if not any(reaches_border(each.settled) for each in done):
            return done
    raise SkinfieldError(
        f"touch under friction grew by more than {margin} cells, expected less: shear less"
    )


def _rest(settled: Settled) -> Rubbed:
    """Nothing has touched the skin yet."""
    still = np.zeros((2, len(settled.contact.pressure)))
    bodies = len(settled.contact.approach)
    none = np.zeros(still.shape[1], dtype=np.bool_)
    return Rubbed(settled, Shear(still, np.zeros((bodies, 2)), none, 0.0, 0), still)


def _rubbed(
    settled: Settled,
    indenters: Sequence[Indenter],
    friction: float | None,
    before: Rubbed | None,
) -> Rubbed:
    """See `rub`, on the windows of a contact; in a step from `before`, if anything was."""
    coverings = settled.coverings
    surface = Surface(coverings)
    forces = np.array([body.shear for body in indenters], dtype=np.float64)
    contact, traction = settled.contact, None if before is None else before.shear.traction
    moved = surface.dragged(contact.pressure) if before is None else before.moved
    area, softness = coverings.area, coverings.softness
    holding, same = contact.pressure > 0, False
    for attempt in range(ROUNDS):
        # Squares at the border would else come and go for ever.
        holding = contact.pressure > 0 if attempt < FREE else holding
        ease = 1.0 if same else EASE
        shear = surface.shear(contact.pressure, holding, forces, friction, moved, traction, ease)
        traction = shear.traction
        if same:
            moved = surface.sliding(traction) + surface.dragged(contact.pressure)
            return Rubbed(replace(settled, contact=contact), shear, moved)
        problem = problem_of(coverings, settled.indenting, indenters, surface.lifted(traction))
        new: ContactSolution = solve_contact(problem, contact.pressure, softness)
        change = float(np.sum(area * np.abs(new.pressure - contact.pressure)))
        same, contact = change <= SAME * float(np.sum(area * new.pressure)), new
    raise SkinfieldError(
        f"pressure under friction still changes by {change:.1e} N after {ROUNDS} rounds, expected "
        "it to settle: shear less, or state a friction coefficient below 1"
    )
