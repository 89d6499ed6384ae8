"""What taxels read of simulated presses, solved once and carried to any place."""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

import skinfield as sf
from skinfield.simulate.pressing.press import Readings, readings_anywhere

Floats = NDArray[np.float64]
LAYER = sf.Layer()
PATCH = sf.layouts.hexagon72()
CELL = 0.25e-3  # m: of the truth's grid
TABLE = 0.75e-3  # m: of the readings of a press that is not round


@lru_cache(maxsize=32)
def solved(body: Any, quantity: str, layer: sf.Layer = LAYER) -> tuple[sf.simulate.Press, Readings]:
    """A press at the origin, and what a taxel anywhere reads of it."""
    press = sf.simulate.press(layer, [body], extent=30e-3, cell=CELL)
    return press, readings_anywhere(press, PATCH.pad_diameter, quantity, TABLE)


def truth(body: Any, place: tuple[float, float], quantity: str, turn: float = 0.0) -> Floats:
    """Readings (72,) of a body that presses at a place (m), turned about it."""
    cos, sin = np.cos(turn), np.sin(turn)
    away = (PATCH.plane - place) @ np.array([[cos, -sin], [sin, cos]])
    return np.asarray(solved(body, quantity)[1](away))
