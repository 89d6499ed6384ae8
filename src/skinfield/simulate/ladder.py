"""One body pressed harder and harder."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from skinfield.errors import InputError, as_floats, check_finite, check_shape
from skinfield.mechanics import Layer, Mechanics
from skinfield.simulate.press import Press, press


def press_ladder(
    layer: Layer,
    indenter: Any,
    forces: Sequence[float],
    extent: float = 60e-3,
    cell: float = 0.5e-3,
    mechanics: Mechanics | None = None,
) -> list[Press]:
    """Press one body with each of several forces.

    Parameters
    ----------
    layer : Layer
    indenter : Indenter
        A frozen dataclass, such as all of `skinfield.simulate`; its own force or depth is ignored.
    forces : (N,) floats, N
        In any order.
    extent, cell, mechanics
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
    check_finite("forces", loads, "one press per force, in newtons")
    if not len(loads):
        raise InputError("forces is empty, expected at least one force in newtons")
    bodies = [replace(indenter, force=float(force), depth=None) for force in loads]
    return [press(layer, [body], extent, cell, mechanics) for body in bodies]
