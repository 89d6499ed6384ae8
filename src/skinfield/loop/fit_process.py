"""Fit process beside a live skin's engine: python -m skinfield.loop.fit_process NAME.

It reads the ring like any other reader, at low priority, so that the engine never waits for it, and
publishes better contacts into a ring of its own.
"""

import argparse
import contextlib
import itertools
import os
import signal
import sys
import threading
import time
from typing import NoReturn, Self

import numpy as np

from skinfield.errors import InputError, SkinfieldError
from skinfield.loop.fit_ring import FitSlot, Fitted, create_fit_ring, write_engine
from skinfield.loop.fit_worker import (
    FIRST,
    FitTracks,
    PatchFit,
    Shape,
    fitter_of,
    rounding_of,
    shape_of,
)
from skinfield.loop.model_config import ModelConfig, tuning_of
from skinfield.loop.process_supervisor import end_with
from skinfield.loop.slots import CycleHead, CycleSlot
from skinfield.loop.status_text import write_notes
from skinfield.reconstruct.engine.state import Answer
from skinfield.ring import RingReader
from skinfield.signal import Convention
from skinfield.solve.atoms.fitter import ContactFitter

EAGER = 6  # shapes that are prepared before anything touches them; others when something does


class FitShapes:
    """One prepared fit for each shape that patches of a skin have.

    Preparing takes seconds for the first one and less for the others, which share its tables, and
    the first time on a machine ten more, as all is compiled then. It happens in a thread of its
    own, of what is touched first.

    Attributes
    ----------
    failed : str
        Why the last shape that could not be prepared could not; empty if all could.
    """

    def __init__(self, model_config: ModelConfig) -> None:
        self._model_config = model_config
        self._shape_of = [shape_of(patch) for patch in model_config.skin]
        self._place_of = {shape: n for n, shape in reversed(list(enumerate(self._shape_of)))}
        self._there: dict[Shape, ContactFitter | None] = {}
        self._waiting: list[Shape] = list(dict.fromkeys(self._shape_of))[:EAGER]
        self._thread: threading.Thread | None = None
        self.failed = ""
        self._go_on()

    @property
    def busy(self) -> bool:
        """Whether something is being prepared."""
        return self._thread is not None and self._thread.is_alive()

    def get(self, place: int, touched: bool) -> ContactFitter | None:
        """The fit for a patch by its number; None while there is none, or if there can be none.

        Parameters
        ----------
        place : int
        touched : bool
            Whether it is wanted now.
        """
        shape = self._shape_of[place]
        if touched and shape not in self._there:
            if self._waiting[:1] != [shape]:
                self._waiting.insert(0, shape)  # perhaps a second time: then it is there by then
            self._go_on()
        return self._there.get(shape)

    def _go_on(self) -> None:
        if self._waiting and not self.busy:
            self._thread = threading.Thread(target=self._work, name="preparing", daemon=True)
            self._thread.start()

    def _work(self) -> None:
        while self._waiting:
            shape = self._waiting.pop(0)
            if shape in self._there:
                continue
            patch = self._model_config.skin[self._place_of[shape]]
            try:
                self._there[shape] = fitter_of(patch, self._model_config)
            except SkinfieldError as error:
                self._there[shape] = None
                self.failed = f"{patch.name}: {error}"


FIELDS_NEEDED = ("patches", "contacts", "values", "valid")
MARGIN = 4  # slots that the engine may write while one is looked at
LONGEST = 256  # cycles that are looked back
ROWS = 8  # contacts of a patch, at most
BUSY_NS = 100_000_000  # of fits in one look, after which the other patches wait for the next


