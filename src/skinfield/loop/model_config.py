"""Model configuration of a live skin: what its answers follow from, and models prepared from it."""

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from skinfield.elastic import Layer, Mechanics, Quantity
from skinfield.errors import FileError, Floats, InputError
from skinfield.estimate import ContactFinder, Estimate
from skinfield.loop.settings import LiveSettings
from skinfield.loop.slots import Head, Slot
from skinfield.loop.status_text import HEAD, Octets, read_notes, write_notes
from skinfield.reconstruct.engine import Engine
from skinfield.reconstruct.engine.state import Answer
from skinfield.reconstruct.multigrid import Rest
from skinfield.reconstruct.serialisation import plain_from_value, value_from_plain
from skinfield.ring import Field, RingReader, State
from skinfield.signal import Convention, Port
from skinfield.skin import Grid, Patch, Skin
from skinfield.solve import Solver

VALUES = ("layer", "mechanics", "quantity", "solver", "rungs", "board", "budget", "rows")


@dataclass(frozen=True, eq=False)
class ModelConfig:
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
    def of(cls, settings: LiveSettings, ports: tuple[Port, ...]) -> "ModelConfig":
        """Of the settings of a live skin, whose sources deliver these ports."""
        values = {name: getattr(settings, name) for name in VALUES if name != "budget"}
        return cls(settings.skin, ports, budget=settings.time_to_answer, **values)

    def engine(
        self,
        noise_std: Floats,
        progress: Callable[[int, int], None] = lambda ready, patches: None,
    ) -> Engine:
        """The engine, for the noise (L,) of all taxels in the quantity's unit.

        `progress` is called with how many patches are ready, of how many, while it is prepared.
        """
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
            progress=progress,
        )

    def to_json(self) -> str:
        """Text that `from_json` makes an equal configuration of.

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
    def from_json(cls, text: str) -> "ModelConfig":
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
    """

    generation: int
    solver: Solver

    def text(self) -> str:
        """As JSON; raises InputError for a solver that is not skinfield's own, or too long."""
        solver = plain_from_value("solver", self.solver)
        text = json.dumps({"generation": self.generation, "solver": solver})
        if len(text) > ROOM - HEAD:
            raise InputError(
                f"the solver's settings take {len(text)} characters, expected {ROOM - HEAD} at most"
            )
        return text

    @classmethod
    def from_text(cls, text: str | bytes) -> "Configuration":
        """Undo `text`; raises FileError for what it never gives."""
        try:
            plain = json.loads(text)
            solver = value_from_plain("solver", plain["solver"])
            if not hasattr(solver, "prepare"):
                raise FileError(f"the solver is {plain['solver']!r:.60}")
            return cls(int(plain["generation"]), solver)
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


def same(one: Solver, other: Solver) -> bool:
    """Whether two solvers have the same settings."""
    return bool(plain_from_value("solver", one) == plain_from_value("solver", other))


FEASIBLE = int(Answer.FEASIBLE)


