"""Client of a running skin: `with skinfield.connect() as live`."""

import time
from collections.abc import Iterator, Mapping
from types import TracebackType
from typing import Any, Literal, Self

import numpy as np

from skinfield.errors import InputError, check_positive
from skinfield.loop.control import order
from skinfield.loop.fit_ring import is_fit
from skinfield.loop.model_config import ConfigWatch, ModelConfig, Models, state_of
from skinfield.loop.runtime_parameters import Focus, Limits, Tuning, tuning_of
from skinfield.loop.slots import Head, Slot
from skinfield.loop.snapshot import Snapshot as Snapshot
from skinfield.loop.snapshot import Stale as Stale
from skinfield.ring import Ring, RingReader, State
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
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.reader = RingReader(name)
        if "model_config" not in self.reader.description:
            self.reader.close()
            raise NotRunning(f"ring {name!r} is of something else, expected that of a live skin")
        self._config_watch = ConfigWatch(self.reader)
        self.skin: Skin = self.model_config.skin
        self._room = self.reader.slot()  # looked at before a cycle is worth a copy of its own
        self._looked = Slot.of(self._room.arrays)
        self._seen = 0

    @property
    def state(self) -> State:
        """What the engine is doing; FAILED if its process is gone."""
        return state_of(self.reader)

    @property
    def model_config(self) -> ModelConfig:
        """What the estimates follow from; its solver may change while the skin runs."""
        return self._config_watch.model_config

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
        end, found = time.monotonic() + timeout, None
        while True:
            found = self._fetch()
            good = found is not None and (max_age is None or found.age <= max_age)
            if found is not None and good:
                return found
            left = end - time.monotonic()
            if left <= 0:
                raise self._stale(found, max_age, timeout)
            self.reader.wait(self._seen, left)

    def _look(self) -> Slot | None:
        """The newest cycle, until the next look."""
        copied = self.reader.latest(self._room)
        if copied is None:
            return None
        self._seen = copied.number
        return self._looked

    def _own_copy(self) -> Snapshot:
        """What was looked at, in memory of its own."""
        own = self.reader.slot()
        np.copyto(own.octets, self._room.octets)
        return self._snapshot(Slot.of(own.arrays), self._seen)

    def _fetch(self) -> Snapshot | None:
        copied = self.reader.latest()
        if copied is None:
            return None
        self._seen = copied.number
        return self._snapshot(Slot.of(copied.arrays), copied.number)

    def _snapshot(self, slot: Slot, number: int) -> Snapshot:
        return Snapshot(slot, number, self._config_watch.models_of(slot), time.time_ns())

    def _stale(self, found: Snapshot | None, max_age: float | None, timeout: float) -> Stale:
        what = "no cycle" if found is None else f"the newest reading is {found.age:.3g} s old"
        wanted = "" if max_age is None else f", expected {max_age:g} s at most"
        return Stale(
            f"{what}{wanted}, after {timeout:g} s of waiting; the engine is "
            f"{self.state.name.lower()}: see `skinfield status {self.name}`"
        )

    @property
    def models(self) -> Models:
        """What turns pressure into deformation and uncertainty, for the calibration in force."""
        return self._config_watch.models

    def __iter__(self) -> Iterator[Snapshot]:
        """Every cycle with a new reading; a slow loop gets the newest and misses some."""
        while True:
            number = self.reader.wait(self._seen, FOREVER)
            if number <= self._seen:
                if self.reader.replaced():
                    raise NotRunning(f"{self.name!r} was started anew: connect again")
                continue
            looked = self._look()
            if looked is not None and looked.head[Head.FRESH]:
                yield self._own_copy()

    def next(self, timeout: float) -> Snapshot | None:
        """The newest cycle that was not fetched yet; None if none came in time."""
        number = self.reader.wait(self._seen, timeout)
        return self._fetch() if number > self._seen else None

    def next_answered(self, back: int = 20) -> Snapshot | None:
        """The newest cycle that was not fetched yet, at once; None if there is none.

        Of the last `back` cycles the newest with a new reading is given, if there is one: its times
        are those of an answer, where most cycles have nothing to do.
        """
        newest = self.reader.number
        if newest <= self._seen:
            return None
        for number in range(newest, max(self._seen, newest - back), -1):
            if self.reader.get(number, self._room) and self._looked.head[Head.FRESH]:
                self._seen = number
                return self._own_copy()
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
            looked = self._look()
            if looked is None or not looked.head[Head.CONTACTS]:
                continue
            contacts = looked.used_contacts()
            strong = contacts["normal_force"] >= force
            if patch is not None:
                strong &= contacts["patch"] == names.index(patch)
            if strong.any():
                return self._own_copy()
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
        given = zip(names, (resolution, deadline, threshold, smoothing), strict=True)
        changes: dict[str, Any] = {name: each for name, each in given if each is not None}
        if focus != "as it is":
            changes["focus"] = focus
        return retune(self.reader, changes, timeout)

    def close(self) -> None:
        """Let go of the ring; the skin runs on."""
        self.reader.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
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
    there = [each.name for each in Ring.names() if each.alive and not is_fit(each.name)]
    if len(there) != 1:
        what = f"{len(there)} run: {', '.join(there)}" if there else "none runs"
        raise NotRunning(
            f"no name was given and {what}, expected one skin: start `skinfield run`, or name it"
        )
    return there[0]


def retune(reader: RingReader, changes: Mapping[str, Any], timeout: float) -> Tuning:
    """Change settings by name; see `Live.tune`, whose errors these are."""
    limits = Limits.of(reader.description)
    wanted = limits.check(tuning_of(reader).changed(changes))
    if not changes:
        return wanted
    order(reader.name, "set", {"set": {name: _plain(getattr(wanted, name)) for name in changes}})
    end = time.monotonic() + timeout
    while timeout > 0 and not _is_in_force(found := tuning_of(reader), wanted, changes):
        if time.monotonic() > end:
            raise Stale(
                f"the engine did not take over {', '.join(changes)} within {timeout:g} s, and goes "
                f"by {found}: see `skinfield status {reader.name}`"
            )
        time.sleep(LOOK)
    return tuning_of(reader) if timeout > 0 else wanted


def _is_in_force(found: Tuning, wanted: Tuning, changes: Mapping[str, Any]) -> bool:
    """Whether all that was asked for is; another program may have changed the rest."""
    return all(getattr(found, name) == getattr(wanted, name) for name in changes)


def _plain(value: Any) -> Any:
    return value.as_dict() if isinstance(value, Focus) else value
