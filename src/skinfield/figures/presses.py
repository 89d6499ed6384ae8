"""What was truly pressed, where a figure is told."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skinfield.errors import Floats, InputError, as_floats, check_finite
from skinfield.fields import Contact
from skinfield.layout import Grid


@dataclass(frozen=True, eq=False)
class Press:
    """A true press: where (3,) m, how hard N along the skin's normal, and over which radius m."""

    position: Floats
    force: float
    radius: float


def presses_from_truth(truth: Iterable[tuple[Any, Any, float]] | None, grid: Grid) -> list[Press]:
    """Presses from (position, force, radius).

    A position is (3,) m, or (2,) m in the patch's plane; a force is in N along the inward normal,
    or a vector (3,) N in the patch's frame; a radius is in m.

    Raises
    ------
    InputError
        If an entry is anything else.
    """
    presses = []
    for row, entry in enumerate(truth or ()):
        try:
            place, load, reach = entry
        except (TypeError, ValueError) as error:
            raise InputError(
                f"truth[{row}] is {entry!r}, expected (position, force, radius): "
                "in metres, newtons and metres"
            ) from error
        name = f"truth[{row}]"
        position, force = as_floats(f"{name} position", place), as_floats(f"{name} force", load)
        if position.shape not in ((2,), (3,)) or force.shape not in ((), (3,)):
            raise InputError(
                f"{name} has position of shape {position.shape} and force of shape {force.shape}, "
                "expected (2,) or (3,) m, and a number or (3,) N"
            )
        numbers = np.array([*position, *force.ravel(), float(reach)])
        check_finite(name, numbers, "a press has a place, a force and a radius")
        if position.shape == (2,):
            position = grid.patch.surface.position_from_plane(position[None])[0]
        if force.shape == (3,):
            nearest = np.linalg.norm(grid.positions - position, axis=1).argmin()
            force = -force @ grid.normals[nearest]
        presses.append(Press(position, float(force), float(reach)))
    return presses


def nearest_contact(press: Press, contacts: Iterable[Contact]) -> tuple[Contact, float] | None:
    """Find the contact nearest to a press, and its distance in m; None where there is none."""
    pairs = [(c, float(np.linalg.norm(c.position - press.position))) for c in contacts]
    return min(pairs, key=lambda pair: pair[1], default=None)
