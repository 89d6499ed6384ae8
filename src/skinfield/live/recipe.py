"""What the answers of a live skin follow from, so that a reader or a replay makes it again."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from skinfield.acquisition import Port
from skinfield.conditioning import Convention
from skinfield.engine import Engine
from skinfield.errors import FileError, Floats
from skinfield.inverse import Solver
from skinfield.layout import Patch, Skin
from skinfield.live.settings import LiveSettings
from skinfield.mechanics import Layer, Mechanics
from skinfield.observation import Quantity
from skinfield.pipeline.batch_text import plain_from_value, value_from_plain

VALUES = ("layer", "mechanics", "quantity", "solver", "rungs", "board", "budget", "rows")


@dataclass(frozen=True, eq=False)
class Recipe:
    """All that decides the estimates beside readings and calibration.

    Attributes
    ----------
    skin : Skin
    ports : tuple of Port
    layer, mechanics, quantity, solver, rungs, board
        As in `LiveSettings`.
    budget : float, s
        Of the reconstruction.
    rows : int
        Contacts per patch.
    """

    skin: Skin
    ports: tuple[Port, ...]
    layer: Layer
    mechanics: Mechanics
    quantity: Quantity
    solver: Solver
    rungs: tuple[int, ...]
    board: Convention | None
    budget: float
    rows: int

    @classmethod
    def of(cls, settings: LiveSettings, ports: tuple[Port, ...]) -> "Recipe":
        """Of the settings of a live skin, whose sources deliver these ports."""
        return cls(
            settings.skin,
            ports,
            settings.layer,
            settings.mechanics,
            settings.quantity,
            settings.solver,
            settings.rungs,
            settings.board,
            settings.time_to_answer,
            settings.rows,
        )

    def engine(self, noise_std: Floats) -> Engine:
        """The engine, for the noise (L,) of all taxels in the quantity's unit."""
        noise, start = {}, 0
        for patch in self.skin:
            noise[patch.name] = noise_std[start : start + len(patch)]
            start += len(patch)
        return Engine(
            self.skin,
            self.layer,
            budget=self.budget,
            rungs=self.rungs,
            mechanics=self.mechanics,
            quantity=self.quantity,
            solver=self.solver,
            noise_std=noise,
        )

    def to_json(self) -> str:
        """Text that `from_json` makes an equal recipe of.

        Raises
        ------
        InputError
            If a part is not skinfield's own, such as a solver of one's own.
        """
        plain = {name: plain_from_value(name, getattr(self, name)) for name in VALUES}
        plain["skin"] = {
            "name": self.skin.name,
            "patches": [plain_from_value("patch", patch) for patch in self.skin],
        }
        plain["ports"] = [[port.name, port.channels, port.unit] for port in self.ports]
        return json.dumps(plain)

    @classmethod
    def from_json(cls, text: str) -> "Recipe":
        """Undo `to_json`; nothing but skinfield's own settings is ever made from it.

        Raises
        ------
        FileError
            For what it never writes.
        """
        try:
            plain = json.loads(text)
            patches = tuple(value_from_plain("patch", each) for each in plain["skin"]["patches"])
            ports = tuple(Port(*row) for row in plain["ports"])
            values: Mapping[str, Any] = {n: value_from_plain(n, plain[n]) for n in VALUES}
            if not all(isinstance(patch, Patch) for patch in patches):
                raise FileError("the skin's patches are something else")
            return cls(Skin(patches, name=str(plain["skin"]["name"])), ports, **values)
        except FileError:
            raise
        except (KeyError, TypeError, ValueError, RecursionError, AttributeError) as error:
            raise FileError(
                f"the configuration {text[:60]!r}... cannot be used: {error}; expected what a live "
                "skin writes"
            ) from error


def table_of(calibration: bytes, taxels: int) -> Floats:
    """Calibration (L, 4) from the bytes of one.

    Raises
    ------
    FileError
        If there are too many or too few.
    """
    if len(calibration) != taxels * 4 * 8:
        raise FileError(
            f"the calibration has {len(calibration)} bytes, expected {taxels * 32}: 4 numbers of "
            f"8 bytes for each of {taxels} taxels"
        )
    return np.frombuffer(calibration, "<f8").reshape(taxels, 4).copy()
