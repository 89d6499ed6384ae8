"""Log of a ring: one appends, each reader takes at its own pace."""

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError, check_count
from skinfield.ring.layout import LOG_END, LOG_RESERVED, MARK, MARKS
from skinfield.ring.system import Fence

Octets = NDArray[np.uint8]
_TRIES = 8  # to copy before the writer comes round


class Log:
    """The writer's side; `Ring.log` appends to it.

    Parameters
    ----------
    words : memoryview
        The file as 64-bit words.
    octets : (N,) uint8 array
        The log itself.
    shift : int
        `Header.mark_shift`.
    fence : callable, optional
        Where the processor needs one.

    Attributes
    ----------
    end : int, bytes
        Ever appended.
    """

    def __init__(self, words: memoryview, octets: Octets, shift: int, fence: Fence | None) -> None:
        self._words, self._octets, self._shift, self._fence = words, octets, shift, fence
        self.end = int(words[LOG_END])
        self._reserved = int(words[LOG_RESERVED])

    def append(self, octets: Octets, count: int) -> int:
        """Append a batch; returns `end`.

        Raises
        ------
        InputError
            If it has not so many bytes, or is longer than the log.
        """
        start, size = self.end, len(self._octets)
        if not 0 <= count <= min(len(octets), size):
            raise InputError(
                f"count is {count}, expected 0 to {min(len(octets), size)} bytes: a batch must fit "
                "into its array and into the log"
            )
        words, fence, end = self._words, self._fence, start + count
        if end > self._reserved:  # not so after a writer died in the middle of a longer batch
            words[LOG_RESERVED] = self._reserved = end
        if fence:
            fence()
        at = start & (size - 1)
        first = min(count, size - at)
        self._octets[at : at + first] = octets[:first]
        if first < count:
            self._octets[: count - first] = octets[first:count]
        if fence:
            fence()
        words[LOG_END] = self.end = end
        segment = end >> self._shift
        if segment != start >> self._shift:
            words[MARK + segment % MARKS] = end
        return end


class LogReader:
    """Takes what was appended to a ring's log, in whole batches; made by `RingReader.log_reader`.

    Attributes
    ----------
    position : int, bytes
        Of the next byte; always the end of a batch.
    lost : int, bytes
        Overwritten before they could be read, in all.
    """

    def __init__(
        self, words: memoryview, log: memoryview, shift: int, fence: Fence | None, position: int
    ) -> None:
        self.position, self.lost = position, 0
        self._words, self._log, self._shift, self._fence = words, log, shift, fence

    def read(self, max_bytes: int | None = None) -> tuple[bytes, int]:
        """Take what has come since the last call.

        Parameters
        ----------
        max_bytes : int, optional
            To take about so many at most. Batches are never cut, and where they end is known every
            64th of the log: so it is more if the next such place is further away.

        Returns
        -------
        bytes
            Whole batches, without a gap; empty if none came.
        int
            Bytes lost between those of the last call and these: the writer overtook.
        """
        most = len(self._log)
        if max_bytes is not None:
            check_count("max_bytes", max_bytes, 1, 1 << 62, "bytes to take at once")
            most = min(most, max_bytes)
        before = self.lost
        for _ in range(_TRIES):
            end = self._end()
            if self._overtaken(end):
                self._skip_to(self._mark(end))
            stop = self._stop(end, most)
            data = self._copied(stop)
            if self._fence:
                self._fence()
            if not self._overtaken(stop):  # meanwhile
                self.position = stop
                return data, self.lost - before
        self._skip_to(self._end())
        return b"", self.lost - before

    def _end(self) -> int:
        end = int(self._words[LOG_END])
        if self._fence:
            self._fence()
        return end

    def _overtaken(self, end: int) -> bool:
        """Whether what lies at `position` may have been written anew."""
        return max(self._words[LOG_RESERVED], end) - self.position > len(self._log)

    def _skip_to(self, position: int) -> None:
        self.lost += max(0, position - self.position)
        self.position = max(self.position, position)

    def _mark(self, end: int) -> int:
        """Find where to go on: an end of a batch with a quarter of the log to spare."""
        size = len(self._log)
        lowest = self._words[LOG_RESERVED] - size + size // 4
        first = (lowest >> self._shift) + 1
        for segment in range(first, first + MARKS):
            mark = self._words[MARK + segment % MARKS]
            if mark >> self._shift == segment and mark <= end:
                return int(mark)
        return end

    def _stop(self, end: int, most: int) -> int:
        """Where to stop reading: at the end, or at an end of a batch before."""
        if end - self.position <= most:
            return max(end, self.position)
        marks = [mark for mark in self._words[MARK : MARK + MARKS] if self.position < mark <= end]
        within = [mark for mark in marks if mark - self.position <= most]
        return max(within) if within else min(marks, default=end)

    def _copied(self, stop: int) -> bytes:
        size = len(self._log)
        count = min(stop - self.position, size)
        at = self.position & (size - 1)
        return b"".join((self._log[at : at + count], self._log[: max(0, at + count - size)]))
