"""Takes what a fit beside the engine has found into a recording; there need not be a fit."""

import time

import numpy as np

from skinfield.acquisition.recorded_fit import FIT_HEAD, FitRecord, FitSizes
from skinfield.contacts.live import CONTACT
from skinfield.errors import InputError, SkinfieldError
from skinfield.live.fit_reader import FitReader
from skinfield.live.fit_ring import FORM, LAYOUT, PATCH, FitSlot, Fitted
from skinfield.live.recipe import Recipe
from skinfield.live.recorder_queue import Beside, Queue, Told
from skinfield.ring import RingReader

OLDEST_NS = 10_000_000_000  # of an answer that is taken: its own stamp is wrong beyond
NOTHING = np.zeros(0, np.uint32)


def fit_drain_of(reader: RingReader, queue: Queue) -> "FitDrain":
    """Of the fit beside the engine of a ring."""
    text = reader.description.get("recipe")
    if not isinstance(text, str):  # nobody can tell of which skin it is
        return FitDrain(reader.name, queue, (), 0)
    recipe = Recipe.from_json(text)
    names = tuple(patch.name for patch in recipe.skin)
    return FitDrain(reader.name, queue, names, max(recipe.rungs) ** 2)


class FitDrain:
    """Reads the answers of a fit's ring into a queue; whatever is wrong with it, that goes on.

    Parameters
    ----------
    name : str
        Of the live skin.
    queue : Queue
    patches : tuple of str
        Of the skin that is recorded: answers for another one are left out.
    nodes : int
        Of the finest grid of a patch.

    Attributes
    ----------
    answers : int
        That were taken.
    missed : int
        That were overwritten unread, damaged, or too much for the disk.
    """

    def __init__(self, name: str, queue: Queue, patches: tuple[str, ...], nodes: int) -> None:
        self._fit, self._queue = FitReader(name), queue
        self._patches, self._nodes = patches, nodes
        self._sizes = FitSizes(max(len(patches), 1), nodes, 1)
        self._before = b""  # what the file says last, without its head
        self.answers = self.missed = 0
        self._told_missed = 0

    def take(self) -> None:
        """Take all that is new."""
        try:
            if self._fit.names == self._patches:
                for number, found in self._fit.following():
                    self._take(number, found)
            else:
                self._end()
        except (SkinfieldError, ValueError, LookupError, OSError):  # of a ring that is damaged
            self.missed += 1
            self._fit.close()

    def _take(self, number: int, found: FitSlot | None) -> None:
        if found is None or found.sizes.nodes != self._nodes:
            self.missed += 1
            return
        try:
            record = record_of(found, number)
            data = LAYOUT.encode(record)
        except InputError:  # its numbers cannot be
            self.missed += 1
            return
        self._sizes = record.sizes
        self._put(data)

    def _end(self) -> None:
        """Say that there is no fit any more, if there was one that knew something."""
        if self._before:
            now, none = time.time_ns(), NOTHING
            rows = np.zeros(0, PATCH), np.zeros(0, CONTACT), np.zeros(0, FORM)
            field = none, np.zeros(0, np.float32)
            self._put(LAYOUT.encode(FitRecord(now, 0, self._sizes, none, none, *rows, *field)))

    def _put(self, data: bytes) -> None:
        """Hand it over unless it is what was said last; what is not taken is said with the next."""
        said = data[FIT_HEAD.size :]
        if said == self._before:
            return
        if self._queue.offer(Beside(time.time_ns(), data)):
            self._before = said
            self.answers += 1
        else:
            self.missed += 1

    def tell_missed(self) -> None:
        """Tell of the answers that were missed since the last call."""
        missed, self._told_missed = self.missed - self._told_missed, self.missed
        if missed:
            text = f"{missed} answers of the contact fit could not be recorded"
            self._queue.tell(Told(time.time_ns(), "fit_missed", text, {"answers": missed}))

    def close(self) -> None:
        """Let go of the fit's ring."""
        self._fit.close()


def record_of(slot: FitSlot, number: int) -> FitRecord:
    """What a recording keeps of an answer: of the patches that something touches, or may touch.

    Raises
    ------
    InputError
        If its counts of contacts are none.
    """
    now, told = time.time_ns(), int(slot.told_ns[0])
    sizes, states, counts = slot.sizes, slot.patches["state"], slot.patches["contacts"]
    if ((counts < 0) | (counts > sizes.rows)).any():
        raise InputError(f"a fit has {counts} contacts, expected 0 to {sizes.rows} of each patch")
    places = np.flatnonzero(states != int(Fitted.NOTHING))
    kept = np.arange(sizes.rows) < counts[places][:, None]
    fields = [
        np.flatnonzero(slot.pressure[place].view(np.uint32)) if done else NOTHING
        for place, done in zip(places, states[places] == int(Fitted.DONE), strict=True)
    ]
    pressure = [slot.pressure[place][nodes] for place, nodes in zip(places, fields, strict=True)]
    return FitRecord(
        told if 0 <= now - told <= OLDEST_NS else now,
        number,
        sizes,
        places.astype(np.uint32),
        np.array([len(nodes) for nodes in fields], np.uint32),
        slot.patches[places],
        slot.contacts[places][kept],
        slot.forms[places][kept],
        np.concatenate([NOTHING, *fields]).astype(np.uint32),
        np.concatenate([np.zeros(0, np.float32), *pressure]),
    )
