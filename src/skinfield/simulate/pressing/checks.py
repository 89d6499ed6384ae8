"""Presses that cannot be, by name."""

from collections.abc import Sequence

import numpy as np

from skinfield.errors import InputError
from skinfield.simulate.indenters import Indenter
from skinfield.simulate.pressing.laid import Laid, Settled
from skinfield.simulate.pressing.plane import Skin


def check_places(skin: Skin, indenters: Sequence[Indenter], whole: Laid) -> None:
    """Each body must have cells, and be the lowest on some of them."""
    for index, indenter in enumerate(indenters):
        under = np.isfinite(whole.each[index])
        if not under.any():
            grid = skin.grid
            raise InputError(
                f"indenters[{index}] at {indenter.position} m covers no cell, expected it within "
                f"{grid.shape[0] * grid.pitch / 2:g} m of the origin and wider than a tenth of a "
                f"cell of {grid.pitch:g} m"
            )
        if not under[whole.bodies == index].any():
            raise InputError(
                f"indenters[{index}] at {indenter.position} m lies behind the others, "
                "expected them apart: each must be the lowest somewhere"
            )


def check_border(settled: Settled) -> None:
    """A touch that the square of skin cuts off would be another press than the one meant."""
    laid, grid = settled.laid, settled.laid.skin.grid
    pictures = settled.indenting.pictures(settled.contact.pressure)
    for window, pressure, body in zip(
        laid.windows, pictures, settled.indenting.pictures(laid.bodies), strict=True
    ):
        border = np.zeros(pressure.shape, dtype=bool)
        border[0] |= window.row == 0
        border[-1] |= window.row + window.rows == grid.shape[0]
        border[:, 0] |= window.column == 0
        border[:, -1] |= window.column + window.columns == grid.shape[1]
        cut_off = border & (pressure > 0)
        if cut_off.any():
            side = grid.shape[0] * grid.pitch
            raise InputError(
                f"indenters[{int(body[cut_off][0])}] touches the border of the {side:g} m of skin "
                "around the origin, expected skin on all sides of it: raise extent, or move it in"
            )


def check_depth(indenters: Sequence[Indenter], settled: Settled) -> None:
    """No body may reach the base; one that does as most of it has no skin hears of that."""
    thickness, approach = settled.laid.skin.layer.thickness, settled.contact.approach
    deepest = int(approach.argmax())
    if approach[deepest] >= thickness:
        check_border(settled)
        raise InputError(
            f"indenters[{deepest}] with {_load(indenters[deepest])} sinks "
            f"{approach[deepest] * 1e3:.3g} mm into a layer of {thickness * 1e3:g} mm, "
            "expected less than its thickness: press lighter, or with a wider body"
        )


def _load(indenter: Indenter) -> str:
    return f"{indenter.depth:g} m" if indenter.force is None else f"{indenter.force:g} N"
