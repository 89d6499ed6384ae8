"""Noise and solver of a live skin, which change while its ring stays."""

from typing import Any, NamedTuple

import numpy as np

from skinfield.bridges.zenoh.messages import MOST_JSON, object_of, strict_json
from skinfield.errors import Floats, InputError
from skinfield.inverse import Solver
from skinfield.pipeline.batch_text import plain_from_value, value_from_plain


class Calibration(NamedTuple):
    """What changes while a ring stays, and decides what follows from a pressure.

    Attributes
    ----------
    tares : int
        Baselines taken so far.
    generation : int
        Of the engine's process.
    solver : Solver or None
        None: that of the recipe.
    noise_std : (L,) array
        In the quantity's unit.
    """

    tares: int
    generation: int
    solver: Solver | None
    noise_std: Floats

    def packed(self) -> bytes:
        """As JSON."""
        solver = None if self.solver is None else plain_from_value("solver", self.solver)
        plain = {"tares": self.tares, "generation": self.generation, "solver": solver}
        return strict_json(plain | {"noise_std": self.noise_std.tolist()})

    @classmethod
    def of(cls, data: bytes, taxels: int) -> "Calibration":
        """Undo `packed`, of a skin with so many taxels.

        Raises
        ------
        InputError
            If it makes no sense.
        """
        plain = object_of(data, MOST_JSON)
        tares, generation = _count(plain.get("tares")), _count(plain.get("generation"))
        values = plain.get("noise_std")
        if not isinstance(values, list) or len(values) != taxels or not _all_noise(values):
            raise InputError(f"a calibration has no noise of {taxels} taxels, expected that")
        solver = value_from_plain("solver", plain.get("solver"))
        if solver is not None and not (isinstance(plain["solver"], dict) and _solves(solver)):
            raise InputError(f"a solver is {plain['solver']!r:.60}, expected one of skinfield's")
        return cls(tares, generation, solver, np.array(values, np.float64))


def _solves(solver: object) -> bool:
    return callable(getattr(solver, "prepare", None))


def _count(value: Any) -> int:
    if type(value) is not int or not 0 <= value < 1 << 62:
        raise InputError(f"a calibration counts {value!r:.40}, expected a whole number from 0")
    return value


def _all_noise(values: list[Any]) -> bool:
    return all(type(each) in (int, float) and 0 <= each < 1e30 for each in values)
