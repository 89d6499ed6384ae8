"""The tangential stage of a press, on the windows of the normal one."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from skinfield.errors import Floats, check_positive
from skinfield.mechanics.friction import ShearProblem, solve_slip, solve_stick
from skinfield.simulate.indenters import Indenter
from skinfield.simulate.pressing.laid import Settled
from skinfield.simulate.pressing.responses import Sliding
from skinfield.simulate.pressing.touch import Touch


@dataclass(frozen=True, eq=False)
class Sheared:
    """What the tangential stage adds: translations (bodies, 2) m, its residual, share of slip."""

    translation: Floats
    residual: float
    slipping_share: float


def bare(settled: Settled) -> tuple[Touch, ...]:
    """Touches with pressure alone."""
    laid, pictures = settled.laid, settled.indenting.pictures
    return tuple(
        Touch(window, np.stack([np.zeros_like(p), np.zeros_like(p), 0.0 - p]), body, coverage)
        for window, p, body, coverage in zip(
            laid.windows,
            pictures(settled.contact.pressure),
            pictures(laid.bodies),
            pictures(laid.coverage),
            strict=True,
        )
    )


def add_shear(
    settled: Settled,
    touches: tuple[Touch, ...],
    indenters: Sequence[Indenter],
    friction: float | None,
) -> tuple[tuple[Touch, ...], Sheared]:
    """Tangential tractions under the shears of all indenters at once."""
    laid, contact = settled.laid, settled.contact
    sliding = Sliding(laid.skin, laid.windows)
    touching = contact.pressure > 0
    # The limits of a touch that ends smoothly need no softness: it is found as much too wide as
    # the border's singularity makes it act too narrow.
    softness = np.where(touching, sliding.own * laid.softness, 0.0)
    problem = ShearProblem(
        lambda traction: sliding(traction) + softness * traction,
        touching,
        laid.bodies,
        laid.area,
        np.array([indenter.shear for indenter in indenters], dtype=np.float64),
    )
    if friction is None:
        shear = solve_stick(problem)
    else:
        check_positive("friction", friction, "Coulomb's coefficient; None is for no limit")
        shear = solve_slip(problem, friction * contact.pressure)
    along = [sliding.indenting.pictures(component) for component in shear.traction]
    loaded = tuple(
        replace(touch, traction=np.stack([x, y, touch.traction[2]]))
        for touch, x, y in zip(touches, *along, strict=True)
    )
    share = float(laid.area[shear.slipping].sum() / laid.area[touching].sum())
    return loaded, Sheared(shear.translation, shear.residual, share)