class SkinFit:
    """Contacts of all patches of a live skin that something touches.

    Parameters
    ----------
    name : str
        Of the live skin.
    reader : RingReader
        Of its ring; stays the caller's.

    Raises
    ------
    InputError
        If another process fits this skin already.
    """

    def __init__(self, name: str, reader: RingReader) -> None:
        self._reader = reader
        self.model_config = ModelConfig.from_json(str(reader.description["model_config"]))
        skin = self.model_config.skin
        nodes = max(self.model_config.rungs) ** 2
        self.ring = create_fit_ring(name, [patch.name for patch in skin], nodes, ROWS)
        numbers = itertools.count(FIRST)
        self.patches = [PatchFit(n, patch, FitTracks(numbers)) for n, patch in enumerate(skin)]
        self._starts = np.cumsum([0, *(len(patch) for patch in skin)]).tolist()
        self._master = FitSlot.empty(len(skin), nodes, ROWS)
        self._room = reader.slot()
        self._slot = CycleSlot.of(self._room.arrays)
        self._seen = max(reader.number - 1, 0)
        self._tares = -1
        self._shapes = FitShapes(self.model_config)
        self._told = ""
        self._turn = 0

    def look(self) -> bool:
        """Take in what is new, fit what is touched, and publish; whether anything is new."""
        self._take_in()
        if not self._known():
            return False
        count, began, changed = len(self.patches), time.monotonic_ns(), False
        if clips_at_rest(self.model_config.board):  # all is left to the engine
            changed = any(each.state != Fitted.UNHELPFUL for each in self.patches)
            self._master.patches["state"] = int(Fitted.UNHELPFUL)
            for each in self.patches:
                each.state = Fitted.UNHELPFUL
            count = 0
        for step in range(count):
            place = (self._turn + step) % count
            changed |= self._update(place)
            if time.monotonic_ns() - began > BUSY_NS:
                self._turn = place + 1
                break
        if changed:
            slot = FitSlot.of(self.ring.begin())
            slot.copy_from(self._master)
            slot.told_ns[0] = time.time_ns()  # last: a replay shows it from then on
            self.ring.publish()
        return changed

    def _take_in(self) -> None:
        """Hand the readings of all cycles that are new to their patches."""
        reader, slot = self._reader, self._slot
        newest = reader.number
        if newest < self._seen:
            self._seen = 0
        most = min(reader.slots - MARGIN, LONGEST)
        for number in range(max(self._seen, newest - most) + 1, newest + 1):
            if not reader.part(number, self._room, ("head",)) or not slot.head[CycleHead.FRESH]:
                continue
            if not reader.part(number, self._room, FIELDS_NEEDED):
                continue
            for place in np.flatnonzero(slot.patches["fresh"]).tolist():
                its = slice(self._starts[place], self._starts[place + 1])
                stamp = int(slot.patches["stamp_ns"][place])
                self.patches[place].stationary.take(slot.values[its], slot.valid[its], stamp)
        self._seen = newest

    def _known(self) -> bool:
        """Whether there is a baseline; what follows from a new one is made anew."""
        status = self._reader.status_view
        tares = int(status["tares"][0])
        if tares != self._tares and tares > 0:
            noise, table = status["noise_std"].copy(), status["calibration"].copy()
            typical = self.model_config.quantity.typical_noise
            noise = np.where(noise > 0, noise, typical)
            counted = all(port.unit == "count" for port in self.model_config.ports)
            rounding = rounding_of(table, noise) if counted else np.zeros_like(noise)
            for each, a, b in zip(self.patches, self._starts, self._starts[1:], strict=False):
                each.calibrate(noise[a:b], rounding[a:b])
            self._tares = tares
        return tares > 0

    def _update(self, place: int) -> bool:
        """Fit one patch, if it is its time."""
        patch, row = self.patches[place], self._slot.patches[place]
        contacts = self._slot.contacts[place][: int(row["contacts"])]
        touched = int(row["answer"]) >= int(Answer.LINEAR) or int(row["contacts"]) > 0
        if not patch.ready:
            fitter = self._shapes.get(place, touched)
            if fitter is None:
                return False
            patch.take_fitter(fitter)
        status = self.ring.status
        if not patch.update(contacts, touched):
            return False
        status["fits"][0] += 1
        status["unhelpful"][0] += patch.state == Fitted.UNHELPFUL
        self._write(place, patch, touched)
        write_engine(self._master.patches[place], contacts)
        return True

    def _write(self, place: int, patch: PatchFit, touched: bool) -> None:
        master, told = self._master, self._master.patches[place]
        threshold = tuning_of(self._reader).threshold  # N, as the engine has it now
        kept = np.flatnonzero(patch.rows["normal_force"] >= threshold)[:ROWS]
        told["state"], told["contacts"] = int(patch.state), len(kept)
        told["touched"], told["cycle"] = touched, self._seen
        told["took_ns"] = patch.took_ns
        told["readings"] = 0 if patch.mean is None else patch.mean.readings
        told["stamp_ns"] = patch.stationary.stamp_ns
        told["force"] = patch.rows["normal_force"][kept].sum()
        master.contacts[place][: len(kept)] = patch.rows[kept]
        master.forms[place][: len(kept)] = patch.forms[kept]
        if patch.pressure is not None:
            master.pressure[place] = patch.pressure

    def tell(self) -> None:
        """Say in the ring's status what is done now."""
        self.ring.heartbeat(time.monotonic_ns())
        self.ring.status["cpu_ns"][0] = time.process_time_ns()
        names = [patch.name for patch in self.model_config.skin]
        states = zip(names, self.patches, strict=True)
        unhelpful = [name for name, each in states if each.state == Fitted.UNHELPFUL]
        notes = {
            "phase": "preparing" if self._shapes.busy else "ready",
            "left_to_engine": unhelpful,
            "failed": self._shapes.failed,
            "tares": self._tares,
        }
        if str(notes) != self._told:
            self._told = str(notes)
            write_notes(self.ring.status["notes"], notes)

    def close(self) -> None:
        """End, and take the ring away."""
        with contextlib.suppress(OSError):
            self.ring.unlink()
        self.ring.close()

    def __enter__(self) -> Self:
        self.tell()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def clips_at_rest(board: Convention | None) -> bool:
    """Whether a board sends nothing of what a taxel reads below its rest, as CySkin's does.

    Then a fit finds too small a force, as a light touch with a point makes the taxel below it read
    as much: only that those beside it read less than nothing tells a finger from that.
    """
    return board is not None and board.rest == (
        board.lowest if board.direction > 0 else board.highest
    )


