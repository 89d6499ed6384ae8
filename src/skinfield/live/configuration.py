"""What of an engine's configuration may change while its ring stays: how readings are solved."""

import json
from dataclasses import dataclass

import numpy as np

from skinfield.acquisition.block import Block, Octets
from skinfield.errors import FileError, InputError
from skinfield.inverse import Solver
from skinfield.live.notes import HEAD, read_notes, write_notes
from skinfield.pipeline.batch_text import plain_from_value, value_from_plain
from skinfield.ring import Field, RingReader

ROOM = 1 << 13  # bytes
FIELD = Field("configuration", "<u1", (ROOM,))


@dataclass(frozen=True)
class Configuration:
    """What of an engine's configuration may change while its ring stays.

    Attributes
    ----------
    generation : int
        Of the ring's writer.
    solver : Solver
    began : bool
        Whether the engine's process has just begun: it knows nothing of readings before.
    """

    generation: int
    solver: Solver
    began: bool = False

    def text(self) -> str:
        """As JSON; raises InputError for a solver that is not skinfield's own, or too long."""
        plain = {
            "generation": self.generation,
            "solver": plain_from_value("solver", self.solver),
            "began": self.began,
        }
        text = json.dumps(plain)
        if len(text) > ROOM - HEAD:
            raise InputError(
                f"the solver's settings take {len(text)} characters, expected {ROOM - HEAD} at most"
            )
        return text

    def octets(self) -> Octets:
        """As the payload of a block of `Kind.CONFIGURATION`."""
        return np.frombuffer(self.text().encode(), np.uint8)

    @classmethod
    def from_text(cls, text: str | bytes) -> "Configuration":
        """Undo `text`; raises FileError for what it never gives."""
        try:
            plain = json.loads(text)
            solver = value_from_plain("solver", plain["solver"])
            if not hasattr(solver, "prepare"):
                raise FileError(f"the solver is {plain['solver']!r:.60}")
            return cls(int(plain["generation"]), solver, bool(plain["began"]))
        except (KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
            raise FileError(
                f"the configuration {text[:60]!r} cannot be used: {error}; expected what an engine "
                "writes"
            ) from error


def configuration_of(reader: RingReader) -> Configuration | None:
    """What the engine that writes a ring goes by; None while that is being written."""
    view = reader.status_view.get(FIELD.name)
    plain = None if view is None else read_notes(view)
    return None if plain is None else Configuration.from_text(json.dumps(plain))


def write_configuration(room: Octets, configuration: Configuration) -> None:
    """Into a ring's status, for `configuration_of`."""
    write_notes(room, json.loads(configuration.text()))


def configuration_in(block: Block) -> Configuration:
    """Of a block of that kind; raises FileError for a damaged one."""
    return Configuration.from_text(block.payload.tobytes())


def same(one: Solver, other: Solver) -> bool:
    """Whether two solvers have the same settings."""
    return bool(plain_from_value("solver", one) == plain_from_value("solver", other))
