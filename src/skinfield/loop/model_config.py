"""Model configuration of a live skin: channels of its taxels, what its answers follow from."""

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import Layer, Mechanics, Quantity
from skinfield.errors import FileError, Floats, InputError, Ints
from skinfield.estimate import Estimate
from skinfield.estimate.row_contacts import contacts_of_rows, pressure_std_of_rows
from skinfield.loop.runtime_parameters import Tuning
from skinfield.loop.settings import LiveSettings
from skinfield.loop.slots import CycleSlot
from skinfield.loop.status_text import Octets, read_notes, write_notes
from skinfield.reconstruct.engine import Engine
from skinfield.reconstruct.engine.patch_kinds import kinds_of
from skinfield.reconstruct.engine.state import Answer
from skinfield.reconstruct.multigrid import Rung, Rungs, prepare_rungs
from skinfield.reconstruct.plan import details
from skinfield.reconstruct.serialisation import plain_from_value, value_from_plain
from skinfield.ring import Field, RingReader, State
from skinfield.signal import Convention, Port
from skinfield.skin import Grid, Patch, Skin
from skinfield.solve import Auto, ContactFit, NonNegative, Solution, Solver

VALUES = "layer", "mechanics", "quantity", "solver", "rungs", "board", "budget", "rows", "relative"


@dataclass(frozen=True, eq=False)
class Binding:
    """Taxels of all patches, in the skin's order, and their channels among all ports.

    Attributes
    ----------
    channel : (L,) array
    starts : (P + 1,) array
        Where each patch's taxels begin.
    channels : int
        Of all ports together.
    unit : str
        Of the readings: that of the ports, which must have one in common.
    """

    channel: Ints
    starts: Ints
    channels: int
    unit: str


def bind(skin: Skin, ports: Sequence[Port]) -> Binding:
    """Find the port of each patch: that of its name, or the only one.

    Raises
    ------
    InputError
        If a patch has no port, one that is too short, or ports deliver different units.
    """
    if not ports:
        raise InputError("there is no port, expected a source with at least one")
    first = np.cumsum([0, *(port.channels for port in ports)]).tolist()
    rows, starts, units = [], [0], set()
    names = [port.name for port in ports]
    for patch in skin:
        wanted = (patch.name, skin.name) if len(skin) == 1 else (patch.name,)  # of the skin's name
        place = next((names.index(name) for name in wanted if name in names), None)
        if place is None and len(ports) > 1:
            raise InputError(
                f"patch {patch.name!r} has no port, expected one of its name among "
                f"{', '.join(names)}: name the port after the patch"
            )
        port = ports[place or 0]
        highest = int(patch.channel.max())
        if highest >= port.channels:
            raise InputError(
                f"patch {patch.name!r} reads channel {highest}, expected channels below "
                f"{port.channels}: port {port.name!r} has no more; is this the layout of that "
                "skin, and are all its boards listed?"
            )
        rows.append(patch.channel + first[place or 0])
        starts.append(starts[-1] + len(patch))
        units.add(port.unit)
    if len(units) > 1:
        raise InputError(
            f"ports deliver {', '.join(sorted(units))}, expected one unit for all patches of an "
            "engine: run two engines"
        )
    channel = np.concatenate(rows).astype(np.int64)
    return Binding(channel, np.array(starts, np.int64), first[-1], units.pop())


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
    relative : bool
        Whether forces hold up to one factor only.
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
    relative: bool = False

    @cached_property
    def binding(self) -> Binding:
        """Channels of its taxels; raises InputError as `bind` does."""
        return bind(self.skin, self.ports)

    @classmethod
    def of(cls, settings: LiveSettings, ports: tuple[Port, ...]) -> "ModelConfig":
        """Of the settings of a live skin, whose sources deliver these ports."""
        values = {name: getattr(settings, name) for name in VALUES if name != "budget"}
        return cls(settings.skin, ports, budget=settings.time_to_answer, **values)

    def engine(
        self, noise_std: Floats, progress: Callable[[int, int], None] = lambda ready, patches: None
    ) -> Engine:
        """The engine, for the noise (L,) of all taxels in the quantity's unit.

        `progress` is called with how many patches are ready, of how many, while it is prepared.
        """
        return Engine(
            self.skin,
            self.layer,
            budget=self.budget,
            rungs=self.rungs,
            mechanics=self.mechanics,
            quantity=self.quantity,
            solver=self.solver,
            noise_std=self.noise_of(noise_std),
            relative=self.relative,
            progress=progress,
        )

    def noise_of(self, noise_std: Floats) -> dict[str, Floats]:
        """Noise of each patch's taxels by its name, of that of all taxels (L,)."""
        starts = np.cumsum([len(patch) for patch in self.skin])
        parts = np.split(noise_std, starts[:-1])
        return {patch.name: part for patch, part in zip(self.skin, parts, strict=True)}

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
            plain = {"relative": True, **json.loads(text)}  # older ones do not say it
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
LONGEST_SOLVER = ROOM - 1000  # characters: beside the tuning
FIELD = Field("configuration", "<u1", (ROOM,))


