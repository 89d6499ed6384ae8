"""Faults that begin and end in time."""

import heapq
import itertools
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from skinfield.errors import InputError, Ints
from skinfield.layout import Skin
from skinfield.virtual.electronics import Converters, starts_of
from skinfield.virtual.faults import FOREVER, KINDS, Fault, numbers_of
from skinfield.virtual.hardware import Hardware
from skinfield.virtual.place import patch_index

MOST = 10_000  # to come


@dataclass
class FaultClock:
    """Begins and ends faults when their time comes.

    Parameters
    ----------
    skin : Skin
    hardware : Hardware

    Attributes
    ----------
    begun : Counter
        How many of each kind began.
    """

    skin: Skin
    hardware: Hardware
    begun: Counter[str] = field(default_factory=Counter)
    active: list[Fault] = field(default_factory=list)
    _queue: list[tuple[float, int, bool, Fault]] = field(default_factory=list)
    _order: "itertools.count[int]" = field(default_factory=itertools.count)

    def add(self, fault: Fault) -> None:
        """Take in a fault.

        Raises
        ------
        InputError
            If there is no such triangle, board, bus or taxel.
        """
        self.check(fault)
        if len(self._queue) >= MOST:
            raise InputError(f"{MOST} faults are to come, expected fewer: clear them first")
        heapq.heappush(self._queue, (fault.start, next(self._order), True, fault))

    def check(self, fault: Fault) -> None:
        """Raise InputError if what should fail is not there."""
        if KINDS[fault.kind] == "taxel":
            self._rows(fault.what)
        else:
            self.hardware.check(fault.kind, fault.what)

    @property
    def next_time(self) -> float:
        """When the next one begins or ends, s since the stream began."""
        return self._queue[0][0] if self._queue else FOREVER

    def advance(self, time: float, now_ns: int, warmth: float) -> None:
        """Begin and end what is due at a time, s since the stream began."""
        while self._queue and self._queue[0][0] <= time:
            _, _, begins, fault = heapq.heappop(self._queue)
            if begins:
                self._begin(fault, now_ns)
            elif fault in self.active:
                self._end(fault, now_ns, warmth)

    def clear(self, kind: str | None, now_ns: int, warmth: float) -> int:
        """End all faults of a kind, or all, and forget those to come; how many."""
        self._queue = [entry for entry in self._queue if kind is not None and entry[3].kind != kind]
        heapq.heapify(self._queue)
        ending = [fault for fault in self.active if kind in (None, fault.kind)]
        for fault in ending:
            self._end(fault, now_ns, warmth)
        return len(ending)

    def _begin(self, fault: Fault, now_ns: int) -> None:
        self.begun[fault.kind] += 1
        self.active.append(fault)
        if KINDS[fault.kind] == "taxel":
            self._converters.set_fault(fault.kind, self._rows(fault.what))
        else:
            self.hardware.begin(fault.kind, fault.what, now_ns)
        if fault.end != FOREVER:
            heapq.heappush(self._queue, (fault.end, next(self._order), False, fault))

    def _end(self, fault: Fault, now_ns: int, warmth: float) -> None:
        self.active.remove(fault)
        if KINDS[fault.kind] == "taxel":
            self._converters.clear_fault(fault.kind, self._rows(fault.what))
        else:
            self.hardware.end(fault.kind, fault.what, now_ns, warmth)

    @property
    def _converters(self) -> Converters:
        return self.hardware.converters

    def _rows(self, what: str) -> Ints:
        """Taxels of ``"7"``, ``"3-5"`` or ``"palm/7"``, among those of all patches."""
        name, slash, rest = what.rpartition("/")
        key: str | int = int(name) if name.isdecimal() and len(name) < 6 else name
        patch = patch_index(self.skin, key) if slash else 0
        rows = numbers_of(rest, len(self.skin.patches[patch]), "taxel")
        return np.array(rows, np.int64) + int(starts_of(self.skin)[patch])


def fault_to_start(fault: Fault, time: float) -> Fault:
    """The fault, at the earliest at `time`, which is now; for those that come by hand."""
    if fault.seconds <= 0.0:
        raise InputError(f"seconds is {fault.seconds!r}, expected more than 0")
    return Fault(fault.kind, fault.what, max(time, 0.0) + fault.start, fault.seconds)
