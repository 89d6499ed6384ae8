"""Streams over connections that come and go: noticed, told, and tried again without waiting."""

from collections.abc import Sequence
from time import monotonic_ns
from typing import Protocol

from skinfield.acquisition import Blocks, Count, Kind, Port, Retry, counters
from skinfield.errors import Ints

SOURCE_WORDS = 3  # of a block that tells that a source went down or came up


class Link(Protocol):
    """A connection: a bus, a socket, a device."""

    @property
    def up(self) -> bool:
        """Whether something can come."""
        ...

    @property
    def fault(self) -> str:
        """Why it is down, in words."""
        ...

    def reopen(self) -> bool:
        """Try to get it back, without waiting; whether it is up now."""
        ...

    def filenos(self) -> Sequence[int]:
        """File descriptors that become readable when something arrives."""
        ...

    def close(self) -> None:
        """Let go of it."""
        ...


class LinkedStream:
    """What all streams over links share: see `skinfield.acquisition.Stream`.

    A stream is up while all its links are. When it goes down, and when it comes back, it appends a
    block of `Kind.SOURCE`, once. Each link that is down is opened again every `RETRY` seconds.

    Parameters
    ----------
    ports : sequence of Port
    links : sequence of Link

    Attributes
    ----------
    index : int
        Of this source among all, as its blocks of `Kind.SOURCE` say it; whoever reads several
        sources sets it.
    """

    def __init__(self, ports: Sequence[Port], links: Sequence[Link]) -> None:
        self.ports = tuple(ports)
        self.counters: Ints = counters()
        self.index = 0
        self.closed = False
        self._links = tuple(links)
        self._retries = tuple(Retry(self.counters) for _ in self._links)
        self._told_up = True

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

    @property
    def channels(self) -> int:
        """Of all ports."""
        return sum(port.channels for port in self.ports)

    def poll(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        """Append what has arrived; see `skinfield.acquisition.Stream`."""
        if self.closed:
            return 0
        messages = self._take(blocks, channel, now_ns)
        up = True
        for place, link in enumerate(self._links):
            if not link.up or self._retries[place].down_since:
                up = self._follow(place, link, now_ns) and up
        if up != self._told_up:
            self._tell(up, blocks, now_ns)
        return messages

    def _follow(self, place: int, link: Link, now_ns: int) -> bool:
        """Note that a link broke, try it again, note that it is back; whether it is up."""
        retry, steady_ns = self._retries[place], monotonic_ns()  # that nobody sets back
        if not link.up and not retry.down_since:
            retry.broke(steady_ns)
            self._went_down(place)
        elif not link.up and retry.due(steady_ns):
            link.reopen()
        if link.up and retry.down_since:
            retry.came_back(steady_ns)
            self._came_back(place, now_ns)
        return link.up

    def _tell(self, up: bool, blocks: Blocks, now_ns: int) -> None:
        if int(blocks.end[0]) + SOURCE_WORDS <= len(blocks.words):  # else at the next call
            blocks.put_number(now_ns, self.index, Kind.SOURCE, int(up))
            self._told_up = up

    def _take(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        """Append what has arrived, from all links."""
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

    def _count_since(self, what: Count, now: int, before: int) -> int:
        """Add what a total grew by; the new total."""
        if now != before:
            self.counters[what] += now - before
        return now
