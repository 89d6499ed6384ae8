"""Reading the log of a ring, each reader at its own pace."""

from skinfield.errors import check_count
from skinfield.ring.layout import LOG_END, LOG_RESERVED, MARK, MARKS
from skinfield.ring.system import Fence

_TRIES = 8  # to copy before the writer comes round


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
