"""Where in a ring a recording begins: now, or some time ago, as far as the ring still has it."""

from typing import NamedTuple

import numpy as np

from skinfield.acquisition.block import Kind
from skinfield.acquisition.kernel import find_among
from skinfield.live.recorder_kernel import told_in
from skinfield.live.slots import Head
from skinfield.ring import RingReader

SPARE = 4  # a fourth of the slots, which the engine may write while the others are taken


class Place(NamedTuple):
    """The cycles after `number` are recorded, and the log from `position` on.

    Attributes
    ----------
    number : int
    position : int, bytes
        Of the log, with all readings of the first cycle behind it.
    wall_ns : int, ns
        When the first cycle was, since the epoch; 0 where there is none yet.
    """

    number: int
    position: int
    wall_ns: int = 0


def load() -> None:
    """Load what is compiled: the ring would not wait for it later."""
    told_in(b"")
    find_among(np.zeros(0, np.int64), 0, 0, 0, 0)


def place_now(reader: RingReader) -> Place:
    """Behind the newest cycle; of an engine that starts, before all that is there."""
    number = reader.number  # before the log's end is looked at: no cycle without its readings
    return Place(number, reader.log_end if number else 0)


def place_since(reader: RingReader, since_ns: int, now: Place) -> Place:
    """Before the last cycle that was not after a time, or as far back as the ring goes.

    Parameters
    ----------
    reader : RingReader
    since_ns : int, ns
        Since the epoch.
    now : Place

    Returns
    -------
    Place
        `now` if there was a new calibration in between, as the enclosed one holds from the first
        cycle on, or if readings are not there any more.
    """
    place = _found(reader, since_ns, now)
    data, lost = reader.log_reader(place.position).read()
    words = np.frombuffer(bytearray(data), "<i8", len(data) // 8)
    calibration = int(Kind.CALIBRATION)
    if lost or find_among(words, 0, len(words), calibration, calibration) >= 0:
        return now
    return place


def _found(reader: RingReader, since_ns: int, now: Place) -> Place:
    slot, found = reader.slot(), now
    head, wall_ns = slot["head"], 0
    for number in range(now.number, max(now.number - reader.slots + reader.slots // SPARE, 0), -1):
        if not reader.part(number, slot, ("head",)):
            break
        found = Place(number, int(head[Head.LOG_POSITION]), wall_ns)
        if wall_ns and wall_ns <= since_ns:
            break
        wall_ns = int(head[Head.WALL_NS])
    return found
