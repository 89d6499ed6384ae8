"""Sources of readings: what each offers; drivers of one's own need nothing else."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Protocol, runtime_checkable

import numpy as np

from skinfield.errors import Ints, check_count
from skinfield.signal.blocks import Blocks


@dataclass(frozen=True)
class Port:
    """A run of channels that a source delivers under one name.

    Parameters
    ----------
    name : str
        By which patches are matched to it; a patch's `channel` counts within its port.
    channels : int
    unit : str
        Of its numbers, one of `skinfield.skin.reading.UNITS`.
    """

    name: str
    channels: int
    unit: str = "count"

    def __post_init__(self) -> None:
        check_count("channels", self.channels, 1, 1 << 24, "taxels and dummies of a port")


class Count(IntEnum):
    """What a stream counts, since it was opened; the index into `Stream.counters`."""

    RECEIVED = 0  # messages, datagrams or packets that were understood
    READINGS = 1  # blocks of counts made of them
    LOST = 2  # messages that are known to be missing, by their numbers or their counterpart
    OVERFLOWED = 3  # messages that the system's buffer dropped, where the system tells
    MALFORMED = 4  # that could not be understood
    FOREIGN = 5  # understood, but of another board or port than was asked for
    DUPLICATED = 6
    SWAPPED = 7  # that came after a later one
    REOPENED = 8  # times that the connection came back
    DOWN_NS = 9  # ns without a connection, in all
    BYTES = 10  # received


def counters() -> Ints:
    """Zeros for everything that is counted."""
    return np.zeros(len(Count), np.int64)


class Stream(Protocol):
    """An open source. Used from one thread, inside the cycle: no call may wait."""

    @property
    def ports(self) -> Sequence[Port]:
        """Their channels lie one after the other."""
        ...

    @property
    def counters(self) -> Ints:
        """Of `Count`, (len(Count),); written in place."""
        ...

    @property
    def up(self) -> bool:
        """Whether it is connected, as far as is known."""
        ...

    def poll(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        """Append everything that has arrived as blocks; never waits.

        What does not fit into `blocks` stays for the next call. A connection that broke is noticed
        here, and tried again at most every `RETRY` seconds, without waiting; that is no error.

        Parameters
        ----------
        blocks : Blocks
        channel : int
            That this stream's first channel has among all.
        now_ns : int, ns
            Since the epoch: the stamp of what carries no better one of the host's.

        Returns
        -------
        int
            Messages taken in.
        """
        ...

    def filenos(self) -> Sequence[int]:
        """File descriptors that become readable when something arrives; may change."""
        ...

    def close(self) -> None:
        """Tell the boards to stop where that is usual, and let go of everything."""
        ...


@runtime_checkable
class Lasting(Protocol):
    """A stream of boards that send until they are told to stop, and calibrate when told to start.

    What presses them then would become their rest. So those that send are let alone when an engine
    follows on another, or a stream on one that broke.
    """

    def resume(self) -> None:
        """Called right after opening: tell only boards that are silent."""
        ...

    def leave(self) -> None:
        """Called before closing: do not tell the boards to stop."""
        ...


class Source(Protocol):
    """Settings of a source; opening it is another step, in the process that reads it."""

    def open(self) -> Stream:
        """Open it.

        Raises
        ------
        InputError
            If the settings cannot be used: no such device class, package not installed, address
            not understood. A device that is only absent now is no error: the stream is not `up`.
        """
        ...


RETRY = 0.5  # s between attempts to get a broken connection back


@dataclass(eq=False)
class Retry:
    """When to try a broken connection again, and for how long it was down.

    Attributes
    ----------
    counters : (len(Count),) int64 array
        `DOWN_NS` and `REOPENED` are written here.
    down_since : int, ns
        0 while up.
    """

    counters: Ints
    down_since: int = 0
    _next: int = field(default=0)

    def broke(self, now_ns: int) -> None:
        """Note that the connection is gone."""
        if not self.down_since:
            self.down_since = now_ns
        self._next = now_ns + int(RETRY * 1e9)

    def due(self, now_ns: int) -> bool:
        """Whether it should be tried now; says so once every `RETRY` seconds."""
        if not self.down_since or now_ns < self._next:
            return False
        self._next = now_ns + int(RETRY * 1e9)
        return True

    def came_back(self, now_ns: int) -> None:
        """Note that the connection is there again."""
        self.counters[Count.DOWN_NS] += now_ns - self.down_since
        self.counters[Count.REOPENED] += 1
        self.down_since = 0
