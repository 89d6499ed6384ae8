"""Imposed pressure: what soft fingers do to the skin, and how deep it yields below them."""

from collections.abc import Sequence

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.simulate.indenters.body import Indenter
from skinfield.simulate.indenters.finger import Finger
from skinfield.simulate.pressing import readout
from skinfield.simulate.pressing.tractions import Traction
from skinfield.simulate.pressing.windows import Medium


def are_soft(indenters: Sequence[Indenter]) -> bool:
    """Whether all bodies are fingers.

    Raises
    ------
    InputError
        If only some of them are: how a rigid body and a soft one share skin is not solved.
    """
    soft = [isinstance(each, Finger) for each in indenters]
    if any(soft) and not all(soft):
        raise InputError(
            f"indenters are {', '.join(each.kind for each in indenters)}, expected fingers alone "
            "or none: press them one after the other"
        )
    return all(soft)


def impose(skin: Medium, fingers: Sequence[Indenter]) -> tuple[Traction, Floats]:
    """Traction of fingers on the skin, and how deep the skin yields below each, (fingers,) m.

    Raises
    ------
    InputError
        If a finger lies beyond the grid or on another one, or the skin yields by its thickness.
    """
    window = skin.whole
    y, x = skin.axes(window)
    across, along = np.meshgrid(x, y)
    side, half = skin.side(window), skin.grid.shape[0] * skin.grid.pitch / 2
    pressures, touched = [], []
    for index, finger in enumerate(fingers):
        assert isinstance(finger, Finger)  # see `are_soft`
        if max(map(abs, finger.position)) + finger.reach > half:
            raise InputError(
                f"indenters[{index}] reaches {finger.reach:g} m from {finger.position} m, expected "
                f"within the {2 * half:g} m of skin around the origin: raise extent, or move it in"
            )
        pressure, part = finger.pressure(across, along, side)
        pressures.append(pressure)
        touched.append(part)
    if (np.count_nonzero(pressures, axis=0) > 1).any():
        raise InputError("fingers overlap, expected each on skin of its own: move them apart")
    total = np.sum(pressures, axis=0)
    nothing = np.zeros_like(total)
    found = Traction(
        window,
        np.stack([nothing, nothing, 0.0 - total]),
        np.argmax(pressures, axis=0),
        np.max(touched, axis=0),
    )
    sunk = readout.indentation(skin, (found,))
    approach = np.array([float(sunk[pressure > 0].max()) for pressure in pressures])
    deepest, thickness = int(approach.argmax()), skin.layer.thickness
    if approach[deepest] >= thickness:
        raise InputError(
            f"indenters[{deepest}] with {fingers[deepest].force:g} N sinks "
            f"{approach[deepest] * 1e3:.3g} mm into a layer of {thickness * 1e3:g} mm, "
            "expected less than its thickness: press lighter, or with a wider finger"
        )
    return found, approach
