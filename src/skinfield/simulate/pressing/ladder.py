"""One body pressed harder and harder."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import InputError, as_floats, check_positive, check_shape
from skinfield.mechanics import BondedLayer, Layer, Mechanics
from skinfield.simulate.pressing.laid import Settled
from skinfield.simulate.pressing.press import Press, pressed, skin_of
from skinfield.simulate.pressing.settle import settle


def press_ladder(
    layer: Layer,
    indenter: Any,
    forces: ArrayLike | Sequence[float],
    extent: float = 60e-3,
    cell: float = 0.5e-3,
    mechanics: Mechanics | None = None,
    friction: float | None = None,
) -> list[Press]:
    """Press one body with each of several forces: as `press` for each, in less time.

    Parameters
    ----------
    layer : Layer
    indenter : Indenter
        A frozen dataclass, such as all of `skinfield.simulate`; its own force or depth is ignored,
        its shear is kept.
    forces : (N,) floats, N
        In any order. They are solved from the smallest, each from the one before.
    extent, cell, mechanics, friction
        See `press`.

    Returns
    -------
    list of Press
        In the order of the forces.

    Raises
    ------
    InputError
        For a force that is not above 0, or that pushes the body through the layer.
    """
    loads = as_floats("forces", forces)
    check_shape("forces", loads, (None,), "one press per force, in newtons")
    if not len(loads):
        raise InputError("forces is empty, expected at least one force in newtons")
    for index, load in enumerate(loads):
        check_positive(f"forces[{index}]", float(load), "into the skin, in newtons")
    check_positive("extent", extent, "side of the square of skin, in metres")
    check_positive("cell", cell, "side of a cell, in metres")
    skin = skin_of(layer, extent, cell, BondedLayer() if mechanics is None else mechanics)
    found: dict[int, Press] = {}
    before: Settled | None = None
    for index in np.argsort(loads, kind="stable"):
        body = replace(indenter, force=float(loads[index]), depth=None)
        before = settle(skin, [body], before)
        found[int(index)] = pressed(before, [body], friction)
    return [found[index] for index in range(len(loads))]
