"""Blocks of a live skin's recording, delivered as they came."""

from collections.abc import Sequence

import numpy as np

from skinfield.acquisition import Blocks, Count, Kind, Port, counters
from skinfield.acquisition.block import Words
from skinfield.errors import FileError, Ints
from skinfield.sources.live.table import ALL_AT_ONCE


class TapeStream:
    """See `skinfield.acquisition.Stream`.

    Blocks of sources, losses and tares are left out: they were of another time.

    Parameters
    ----------
    ports : sequence of Port
        None: one port of the name "skin", of as many channels as there are.
    tape : (W,) int64 array
        Blocks.
    speed : float
        Times real time. Infinite: at each poll, what came until a channel came again.
    loop : bool
    path : str
        Of the recording, for messages.

    Attributes
    ----------
    index : int
        Of this source among all.
    ended : bool
        Whether the last block was delivered, for good.

    Raises
    ------
    FileError
        If there are no blocks, or of more channels than the ports have.
    """

    def __init__(
        self, ports: Sequence[Port], tape: Words, speed: float, loop: bool, path: str
    ) -> None:
        from skinfield.sources.live.tape_kernel import play, survey

        self._play = play
        highest: Ints = np.zeros(1, np.int64)
        whole = survey(tape, highest)
        if whole < len(tape) or not highest[0]:
            raise FileError(
                f"{path}: byte {8 * whole} of {8 * len(tape)} of the readings is no block, "
                "expected blocks of readings: skinfield recover may help"
            )
        self.ports = tuple(ports) or (Port("skin", int(highest[0])),)
        channels = sum(port.channels for port in self.ports)
        if highest[0] > channels:
            raise FileError(
                f"{path}: has readings of channel {highest[0] - 1}, expected channels below "
                f"{channels}, of ports {', '.join(port.name for port in self.ports)}"
            )
        self.counters, self.index, self.up, self.ended = counters(), 0, True, False
        self._tape, self._speed, self._loop = tape, speed, loop
        self._at, self._start, self._now = 0, 0, 0
        self._taken: Ints = np.zeros(4, np.int64)
        self._copy(Blocks(64), 0, 0, -1)  # compiles

    @property
    def fault(self) -> str:
        """Why it is not up: at the end of a recording that is not begun anew."""
        return "" if self.up else "the recording is over"

    def poll(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        """Append the blocks whose time has come."""
        if not self._start:
            self._start = now_ns
        elif now_ns < self._now:  # the clock was set back
            self._start -= self._now - now_ns
        self._now = now_ns
        if self.ended:
            if self.up and int(blocks.end[0]) + 3 <= len(blocks.words):
                blocks.put_number(now_ns, self.index, Kind.SOURCE, 0)
                self.up = False
            return 0
        before = int(blocks.end[0])
        self._at = self._copy(blocks, channel, self._at, now_ns)
        taken = int(self._taken[0])
        self.counters[Count.RECEIVED] += taken
        self.counters[Count.READINGS] += self._taken[1]
        self.counters[Count.BYTES] += 8 * (int(blocks.end[0]) - before)
        if self._at == len(self._tape):
            self.ended = not self._loop
            self._at, self._start = 0, 0
        return taken

    def _copy(self, blocks: Blocks, channel: int, at: int, now_ns: int) -> int:
        step_by_step = self._speed == ALL_AT_ONCE
        self._taken[:] = 0
        return int(
            self._play(
                self._tape,
                at,
                now_ns,
                step_by_step,
                int(self._tape[0]),
                self._start,
                1.0 if step_by_step else self._speed,
                channel,
                blocks.words,
                blocks.end,
                self._taken,
            )
        )

    def filenos(self) -> Sequence[int]:
        """None: it is a matter of time."""
        return ()

    def close(self) -> None:
        """Deliver nothing more."""
        self.up, self.ended = False, True