@dataclass(frozen=True)
class Configuration:
    """What of an engine's configuration may change while its ring stays.

    Attributes
    ----------
    generation : int
        Of the ring's writer.
    solver : Solver
    tuning : Tuning
    """

    generation: int
    solver: Solver
    tuning: Tuning

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON.

        Raises
        ------
        InputError
            For a solver that is not skinfield's own, or whose settings are too long for a ring.
        """
        solver = plain_from_value("solver", self.solver)
        if (length := len(json.dumps(solver))) > LONGEST_SOLVER:
            raise InputError(
                f"the solver's settings take {length} characters, expected {LONGEST_SOLVER} at most"
            )
        return {"generation": self.generation, "solver": solver, "tuning": self.tuning.as_dict()}

    @classmethod
    def from_dict(cls, plain: Mapping[str, Any]) -> "Configuration":
        """Undo `as_dict`; raises FileError for what it never gives."""
        try:
            solver = value_from_plain("solver", plain["solver"])
            if not hasattr(solver, "prepare"):
                raise FileError(f"the solver is {plain['solver']!r:.60}")
            return cls(int(plain["generation"]), solver, Tuning().changed(plain["tuning"]))
        except (KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
            raise FileError(
                f"the configuration {plain!r:.60} cannot be used: {error}; expected what an engine "
                "writes"
            ) from error


def configuration_of(reader: RingReader) -> Configuration | None:
    """What the engine that writes a ring goes by; None while that is being written."""
    plain = read_notes(reader.status_view[FIELD.name])
    return None if plain is None else Configuration.from_dict(plain)


def tuning_of(reader: RingReader) -> Tuning:
    """What is in force in the engine that writes a ring; what it begins with, before it says so."""
    known = configuration_of(reader)
    return Tuning() if known is None else known.tuning


def write_configuration(room: Octets, configuration: Configuration) -> None:
    """Into a ring's status, for `configuration_of`."""
    write_notes(room, configuration.as_dict())


