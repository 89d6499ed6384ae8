"""Tractions on the skin in one window, normal and tangential, and sums over it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic.contact import RIM, Shear, ShearProblem, rim, solve_slip, solve_stick
from skinfield.errors import Floats, check_positive
from skinfield.simulate.indenters.body import Indenter
from skinfield.simulate.pressing.contact import Settled
from skinfield.simulate.pressing.windows import Medium, Window, Yielding, coarsened


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


def add_shear(
    settled: Settled,
    touches: tuple[Traction, ...],
    indenters: Sequence[Indenter],
    friction: float | None,
) -> tuple[tuple[Traction, ...], Shear]:
    """Tangential tractions under the shears of all indenters at once, and their solution."""
    coverings, contact = settled.coverings, settled.contact
    sliding = Yielding(coverings.skin, coverings.windows, tangential=True)
    touching = contact.pressure > 0
    # The limits of a touch that ends smoothly need no softness: it is found as much too wide as
    # the border's singularity makes it act too narrow.
    softness = np.where(touching, sliding.own * coverings.softness, 0.0)
    problem = ShearProblem(
        lambda traction: sliding(traction) + softness * traction,
        touching,
        coverings.bodies,
        coverings.area,
        np.array([indenter.shear for indenter in indenters], dtype=np.float64),
    )
    if friction is None:
        shear = solve_stick(problem)
    else:
        check_positive("friction", friction, "Coulomb's coefficient; None is for no limit")
        shear = solve_slip(problem, friction * contact.pressure)
    loaded = tuple(
        replace(touch, traction=np.stack([*along, touch.traction[2]]))
        for touch, along in zip(touches, sliding.pictures(shear.traction), strict=True)
    )
    return loaded, shear