NICE = 2  # behind the engine and the page, and not starved by them
STEP = 0.02  # s from one look at the skin to the next
PAUSE = 0.2  # s between looks for a skin that is not there


def serve(name: str) -> NoReturn:
    """Fit what touches a skin, whenever its ring is there."""
    while True:
        try:
            reader = RingReader(name)
        except InputError:
            time.sleep(PAUSE)
            continue
        with reader:
            if reader.alive and "skinfield_live" in reader.description:
                with SkinFit(name, reader) as fit:
                    _follow(fit, reader)
            else:
                time.sleep(PAUSE)


def _follow(fit: SkinFit, reader: RingReader) -> None:
    """Look again and again, until the ring belongs to another skin."""
    looked = time.monotonic()
    while True:
        due = time.monotonic() + STEP
        fit.look()
        now = time.monotonic()
        if now - looked > PAUSE:
            looked = now
            if reader.replaced():
                return
            fit.tell()
        time.sleep(max(due - time.monotonic(), 0.001))


def _end(*_: object) -> NoReturn:
    raise SystemExit(0)


def main() -> int:
    """Fit until told to end, or until whoever started this process is gone."""
    parser = argparse.ArgumentParser(description="Fits contacts beside a live skin's engine.")
    parser.add_argument("name", help="of the live skin")
    parser.add_argument("--parent", type=int, help="process to end with")
    given = parser.parse_args()
    signal.signal(signal.SIGTERM, _end)
    signal.signal(signal.SIGINT, _end)
    if given.parent is not None:
        end_with(given.parent)
    with contextlib.suppress(OSError):
        os.nice(NICE)
    try:
        serve(given.name)
    except SkinfieldError as error:
        sys.stderr.write(f"the fit of {given.name} ended: {error}\n")
        return 1


if __name__ == "__main__":
    try:
        code = main()
    except SystemExit as end:
        code = int(end.code or 0)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # the ring is closed; a thread that still compiles would abort an ordinary end