class Models:
    """What follows from a pressure (deformation, uncertainty), prepared when it is first needed.

    Parameters
    ----------
    model_config : ModelConfig
    noise_std : (L,) array
        In the quantity's unit; 0 where it is not known: a typical one is taken.
    """

    def __init__(self, model_config: ModelConfig, noise_std: Floats) -> None:
        typical = model_config.quantity.typical_noise
        self.model_config = model_config
        self.noise_std: Floats = np.where(noise_std > 0, noise_std, typical)
        self._made: dict[str, Rungs] | None = None
        self._grids: dict[tuple[int, int], Grid] = {}
        self._noise: dict[tuple[int, int], Floats] = {}
        sizes = [len(patch) for patch in model_config.skin]
        self.starts = np.concatenate([[0], np.cumsum(sizes)]).tolist()

    @property
    def rungs(self) -> dict[str, Rungs]:
        """Grids, deformation and linear answer of each patch by name; some seconds, once.

        A reader has the contacts' rows, and needs no search of them: the uncertainty of a field is
        that of the linear answer it starts from.
        """
        if self._made is None:
            known, made = self.model_config, {}
            physics = known.mechanics, known.quantity, self._linear
            noise, typical = known.noise_of(self.noise_std), known.quantity.typical_noise
            for kind in kinds_of(known.skin, known.layer, noise, typical):
                patch = kind.patches[0]
                rungs = prepare_rungs(patch, kind.layer, known.rungs, *physics, kind.noise_std)
                made.update({patch.name: rungs for patch in kind.patches})
            self._made = made
        return self._made

    @property
    def _linear(self) -> Solver:
        """Solver whose linear answer tells how uncertain a field is."""
        solver = self.model_config.solver
        if isinstance(solver, Auto | ContactFit):
            solver = getattr(solver, "field", NonNegative())
        return solver.unconstrained() if isinstance(solver, NonNegative) else solver

    def solver_of(self, answer: int) -> str:
        """Name of the solver of a patch's `Answer`: of `Auto` the one that it chose."""
        solver = self.model_config.solver
        if answer == int(Answer.CONTACTS):
            solver = ContactFit()
        elif answer == int(Answer.LINEAR):
            solver = self._linear
        elif answer == int(Answer.FEASIBLE) and isinstance(solver, Auto):
            solver = solver.field
        return type(solver).__name__

    @property
    def prepared(self) -> bool:
        """Whether deformation and uncertainty cost no preparation any more."""
        return self._made is not None

    def moved(self, patch: int, nodes: int, pressure: Floats) -> Floats:
        """Displacement of a patch's nodes under a pressure (K,) Pa, (K, 3) m."""
        grid = self.grid(patch, nodes)
        return np.asarray(self._rung(patch, nodes).deformation.on(grid)(pressure))

    def noise_pressure(self, patch: int, nodes: int) -> Floats:
        """Standard deviation of the linear answer's pressure by noise alone, (K,) Pa."""
        key = patch, nodes
        if key not in self._noise:
            self._noise[key] = np.asarray(self._rung(patch, nodes).start.noise.std)
        return self._noise[key]

    def grid(self, patch: int, nodes: int) -> Grid:
        """Grid of a patch with so many nodes a side: one for each."""
        key = patch, nodes
        if key not in self._grids:
            self._grids[key] = Grid.square(self.model_config.skin[patch], nodes)
        return self._grids[key]

    def estimate(
        self,
        slot: CycleSlot,
        patch: int,
        latency: float,
        late: bool,
        notes: tuple[str, ...] = (),
    ) -> Estimate:
        """Estimate of a patch: pressure at once, the rest when it is asked for."""
        row, model_config = slot.patches[patch], self.model_config
        nodes = int(row["rung"]) or model_config.rungs[0]
        grid, answer = self.grid(patch, nodes), int(row["answer"])
        pressure = np.zeros(len(grid))
        if answer >= int(Answer.LINEAR):
            pressure[:] = slot.pressure[patch, : len(grid)]
        valid = slot.valid[self._taxels(patch)].astype(np.bool_)
        return Estimate.later(
            self._on_demand(slot, patch, grid, pressure, valid),
            grid=grid,
            pressure=pressure,
            valid=valid,
            latency=latency,
            stamp_ns=int(row["stamp_ns"]),
            gap=float(row["gap"]),
            iterations=int(row["iterations"]),
            deadline_met=not late,
            solver=self.solver_of(answer),
            notes=notes,
            is_field=answer != int(Answer.CONTACTS),
            relative=model_config.relative,
        )

    def _taxels(self, patch: int) -> slice:
        return slice(self.starts[patch], self.starts[patch + 1])

    def _on_demand(
        self, slot: CycleSlot, patch: int, grid: Grid, pressure: Floats, valid: NDArray[np.bool_]
    ) -> dict[str, Callable[[], Any]]:
        """What an estimate has beside its pressure, by name, each computed when it is called."""
        row, taxels = slot.patches[patch], self._taxels(patch)
        answer, gap, steps = int(row["answer"]), float(row["gap"]), int(row["iterations"])
        values = slot.values[taxels].astype(np.float64)
        linear = np.array(self.model_config.quantity.linearise(values, np.empty_like(values)))

        @cache
        def rest() -> dict[str, Callable[[], Any]]:  # for which a patch is prepared
            step = self._rung(patch, grid.shape[0])
            operator = step.operator
            name = type(operator.solver).__name__
            solution = Solution(pressure, linear, name, operator, gap, steps=steps)
            by_pressure = answer >= Answer.FEASIBLE or not valid.all()
            predict = (lambda: step.matrix @ pressure) if by_pressure else None
            parts = valid, grid, step.deformation.on(grid), None, None, predict, (values, 0.0)
            return details(solution, pressure, *parts)

        names = ("displacement", "pressure_std", "residual", "readings", "readings_std")
        later: dict[str, Callable[[], Any]] = {
            name: partial(lambda name: rest()[name](), name) for name in names
        }
        rows = slot.contacts[patch, : int(row["contacts"])].copy()
        later["contacts"] = partial(contacts_of_rows, rows, grid, pressure)
        if answer == int(Answer.CONTACTS):
            later["pressure_std"] = partial(pressure_std_of_rows, rows, grid, pressure)
        if valid.all():  # nothing to prepare for
            later["readings"] = lambda: values
            later["readings_std"] = lambda: self.noise_std[taxels].copy()
        later["traction"] = lambda: -pressure[:, None] * grid.normals
        return later

    def _rung(self, patch: int, nodes: int) -> Rung:
        rungs = self.rungs[self.model_config.skin[patch].name]
        return rungs.steps[self.model_config.rungs.index(nodes)]


LEAVE = 5.0  # s that the next process of an engine may take to go on with its ring


def model_config_of(reader: RingReader) -> ModelConfig:
    """What the answers of a live skin's ring follow from now.

    Raises
    ------
    FileError
        If it is no live skin's.
    """
    text = reader.description.get("model_config")
    if not isinstance(text, str):
        raise FileError(f"{reader.path} is no ring of a live skin, expected that of an engine")
    model_config, known = ModelConfig.from_json(text), configuration_of(reader)
    return model_config if known is None else replace(model_config, solver=known.solver)


def state_of(reader: RingReader) -> State:
    """What the engine is doing; FAILED if its process is gone, unless another is to go on."""
    state = reader.state
    if reader.alive or state == State.STOPPED:
        return state
    silence = (time.monotonic_ns() - reader.heartbeat_ns) * 1e-9
    return State.STARTING if state == State.STARTING and silence < LEAVE else State.FAILED
