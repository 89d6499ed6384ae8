"""Readings of a table, delivered as a source would: when their time has come."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.acquisition import Blocks, Count, Kind, Port, Status, counters
from skinfield.acquisition.block import LONGEST, Octets
from skinfield.errors import Floats, InputError, Ints, check_shape

LONGEST_NS = 1 << 61  # that stamps can be added to
ALL_AT_ONCE = float("inf")  # speed at which each poll brings the next reading


def narrowest(counts: Floats) -> tuple[Kind, NDArray[Any]]:
    """The kind of block that holds all counts without loss, or float32, and the counts so.

    Numbers beyond 16 bits, or with a fraction, are rounded to the 24 bits of a float32.
    """
    finite = np.isfinite(counts).all()
    if finite and (counts == np.rint(counts)).all() and (counts >= 0).all():
        if (counts <= 0xFF).all():
            return Kind.BYTES, counts.astype("<u1")
        if (counts <= 0xFFFF).all():
            return Kind.SHORTS, counts.astype("<u2")
    return Kind.FLOATS, counts.astype("<f4")


class TableStream:
    """See `skinfield.acquisition.Stream`.

    Parameters
    ----------
    ports : sequence of Port
    counts : (T, C) array
        Over the channels of all ports.
    after_ns : (T,) int64 array, ns
        Of each reading, since the first; not decreasing.
    speed : float
        Times real time. Infinite: the next reading at each poll.
    loop : bool
        Whether it begins anew behind the last.
    pause_ns : int, ns
        From the last reading to the first of the next round.

    Attributes
    ----------
    index : int
        Of this source among all.
    ended : bool
        Whether the last reading was delivered, for good.
    """

    def __init__(
        self,
        ports: Sequence[Port],
        counts: Floats,
        after_ns: Ints,
        speed: float = 1.0,
        loop: bool = False,
        pause_ns: int = 0,
    ) -> None:
        from skinfield.acquisition.kernel import put_octets

        self._put = put_octets
        self.ports = tuple(ports)
        width = sum(port.channels for port in self.ports)
        check_shape("counts", counts, (None, width), "a column per channel of the ports")
        check_shape("after_ns", after_ns, (len(counts),), "a time per reading")
        if not len(counts) or (np.diff(after_ns) < 0).any() or after_ns[0] != 0:
            raise InputError(
                f"after_ns is {after_ns}, expected one reading or more, the first at 0, none "
                "before its predecessor"
            )
        self.counters, self.index, self.up, self.ended = counters(), 0, True, False
        self._kind, table = narrowest(counts)
        self._octets: Octets = np.ascontiguousarray(table).reshape(-1).view(np.uint8)
        self._width, self._item = width, table.dtype.itemsize
        self._after = (
            after_ns if speed == ALL_AT_ONCE else np.rint(after_ns / speed).astype(np.int64)
        )
        self._step_by_step = speed == ALL_AT_ONCE
        self._loop, self._pause = loop, round(pause_ns / speed)
        self._start = 0  # ns, of the round; 0 before the first poll
        self._next = self._column = self._now = 0

    @property
    def fault(self) -> str:
        """Why it is not up: at the end of a table that is not begun anew."""
        return "" if self.up else "the recording is over"

    def poll(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        """Append the readings whose time has come."""
        if not self._start:
            self._start = now_ns
        elif now_ns < self._now:  # the clock was set back
            self._start -= self._now - now_ns
        self._now, taken = now_ns, 0
        while not self.ended:
            stamp = now_ns if self._step_by_step else self._start + int(self._after[self._next])
            if stamp > now_ns or not self._append(blocks, channel, stamp):
                break
            taken += 1
            self._advance(now_ns)
            if self._step_by_step or taken == len(self._after):
                break
        if self.ended and self.up:
            self._tell(blocks, now_ns)
        return taken

    def _append(self, blocks: Blocks, channel: int, stamp_ns: int) -> bool:
        """Append one reading, in as many blocks as it takes; False if it did not fit."""
        while self._column < self._width:
            count = min(LONGEST, self._width - self._column)
            at = (self._next * self._width + self._column) * self._item
            if not self._put(
                blocks.words,
                blocks.octets,
                blocks.end,
                stamp_ns,
                channel + self._column,
                int(self._kind),
                int(Status.OK),
                self._octets,
                at,
                count,
            ):
                return False
            self._column += count
            self.counters[Count.READINGS] += 1
        self._column = 0
        self.counters[Count.RECEIVED] += 1
        self.counters[Count.BYTES] += self._width * self._item
        return True

    def _advance(self, now_ns: int) -> None:
        self._next += 1
        if self._next == len(self._after):
            if not self._loop:
                self.ended = True
            elif not self._step_by_step:
                self._start += int(self._after[-1]) + self._pause
                if now_ns - self._start > int(self._after[-1]) + self._pause:
                    self._start = now_ns  # nobody polled for a whole round: it is not made up for
            self._next = 0

    def _tell(self, blocks: Blocks, now_ns: int) -> None:
        if int(blocks.end[0]) + 3 <= len(blocks.words):
            blocks.put_number(now_ns, self.index, Kind.SOURCE, 0)
            self.up = False

    def filenos(self) -> Sequence[int]:
        """None: it is a matter of time."""
        return ()

    def close(self) -> None:
        """Deliver nothing more."""
        self.up, self.ended = False, True
