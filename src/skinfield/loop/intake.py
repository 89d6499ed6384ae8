"""Intake of readings: all sources of an engine, polled, logged and applied."""

import contextlib
from collections.abc import Sequence

import numpy as np

from skinfield.errors import Ints
from skinfield.signal import (
    Blocks,
    Channels,
    Count,
    Kind,
    Lasting,
    Port,
    Retry,
    Source,
    Stream,
    counters,
)
from skinfield.signal.blocks import Full

SILENT_NS = 1_000_000_000  # without a message, after which a source counts as away


class Member:
    """One source and its stream, which may be away for a while.

    Parameters
    ----------
    source : Source
        It is opened.
    index : int
        Among the sources.
    channel : int
        First of its channels among all.

    Attributes
    ----------
    stream : Stream or None
    ports : tuple of Port
        As they were at the first opening.
    counters : (len(Count),) int64 array
        Over all times that it was open.
    failure : str
        What went wrong last; empty while it is open.
    """

    def __init__(self, source: Source, index: int, channel: int) -> None:
        self.source, self.index, self.channel = source, index, channel
        self.stream: Stream | None = opened(source, index)
        self.ports: tuple[Port, ...] = tuple(self.stream.ports)
        self.counters, self.failure = counters(), ""
        self._before = counters()  # of streams that were closed
        self._heard = 0  # when the last message came, ns; 0 before the first
        self._silent = False
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
            self._mark_silence(messages, blocks, now_ns)
            np.add(self._before, self.stream.counters, out=self.counters)
        except Exception as error:
            self._failed(error, blocks, now_ns)
            return 0
        return messages

    def _mark_silence(self, messages: int, blocks: Blocks, now_ns: int) -> None:
        """Tell of boards that fall silent though the wire is there, and of their return."""
        if messages:
            if self._silent:
                self._before[Count.DOWN_NS] += now_ns - self._heard
                self._before[Count.REOPENED] += 1
                self._silent = False
                self._tell(blocks, now_ns, 1)
            self._heard = now_ns
        elif self._silent or not self._heard:
            return
        elif self.stream is None or not self.stream.up:
            self._heard = now_ns  # the stream tells of that itself
        elif now_ns - self._heard > SILENT_NS:
            self._silent = True
            self._tell(blocks, now_ns, 0)

    def _tell(self, blocks: Blocks, now_ns: int, up: int) -> None:
        """Put into the record that it went or came back, if there is room."""
        with contextlib.suppress(Full):
            blocks.put_number(now_ns, self.index, Kind.SOURCE, up)

    def _failed(self, error: Exception, blocks: Blocks, now_ns: int) -> None:
        self.failure = f"{type(error).__name__}: {error}"
        assert self.stream is not None  # it has just been polled
        self._before += self.stream.counters
        self.retry.broke(now_ns)
        self._silent, self._heard = False, 0
        self._tell(blocks, now_ns, 0)
        self.leave()
        self.close()

    def leave(self) -> None:
        """See `Lasting`."""
        if isinstance(self.stream, Lasting):
            self.stream.leave()

    def resume(self) -> None:
        """See `Lasting`."""
        if isinstance(self.stream, Lasting):
            self.stream.resume()

    def close(self) -> None:
        """Close its stream; an error in that must not keep others from being closed."""
        stream, self.stream = self.stream, None
        if stream is None:
            return
        try:
            stream.close()
        except Exception as error:
            said = f"when it was closed, {type(error).__name__}: {error}"
            self.failure = f"{self.failure}; {said}" if self.failure else said

    def _try_again(self, blocks: Blocks, now_ns: int) -> None:
        if not self.retry.due(now_ns):
            return
        try:
            stream = opened(self.source, self.index)
            ports = tuple(stream.ports)
            if ports != self.ports:
                self.failure = f"it came back with ports {ports}, expected {self.ports} as before"
                stream.close()
                return
        except Exception as error:
            self.failure = f"{type(error).__name__}: {error}"
            return
        self.stream, self.failure = stream, ""
        self.resume()
        self.retry.came_back(now_ns)
        self._tell(blocks, now_ns, 1)

    def go_on_from(self, row: Ints) -> None:
        """Count on in this array, from what stands there."""
        self._before += row
        row += self.counters
        self.counters = row

    def sentences(self) -> list[str]:
        """Why it is away, and what its stream notes, if it does."""
        if self.stream is None:
            return [self.failure]
        if self._silent:
            return ["nothing comes from it: is it switched on, and told to send?"]
        try:
            fault, notes = getattr(self.stream, "fault", ""), getattr(self.stream, "notes", ())
            return [str(each) for each in ((fault,) if fault else ()) + tuple(notes)]
        except Exception as error:  # other people's code here, too
            return [f"{type(error).__name__}: {error}"]

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
            self.members.append(Member(source, index, channel))
            channel += sum(port.channels for port in self.members[-1].ports)
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
        return [each for stream in streams for each in stream.filenos() if each >= 0]

    def sentences(self) -> list[str]:
        """What the sources have to say, in sentences: why one is away, what it could not get."""
        return [
            f"{type(m.source).__name__}: {text}" for m in self.members for text in m.sentences()
        ]

    def resume(self) -> None:
        """Called before the first poll by an engine that follows on another: see `Lasting`."""
        for member in self.members:
            member.resume()

    def close(self, leave: bool = False) -> None:
        """Close all sources; boards go on if they are left to another engine: see `Lasting`."""
        if leave:
            for member in self.members:
                member.leave()
        for member in self.members:
            member.close()
