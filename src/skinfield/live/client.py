"""A running skin from another program: `with skinfield.connect() as live`."""

import time
from collections.abc import Iterator, Mapping
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from skinfield.acquisition.recorded import CycleFlag
from skinfield.engine.state import Answer
from skinfield.errors import InputError, check_positive
from skinfield.fields import Estimate
from skinfield.layout import Skin
from skinfield.live.control import order
from skinfield.live.estimates import Models
from skinfield.live.recipe import Recipe
from skinfield.live.slots import Head, Slot
from skinfield.ring import Ring, RingReader, State

FOREVER = 1e9  # s


class Stale(InputError):
    """No estimate that is young enough: nothing is ever returned in its place."""


class NotRunning(InputError):
    """No skin that runs under that name."""


class Snapshot(Mapping[str, Estimate]):
    """One cycle of a live skin: estimates by the names of the patches.

    Attributes
    ----------
    number : int
        Of the cycle.
    age : float, s
        Of the newest reading in it when it was fetched; infinite before the first.
    stamp_ns : int, ns
        Of that reading, since the epoch.
    fresh : bool
        Whether the cycle had a new reading; else it holds the answers of an earlier one.
    contacts : structured (N,) array
        On all patches, with `track`, `patch` (its number), `position` (m, in the patch's frame),
        `normal_force` (N), `force_std` (N), `place_std` (m), `area` (m²) and more; see its dtype.
    patches : structured (P,) array
        What is known of each patch: answer, rung, gap, stamp_ns, fresh, force ...
    """

    def __init__(self, slot: Slot, number: int, models: Models, wall_ns: int) -> None:
        self.number = number
        self.slot, self._models = slot, models
        self.patches: NDArray[Any] = slot.patches
        self.contacts: NDArray[Any] = slot.used_contacts()
        self.stamp_ns = int(slot.patches["stamp_ns"].max(initial=0))
        self.age = (wall_ns - self.stamp_ns) * 1e-9 if self.stamp_ns else float("inf")
        self.fresh = bool(slot.head[Head.FRESH])
        self._names = [patch.name for patch in models.recipe.skin]
        self._made: dict[str, Estimate] = {}

    def __getitem__(self, name: str) -> Estimate:
        if name not in self._names:
            raise InputError(f"no patch is named {name!r}, expected one of {self._names}")
        place = self._names.index(name)
        if self.patches["answer"][place] == int(Answer.MISSING):
            age = self.ages()[name]
            raise Stale(
                f"patch {name!r} has no answer: its newest reading is {age:.3g} s old; see "
                "`skinfield status`"
            )
        if name not in self._made:
            head = self.slot.head
            took = (int(head[Head.READY_NS]) - int(head[Head.WAKE_NS])) * 1e-9
            late = bool(int(head[Head.FLAGS]) & CycleFlag.LATE)
            self._made[name] = self._models.estimate(self.slot, place, took, late)
        return self._made[name]

    def __iter__(self) -> Iterator[str]:
        there = self.patches["answer"] != int(Answer.MISSING)
        return (name for name, known in zip(self._names, there, strict=True) if known)

    def __len__(self) -> int:
        return int((self.patches["answer"] != int(Answer.MISSING)).sum())

    def ages(self) -> dict[str, float]:
        """Age of each patch's newest reading, s; infinite where none ever came."""
        wall = self.stamp_ns + self.age * 1e9 if self.stamp_ns else 0.0
        stamps = self.patches["stamp_ns"].tolist()
        return {
            name: (wall - stamp) * 1e-9 if stamp else float("inf")
            for name, stamp in zip(self._names, stamps, strict=True)
        }

    @property
    def readings(self) -> NDArray[np.float32]:
        """Newest counts of all taxels, patch by patch, (L,)."""
        return self.slot.counts

    @property
    def force(self) -> float:
        """Sum of the normal forces of all contacts, N."""
        return float(self.patches["force"].sum())


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
        text = self.reader.description.get("recipe")
        if not isinstance(text, str):
            self.reader.close()
            raise NotRunning(f"ring {name!r} is of something else, expected that of a live skin")
        self.recipe = Recipe.from_json(text)
        self.skin: Skin = self.recipe.skin
        self._models: tuple[int, Models] | None = None
        self._slot = self.reader.slot()
        self._seen = 0

    @property
    def state(self) -> State:
        """What the engine is doing; FAILED if its process is gone."""
        state = self.reader.state
        gone = not self.reader.alive and state != State.STOPPED
        return State.FAILED if gone else state

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

    def _fetch(self) -> Snapshot | None:
        copied = self.reader.latest()
        if copied is None:
            return None
        self._seen = copied.number
        return Snapshot(Slot.of(copied.arrays), copied.number, self.models, time.time_ns())

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
        status = self.reader.status_view
        tares = int(status["tares"][0])
        if self._models is None or self._models[0] != tares:
            noise = status["noise_std"].copy()
            typical = self.recipe.quantity.typical_noise
            self._models = tares, Models(self.recipe, np.where(noise > 0, noise, typical))
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
            found = self._fetch()
            if found is None:
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
    there = [each.name for each in Ring.names() if each.alive]
    if len(there) != 1:
        what = f"{len(there)} run: {', '.join(there)}" if there else "none runs"
        raise NotRunning(
            f"no name was given and {what}, expected one skin: start `skinfield run`, or name it"
        )
    return there[0]
