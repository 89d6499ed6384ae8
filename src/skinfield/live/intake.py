"""All sources of an engine: polled, logged and applied, whatever happens to one of them."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from skinfield.acquisition import (
    Blocks,
    Channels,
    Count,
    Kind,
    Port,
    Retry,
    Source,
    Stream,
    counters,
)
from skinfield.errors import Ints


@dataclass(eq=False)
class Member:
    """One source and its stream, which may be away for a while.

    Attributes
    ----------
    source : Source
    index : int
        Among the sources.
    stream : Stream
    ports : tuple of Port
        As they were at the first opening.
    channel : int
        First of its channels among all.
    counters : (len(Count),) int64 array
        Over all times that it was open.
    failure : str
        What went wrong last; empty while it is open.
    """

    source: Source
    index: int
    stream: Stream | None
    ports: tuple[Port, ...]
    channel: int
    counters: Ints
    failure: str = ""
    retry: Retry = field(init=False)
    _before: Ints = field(init=False)

    def __post_init__(self) -> None:
        self._before = counters()  # of streams that were closed
        self.retry = Retry(self._before)

    def poll(self, blocks: Blocks, now_ns: int) -> int:
        """Take in what has arrived; an error of the driver closes it until it can be opened again.

        A driver is other people's code: whatever it raises costs its own readings, not the cycle.
        """
        if self.stream is None:
            self._try_again(blocks, now_ns)
            return 0
        try:
            messages = self.stream.poll(blocks, self.channel, now_ns)
        except Exception as error:
            self._failed(error, blocks, now_ns)
            return 0
        np.add(self._before, self.stream.counters, out=self.counters)
        return messages

    def _failed(self, error: Exception, blocks: Blocks, now_ns: int) -> None:
        stream, self.stream = self.stream, None
        self.failure = f"{type(error).__name__}: {error}"
        assert stream is not None  # it has just been polled
        self._before += stream.counters
        self.retry.broke(now_ns)
        blocks.put_number(now_ns, self.index, Kind.SOURCE, 0)
        try:
            stream.close()
        except Exception as again:
            self.failure += f"; when it was closed, {type(again).__name__}: {again}"

    def _try_again(self, blocks: Blocks, now_ns: int) -> None:
        if not self.retry.due(now_ns):
            return
        try:
            stream = opened(self.source, self.index)
        except Exception as error:
            self.failure = f"{type(error).__name__}: {error}"
            return
        if tuple(stream.ports) != self.ports:
            self.failure = (
                f"it came back with ports {tuple(stream.ports)}, expected {self.ports} as before"
            )
            stream.close()
            return
        self.stream, self.failure = stream, ""
        self.retry.came_back(now_ns)
        blocks.put_number(now_ns, self.index, Kind.SOURCE, 1)

    def go_on_from(self, row: Ints) -> None:
        """Count on in this array, from what stands there."""
        self._before += row
        row += self.counters
        self.counters = row

    def said(self) -> list[str]:
        """Why it is away, and what its stream notes, if it does."""
        if self.stream is None:
            return [self.failure]
        fault, notes = getattr(self.stream, "fault", ""), getattr(self.stream, "notes", ())
        return [str(each) for each in ((fault,) if fault else ()) + tuple(notes)]

    @property
    def up(self) -> bool:
        """Whether it is connected, as far as is known."""
        return self.stream is not None and self.stream.up


def opened(source: Source, index: int) -> Stream:
    """Open a source; a stream that tells of itself in its blocks learns which one it is."""
    stream = source.open()
    if hasattr(stream, "index"):
        stream.index = index
    return stream


class Intake:
    """The sources of an engine.

    Parameters
    ----------
    sources : sequence of Source
        They are opened.

    Attributes
    ----------
    members : list of Member
    ports : tuple of Port
        Of all, one source after the other.
    blocks : Blocks
        Of the last poll.
    channels : Channels
    counters : (S, len(Count)) int64 array
        May be placed elsewhere by `count_in`.
    """

    def __init__(self, sources: Sequence[Source], room: int = 1 << 22) -> None:
        self.members: list[Member] = []
        channel = 0
        for index, source in enumerate(sources):
            stream = opened(source, index)
            ports = tuple(stream.ports)
            self.members.append(Member(source, index, stream, ports, channel, counters()))
            channel += sum(port.channels for port in ports)
        self.ports = tuple(port for member in self.members for port in member.ports)
        self.blocks, self.channels = Blocks(room), Channels(channel)
        self.damaged = 0

    def count_in(self, table: Ints) -> None:
        """Count on in the rows of an array (S, len(Count)), as an engine before left it."""
        for member, row in zip(self.members, table, strict=True):
            member.go_on_from(row)

    def poll(self, now_ns: int) -> int:
        """Take in what has arrived from all sources; how many messages. Never waits."""
        blocks, messages = self.blocks, 0
        blocks.clear()
        for member in self.members:
            messages += member.poll(blocks, now_ns)
        if blocks.end[0]:
            self.damaged += self.channels.apply_good(blocks)
        return messages

    def filenos(self) -> list[int]:
        """File descriptors to wait for."""
        streams = [member.stream for member in self.members if member.stream is not None]
        return [each for stream in streams for each in stream.filenos()]

    def said(self) -> list[str]:
        """What the sources have to say, in sentences: why one is away, what it could not get."""
        return [f"{type(m.source).__name__}: {text}" for m in self.members for text in m.said()]

    @property
    def lost(self) -> int:
        """Messages that are known to be missing, dropped by the system included."""
        rows = np.array([member.counters for member in self.members])
        return int(rows[:, Count.LOST].sum() + rows[:, Count.OVERFLOWED].sum())

    def close(self) -> None:
        """Close all sources."""
        for member in self.members:
            if member.stream is not None:
                member.stream.close()
                member.stream = None
