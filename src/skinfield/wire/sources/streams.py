"""Streams over connections that come and go, and their readings one by one."""

import select
from collections.abc import Sequence
from time import monotonic, monotonic_ns, time_ns

import numpy as np

from skinfield.errors import Ints, SkinfieldError, check_range
from skinfield.signal import Blocks, Channels, Count, Kind, Port, Retry, Stream, counters
from skinfield.signal.block import UNUSABLE
from skinfield.skin.reading import Reading
from skinfield.wire.links import BreakingLink

SOURCE_WORDS = 3  # of a block that tells that a source went down or came up


class LinkedStream:
    """What all streams over links share: see `skinfield.signal.Stream`.

    A stream is up while all its links are. When it goes down, and when it comes back, it appends a
    block of `Kind.SOURCE`, once. Each link that is down is opened again every `RETRY` seconds.

    Parameters
    ----------
    ports : sequence of Port
    links : sequence of BreakingLink

    Attributes
    ----------
    index : int
        Of this source among all, as its blocks of `Kind.SOURCE` say it; whoever reads several
        sources sets it.
    """

    def __init__(self, ports: Sequence[Port], links: Sequence[BreakingLink]) -> None:
        self.ports = tuple(ports)
        self.counters: Ints = counters()
        self.index = 0
        self.closed = False
        self._links = tuple(links)
        self._retries = tuple(Retry(self.counters) for _ in self._links)
        self._reported_up = True

    @property
    def up(self) -> bool:
        """Whether all links are."""
        return not self.closed and all(link.up for link in self._links)

    @property
    def fault(self) -> str:
        """Why it is not up, in words; empty while it is."""
        return "; ".join(link.fault for link in self._links if not link.up)

    @property
    def notes(self) -> tuple[str, ...]:
        """What should be known of it beside that, in sentences."""
        return tuple(note for link in self._links if (note := getattr(link, "note", "")))

    def poll(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        """Append what has arrived; see `skinfield.signal.Stream`."""
        if self.closed:
            return 0
        before, up = int(self.counters[Count.RECEIVED]), True
        self._take(blocks, channel, now_ns)
        for place, link in enumerate(self._links):
            if not link.up or self._retries[place].down_since:
                up = self._follow(place, link, now_ns) and up
        if up != self._reported_up:
            self._report(up, blocks, now_ns)
        return int(self.counters[Count.RECEIVED]) - before

    def _follow(self, place: int, link: BreakingLink, now_ns: int) -> bool:
        """Note that a link broke, try it again, note that it is back; whether it is up."""
        retry, clock_ns = self._retries[place], monotonic_ns()  # that nobody sets back
        if not link.up and not retry.down_since:
            retry.broke(clock_ns)
            self._went_down(place)
        elif not link.up and retry.due(clock_ns):
            link.reopen()
        if link.up and retry.down_since:
            retry.came_back(clock_ns)
            self._came_back(place, now_ns)
        return link.up

    def _report(self, up: bool, blocks: Blocks, now_ns: int) -> None:
        if int(blocks.end[0]) + SOURCE_WORDS <= len(blocks.words):  # else at the next call
            blocks.put_number(now_ns, self.index, Kind.SOURCE, int(up))
            self._reported_up = up

    def _take(self, blocks: Blocks, channel: int, now_ns: int) -> None:
        """Append what has arrived, from all links, and count it."""
        raise NotImplementedError

    def _went_down(self, place: int) -> None:
        """Forget what was half received over a link."""

    def _came_back(self, place: int, now_ns: int) -> None:
        """Begin anew over a link."""

    def _stop(self) -> None:
        """Tell the boards that it ends."""

    def filenos(self) -> Sequence[int]:
        """Of all links that are up."""
        return [number for link in self._links for number in link.filenos()]

    def close(self) -> None:
        """Stop the boards and let go of the links; a second time does nothing."""
        if self.closed:
            return
        try:
            self._stop()
        finally:
            self.closed = True
            for link in self._links:
                link.close()


STEP = 1e-3  # s between two polls of a stream that cannot be waited for


class NoReadingError(SkinfieldError, TimeoutError):
    """Nothing that is new enough has come."""


class StreamReader:
    """Whole readings of a stream.

    Parameters
    ----------
    stream : Stream
        It is polled here only.

    Attributes
    ----------
    channels : Channels
        The newest counts of all.
    """

    def __init__(self, stream: Stream) -> None:
        self.stream, self._blocks = stream, Blocks()
        self.channels = Channels(sum(port.channels for port in stream.ports))
        self._new = np.zeros(len(self.channels), bool)  # of the reading that is under way

    def take(self) -> None:
        """Take in what has arrived. Never waits."""
        self._blocks.clear()
        self.stream.poll(self._blocks, 0, time_ns())
        self.channels.apply(self._blocks)

    def read(self, timeout: float = 1.0) -> Reading:
        """Wait for the next reading of all channels that answer.

        It is complete when all channels that ever brought something have brought something new, or
        one brings something for the second time.

        Parameters
        ----------
        timeout : float, s

        Raises
        ------
        NoReadingError
            If it is not complete in time.
        """
        check_range("timeout", timeout, 0.0, 1e9, "seconds to wait at most")
        end, new, fresh = monotonic() + timeout, self._new, self.channels.fresh
        known = self.channels.stamp_ns > 0
        while True:
            fresh[:] = 0
            self.take()
            came = fresh > 0
            if (came & new).any():
                new[:] = came
                return self._reading()
            new |= came
            if known.any() and new[known].all():
                new[:] = False
                return self._reading()
            left = end - monotonic()
            if left <= 0:
                raise NoReadingError(
                    f"{np.count_nonzero(new)} of {len(new)} channels brought something new within "
                    f"{timeout:g} s, expected all that answer: {self._state()}"
                )
            numbers = self.stream.filenos()
            # never for long: a connection that broke is noticed by polling alone
            select.select(numbers, [], [], min(left, 20 * STEP if numbers else STEP))

    def read_latest(self, max_age: float = 0.1) -> Reading:
        """The newest counts, without waiting.

        Parameters
        ----------
        max_age : float, s
            Of the newest; taxels that are older than that beside newer ones are not `valid`.

        Raises
        ------
        NoReadingError
            If all are older.
        """
        check_range("max_age", max_age, 0.0, 1e9, "seconds since the newest reading, at most")
        self.take()
        newest = int(self.channels.stamp_ns.max())
        age = (time_ns() - newest) * 1e-9
        if not newest or age > max_age:
            what = f"{age:.3g} s old" if newest else "none"
            raise NoReadingError(
                f"the newest reading is {what}, expected at most {max_age:g} s: {self._state()}"
            )
        return self._reading(newest - round(max_age * 1e9))

    def _reading(self, oldest_ns: int = 1) -> Reading:
        channels = self.channels
        good = (channels.stamp_ns >= max(oldest_ns, 1)) & np.isfinite(channels.counts)
        good &= (channels.status & UNUSABLE) == 0
        return Reading(int(channels.stamp_ns.max()), channels.counts.copy(), good)

    def _state(self) -> str:
        fault = getattr(self.stream, "fault", "")
        return f"the source is {'up' if self.stream.up else 'down'} ({fault or 'no fault'})"
