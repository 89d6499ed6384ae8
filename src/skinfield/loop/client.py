"""Client of a running skin: `with skinfield.connect() as live`."""

import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Literal, Self

from skinfield.errors import InputError, check_positive
from skinfield.loop.control import order
from skinfield.loop.model_config import (
    Models,
    configuration_of,
    model_config_of,
    state_of,
    tuning_of,
)
from skinfield.loop.runtime_parameters import Focus, Limits, Tuning
from skinfield.loop.slots import CycleHead, CycleSlot
from skinfield.loop.snapshot import Snapshot as Snapshot
from skinfield.loop.snapshot import Stale as Stale
from skinfield.loop.status_text import read_notes
from skinfield.ring import Ring, RingReader, State
from skinfield.ring.files import sidecar
from skinfield.skin import Skin

FOREVER = 1e9  # s
LOOK = 0.005  # s between looks whether the engine took over


class NotRunning(InputError):
    """No skin that runs under that name."""


class Live:
    """A running skin; made by `connect`.

    Attributes
    ----------
    name : str
    skin : Skin
    reader : RingReader
        Of its ring, with everything that is published.
    model_config : ModelConfig
        What the newest estimates follow from; its solver may change while the skin runs.
    octets : (n,) uint8 array
        The slot of the cycle that was fetched last, as it lies in the ring.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.reader = RingReader(name)
        if "model_config" not in self.reader.description:
            self.reader.close()
            raise NotRunning(f"ring {name!r} is of something else, expected that of a live skin")
        self.model_config = model_config_of(self.reader)
        self.skin: Skin = self.model_config.skin
        self._generation = self.reader.generation
        self._models: tuple[int, Models] | None = None
        self._seen, self._room = 0, self.reader.slot()
        self._head, self.octets = self._room["head"], self._room.octets

    @property
    def state(self) -> State:
        """What the engine is doing; FAILED if its process is gone."""
        return state_of(self.reader)

    @property
    def tares(self) -> int:
        """Baselines that were taken so far."""
        return int(self.reader.status_view["tares"][0])

    def latest(self, max_age: float | None = None, timeout: float = 1.0) -> Snapshot:
        """The newest cycle.

        Parameters
        ----------
        max_age : float, s, optional
            Of the newest reading in it: an older one is waited away.
        timeout : float, s
            How long to wait for that.

        Raises
        ------
        Stale
            If none came in time. Old estimates are never returned for new ones.
        """
        if max_age is not None:
            check_positive("max_age", max_age, "seconds since the newest reading")
        end = time.monotonic() + timeout
        while True:
            found = self._fetch()
            if found is not None and (max_age is None or found.age <= max_age):
                return found
            left = end - time.monotonic()
            if left <= 0:
                break
            self.reader.wait(self._seen, left)
        what = "no cycle" if found is None else f"the newest reading is {found.age:.3g} s old"
        wanted = "" if max_age is None else f", expected {max_age:g} s at most"
        raise Stale(
            f"{what}{wanted}, after {timeout:g} s of waiting; the engine is "
            f"{self.state.name.lower()}: see `skinfield status {self.name}`"
        )

    def _fetch(self, number: int | None = None) -> Snapshot | None:
        """The newest cycle, or one by its number, if it is there."""
        copied = self.reader.latest() if number is None else self.reader.get(number)
        if copied is None:
            return None
        self._seen, self.octets = copied.number, copied.octets
        slot = CycleSlot.of(copied.arrays)
        self._follow(int(slot.head[CycleHead.GENERATION]))
        return Snapshot(slot, copied.number, self.models, time.time_ns(), self._notes)

    def _notes(self) -> dict[str, Any] | None:
        """What the engine says beside numbers; None while that is being written."""
        return read_notes(self.reader.status_view["notes"])

    def _follow(self, generation: int) -> None:
        """Look what the solver is now, if another process of the engine made a cycle."""
        if generation == self._generation:
            return
        known = configuration_of(self.reader)
        if known is None or known.generation != generation:
            return  # a cycle from before: what is known already was in force
        self._generation = generation
        if known.solver != self.model_config.solver:
            self.model_config = replace(self.model_config, solver=known.solver)
            self._models = None

    @property
    def models(self) -> Models:
        """What turns pressure into deformation and uncertainty, for the calibration in force."""
        tares = self.tares
        if self._models is None or self._models[0] != tares:
            noise_std = self.reader.status_view["noise_std"]
            self._models = tares, Models(self.model_config, noise_std)
        return self._models[1]

    def __iter__(self) -> Iterator[Snapshot]:
        """Every cycle with a new reading; a slow loop gets the newest and misses some."""
        while True:
            number = self.reader.wait(self._seen, FOREVER)
            if number <= self._seen:
                if self.reader.replaced():
                    raise NotRunning(f"{self.name!r} was started anew: connect again")
                continue
            found = self._fetch()
            if found is not None and found.fresh:
                yield found

    def next(self, timeout: float) -> Snapshot | None:
        """The newest cycle that was not fetched yet; None if none came in time."""
        number = self.reader.wait(self._seen, timeout)
        return self._fetch() if number > self._seen else None

    def next_answered(self, back: int = 20) -> Snapshot | None:
        """The newest cycle that was not fetched yet, at once; None if there is none.

        Of the last `back` cycles the newest with a new reading is given, if there is one: its times
        are those of an answer, where most cycles have nothing to do.
        """
        newest, seen = self.reader.number, self._seen
        if newest <= seen:
            return None
        for number in range(newest, max(seen, newest - back), -1):
            there = self.reader.part(number, self._room, ("head",))
            if there and self._head[CycleHead.FRESH] and (found := self._fetch(number)) is not None:
                return found
        return self._fetch()

    def wait_contact(
        self, timeout: float | None = None, *, patch: str | None = None, force: float = 0.0
    ) -> Snapshot | None:
        """Wait until something touches the skin.

        Parameters
        ----------
        timeout : float, s, optional
            Default for ever.
        patch : str, optional
            On this one only.
        force : float, N
            At least.

        Returns
        -------
        Snapshot or None
            None if nothing touched it in time.
        """
        names = [each.name for each in self.skin]
        if patch is not None and patch not in names:
            raise InputError(f"patch is {patch!r}, expected one of {', '.join(names)}")
        end = time.monotonic() + (FOREVER if timeout is None else timeout)
        while (left := end - time.monotonic()) > 0:
            if self.reader.wait(self._seen, min(left, 0.5)) <= self._seen:
                continue
            if (found := self._fetch()) is None:
                continue
            strong = found.contacts["normal_force"] >= force
            if patch is not None:
                strong &= found.contacts["patch"] == names.index(patch)
            if strong.any():
                return found
        return None

    def tare(self) -> None:
        """Take the untouched skin's readings of the next second as zero."""
        order(self.name, "tare")

    @property
    def limits(self) -> Limits:
        """What the engine can be tuned to."""
        return Limits.of(self.reader.description)

    @property
    def tuning(self) -> Tuning:
        """What is in force."""
        return tuning_of(self.reader)

    def tune(
        self,
        *,
        resolution: int | Literal["auto"] | None = None,
        deadline: float | None = None,
        threshold: float | None = None,
        smoothing: float | None = None,
        focus: Focus | Literal["as it is"] | None = "as it is",
        timeout: float = 5.0,
    ) -> Tuning:
        """Change what is named while the engine goes on; see `Tuning`.

        Parameters
        ----------
        resolution, deadline, threshold, smoothing
            None leaves each as it is.
        focus : Focus or None
            None ends it.
        timeout : float, s
            How long to wait until it is in force; 0: what was asked for is returned at once.

        Raises
        ------
        InputError
            For what the engine cannot be tuned to, or if none listens.
        Stale
            If it is not in force in time.
        """
        names = ("resolution", "deadline", "threshold", "smoothing")
        values = zip(names, (resolution, deadline, threshold, smoothing), strict=True)
        changes: dict[str, Any] = {name: each for name, each in values if each is not None}
        if focus != "as it is":
            changes["focus"] = focus
        wanted = self.limits.check(self.tuning.changed(changes))
        if not changes:
            return wanted
        plain = wanted.as_dict()
        order(self.name, "set", {"set": {name: plain[name] for name in changes}})
        end = time.monotonic() + timeout
        while timeout > 0:
            found = self.tuning
            if all(getattr(found, name) == getattr(wanted, name) for name in changes):
                return found  # another program may have changed the rest
            if time.monotonic() > end:
                raise Stale(
                    f"the engine did not take over {', '.join(changes)} within {timeout:g} s, and "
                    f"goes by {found}: see `skinfield status {self.name}`"
                )
            time.sleep(LOOK)
        return wanted

    def close(self) -> None:
        """Let go of the ring; the skin runs on."""
        self.reader.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def connect(name: str | None = None, *, timeout: float = 0.0) -> Live:
    """Connect to a running skin.

    Parameters
    ----------
    name : str, optional
        As `skinfield run --name` has it; default the only one that runs.
    timeout : float, s
        How long to wait for it to come.

    Raises
    ------
    NotRunning
        If there is none of that name, or several and no name was given.
    """
    end = time.monotonic() + timeout
    while True:
        try:
            return Live(chosen(name))
        except InputError as error:
            if time.monotonic() >= end:
                raise NotRunning(str(error)) from error
            time.sleep(0.05)


def chosen(name: str | None) -> str:
    """Name of the skin that is meant: the given one, or the only one that runs."""
    if name is not None:
        return name
    there = [each.name for each in Ring.names() if each.alive]
    if len(there) != 1:
        what = f"{len(there)} run: {', '.join(there)}" if there else "none runs"
        raise NotRunning(
            f"no name was given and {what}, expected one skin: start `skinfield run`, or name it"
        )
    return there[0]


def check_free(name: str) -> None:
    """Raise InputError where a running skin has a name, or none can have it."""
    sidecar(name, "supervisor")
    for each in Ring.names():
        if each.name == name and each.alive:
            raise InputError(
                f"a skin named {name!r} runs already, as process {each.pid}, expected another "
                "--name; `skinfield status` shows it"
            )