class Models:
    """What follows from a pressure (deformation, uncertainty), prepared when it is first needed.

    Parameters
    ----------
    model_config : ModelConfig
    noise_std : (L,) array
        In the quantity's unit.
    """

    def __init__(self, model_config: ModelConfig, noise_std: Floats) -> None:
        self.model_config, self.noise_std = model_config, noise_std
        self.finder = ContactFinder()
        self._engine: Engine | None = None
        self._grid = lru_cache(4096)(self._new_grid)
        sizes = [len(patch) for patch in model_config.skin]
        self.starts = np.concatenate([[0], np.cumsum(sizes)]).tolist()

    @property
    def engine(self) -> Engine:
        """An engine like the one that answers; takes seconds to prepare."""
        if self._engine is None:
            self._engine = self.model_config.engine(self.noise_std)
        return self._engine

    @property
    def prepared(self) -> bool:
        """Whether deformation and uncertainty cost no preparation any more."""
        return self._engine is not None

    def moved(self, patch: int, nodes: int, pressure: Floats) -> Floats:
        """Displacement of a patch's nodes under a pressure (K,) Pa, (K, 3) m."""
        grid = self.grid(patch, nodes)
        return np.asarray(self._rung(patch, nodes).deformation.on(grid)(pressure))

    def grid(self, patch: int, nodes: int) -> Grid:
        """Grid of a patch with so many nodes a side."""
        return self._grid(patch, nodes)

    def _new_grid(self, patch: int, nodes: int) -> Grid:
        return Grid.square(self.model_config.skin[patch], nodes)

    def estimate(self, slot: Slot, patch: int, latency: float, late: bool) -> Estimate:
        """Estimate of a patch: pressure at once, the rest when it is asked for."""
        row, model_config = slot.patches[patch], self.model_config
        nodes = int(row["rung"]) or model_config.rungs[0]
        grid, answer = self.grid(patch, nodes), int(row["answer"])
        pressure = np.zeros(len(grid))
        if answer >= int(Answer.LINEAR):
            pressure[:] = slot.pressure[patch, : len(grid)]
        taxels = slice(self.starts[patch], self.starts[patch + 1])
        values = slot.values[taxels].astype(np.float64)
        linear = np.array(model_config.quantity.linearise(values, np.empty_like(values)))
        return Rest(
            grid=grid,
            pressure=pressure,
            readings=linear,
            valid=slot.valid[taxels].astype(np.bool_),
            predicted=lambda: self._predicted(patch, nodes, answer, pressure, linear),
            moved=lambda: self._rung(patch, nodes).deformation.on(grid)(pressure),
            beliefs=lambda: self._beliefs(patch, nodes, answer),
            finder=self.finder,
        ).estimate(
            latency=latency,
            stamp_ns=int(row["stamp_ns"]),
            gap=float(row["gap"]),
            iterations=int(row["iterations"]),
            deadline_met=not late,
        )

    def _group(self, patch: int) -> Any:
        engine = self.engine
        name = self.model_config.skin[patch].name
        return next(
            group for group in engine.groups if name in [p.name for p in group.kind.patches]
        )

    def _rung(self, patch: int, nodes: int) -> Any:
        return self._group(patch).rungs.steps[self.model_config.rungs.index(nodes)]

    def _beliefs(self, patch: int, nodes: int, answer: int) -> Any:
        step = self._rung(patch, nodes)
        return step.operator if answer == FEASIBLE and step.operator is not None else step

    def _predicted(
        self, patch: int, nodes: int, answer: int, pressure: Floats, linear: Floats
    ) -> Floats:
        step = self._rung(patch, nodes)
        if step.model is None:
            return np.asarray(self._group(patch).rungs.explained @ linear)
        return np.asarray(step.model.matrix @ pressure)


LEAVE = 5.0  # s that the next process of an engine may take to go on with its ring


class ConfigWatch:
    """Configuration and models of the cycles of a ring.

    Parameters
    ----------
    reader : RingReader
        Of a live skin.

    Raises
    ------
    FileError
        If it does not say what it is of.

    Attributes
    ----------
    model_config : ModelConfig
        Of the newest cycle that was asked for.
    """

    def __init__(self, reader: RingReader) -> None:
        self._reader = reader
        self.model_config = model_config_of(reader)
        self._generation = reader.generation
        self._models: tuple[int, Models] | None = None

    def look(self, generation: int) -> None:
        """Look what the solver is now, if another process of the engine made a cycle."""
        if generation == self._generation:
            return
        told = configuration_of(self._reader)
        if told is None or told.generation != generation:
            return  # a cycle from before: what is known already was in force
        self._generation = generation
        if not same(told.solver, self.model_config.solver):
            self.model_config, self._models = replace(self.model_config, solver=told.solver), None

    def models_of(self, slot: Slot) -> Models:
        """What turns the pressures of a cycle into deformation and uncertainty."""
        self.look(int(slot.head[Head.GENERATION]))
        return self.models

    @property
    def models(self) -> Models:
        """The same, for the calibration in force."""
        status = self._reader.status_view
        tares = int(status["tares"][0])
        if self._models is None or self._models[0] != tares:
            noise = status["noise_std"].copy()
            typical = self.model_config.quantity.typical_noise
            self._models = tares, Models(self.model_config, np.where(noise > 0, noise, typical))
        return self._models[1]


def model_config_of(reader: RingReader) -> ModelConfig:
    """What the answers of a live skin's ring follow from now.

    Raises
    ------
    FileError
        If it does not say.
    """
    model_config = ModelConfig.from_json(str(reader.description.get("model_config")))
    told = configuration_of(reader)
    return model_config if told is None else replace(model_config, solver=told.solver)


def state_of(reader: RingReader) -> State:
    """What the engine is doing; FAILED if its process is gone, unless another is to go on."""
    state = reader.state
    if reader.alive or state == State.STOPPED:
        return state
    silence = (time.monotonic_ns() - reader.heartbeat_ns) * 1e-9
    return State.STARTING if state == State.STARTING and silence < LEAVE else State.FAILED
