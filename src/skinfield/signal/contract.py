"""Contract of every live source, as tests to inherit."""

import pickle
import resource
import time
from collections.abc import Iterator

import numpy as np
import pytest

from skinfield.signal import Block, Blocks, Count, Kind, Source, Status, Stream, blocks_of
from skinfield.skin.reading import UNITS

FIRST = 1000  # channel that the stream's first one is given
PATIENCE = 30.0  # s until something is taken not to come, however busy the machine
PAUSE = 1e-3  # s between polls
NEAR = 60_000_000_000  # ns between a stamp and now
OF_COUNTS = (Kind.BYTES, Kind.SHORTS, Kind.FLOATS)
PORT_KINDS = (*OF_COUNTS, Kind.STATUS)


class SourceContract:
    """Subclass it with a source, and with what makes its device send.

    Attributes
    ----------
    source : Source
        Or override `make`.
    small : int, bytes
        Of the smallest buffer that the source must get along with: one message must fit.
    rounds : int
        Times that the device is made to send in a test.
    """

    source: Source
    small: int = 4096
    rounds: int = 5

    def make(self) -> Source:
        """The source, whose device is there."""
        return self.source

    def provoke(self, stream: Stream) -> int | None:
        """Have the device send; how many blocks of counts must come of it, None if unknown.

        Called while the stream is up. A source that sends by itself needs none.
        """
        return None

    def unplug(self, stream: Stream) -> None:
        """Take the device away; override it together with `plug` to test that."""
        pytest.skip("the contract's subclass has no unplug()")

    def plug(self, stream: Stream) -> None:
        """Bring it back."""

    @pytest.fixture(name="stream")
    def _stream(self) -> Iterator[Stream]:
        stream = self.make().open()
        try:
            yield stream
        finally:
            stream.close()

    def poll(self, stream: Stream, blocks: Blocks) -> list[Block]:
        """Poll once; the blocks, copied out of the buffer."""
        blocks.clear()
        stream.poll(blocks, FIRST, time.time_ns())
        return list(blocks_of(blocks.data.tobytes()))

    def gather(self, stream: Stream, enough: int = 1, size: int = 1 << 22) -> list[Block]:
        """Provoke and poll until so many blocks of counts are there."""
        blocks, found, end = Blocks(size), list[Block](), time.monotonic() + PATIENCE
        while sum(block.kind in OF_COUNTS for block in found) < enough:
            assert time.monotonic() < end, f"no readings: {getattr(stream, 'fault', '')}"
            if stream.up:
                self.provoke(stream)
            found += self.poll(stream, blocks)
            time.sleep(PAUSE)
        return found

    def test_it_can_be_sent_to_another_process(self) -> None:
        """Settings are opened in the process that reads them."""
        assert hasattr(pickle.loads(pickle.dumps(self.make())), "open")

    def test_ports_are_named(self, stream: Stream) -> None:
        """One or more, of distinct names, in a known unit."""
        names = [port.name for port in stream.ports]
        assert names
        assert len(set(names)) == len(names)
        assert {port.unit for port in stream.ports} <= set(UNITS)
        assert stream.counters.shape == (len(Count),)
        assert stream.counters.dtype == np.int64

    def test_blocks_are_of_its_channels(self, stream: Stream) -> None:
        """Whole blocks, of the channels that were given to it, and of status that exists."""
        channels = sum(port.channels for port in stream.ports)
        for block in self.gather(stream, self.rounds):
            if block.kind in PORT_KINDS:
                assert block.channel >= FIRST
                assert block.channel + block.count <= FIRST + channels
                assert block.count > 0
                assert not int(block.status) & ~sum(Status)

    def test_stamps_are_of_now_and_never_go_back(self, stream: Stream) -> None:
        """Nanoseconds since the epoch, for each channel in order."""
        newest: dict[int, int] = {}
        for block in self.gather(stream, self.rounds):
            assert abs(block.stamp_ns - time.time_ns()) < NEAR
            if block.kind in OF_COUNTS:
                for channel in range(block.channel, block.channel + block.count):
                    assert newest.get(channel, 0) <= block.stamp_ns
                    newest[channel] = block.stamp_ns

    def test_counters_tell_what_was_delivered(self, stream: Stream) -> None:
        """READINGS is the number of blocks of counts; nothing that is counted goes down."""
        blocks, before, delivered = Blocks(), stream.counters.copy(), 0
        for block in self.gather(stream, self.rounds):
            delivered += block.kind in OF_COUNTS
        for _ in range(20):
            delivered += sum(block.kind in OF_COUNTS for block in self.poll(stream, blocks))
            assert (stream.counters >= before).all()
            before = stream.counters.copy()
        assert stream.counters[Count.READINGS] == delivered
        assert stream.counters[Count.RECEIVED] > 0

    def test_poll_never_waits(self, stream: Stream) -> None:
        """A call that waits gives the processor away: most polls must not, busy or idle."""
        self.gather(stream)
        blocks, waited = Blocks(), 0
        for _ in range(100):
            blocks.clear()
            before = resource.getrusage(resource.RUSAGE_THREAD).ru_nvcsw
            stream.poll(blocks, FIRST, time.time_ns())
            waited += resource.getrusage(resource.RUSAGE_THREAD).ru_nvcsw > before
        assert waited < 50

    def test_a_full_buffer_loses_nothing(self, stream: Stream) -> None:
        """What does not fit stays for the next call."""
        self.gather(stream)
        self._drain(stream, Blocks())
        blocks, expected, before = Blocks(self.small), 0, stream.counters.copy()
        for _ in range(self.rounds):
            sent = self.provoke(stream)
            if sent is None:
                expected = -1
                break
            expected += sent
        found, end = 0, time.monotonic() + PATIENCE
        while found < max(expected, self.rounds):
            assert time.monotonic() < end, f"{found} of {expected} blocks came"
            found += sum(block.kind in OF_COUNTS for block in self.poll(stream, blocks))
            time.sleep(PAUSE)
        if expected >= 0:
            assert found + self._drain(stream, blocks) == expected
        change = stream.counters - before
        assert change[Count.READINGS] >= found
        for what in (Count.LOST, Count.OVERFLOWED, Count.MALFORMED):
            assert change[what] == 0, what.name

    def _drain(self, stream: Stream, blocks: Blocks) -> int:
        """Poll a source that is provoked until it is empty; blocks of counts."""
        found = 0
        for _ in range(20):
            found += sum(block.kind in OF_COUNTS for block in self.poll(stream, blocks))
            time.sleep(PAUSE)
        return found

    def test_closing_twice_is_closing_once(self, stream: Stream) -> None:
        """After it nothing comes, nothing is up, and nothing fails."""
        self.gather(stream)
        stream.close()
        stream.close()
        assert not stream.up
        assert not list(stream.filenos())
        blocks = Blocks()
        assert stream.poll(blocks, FIRST, time.time_ns()) == 0
        assert not len(blocks.data)

    def test_file_descriptors_are_open(self, stream: Stream) -> None:
        """Those that tell when something arrives."""
        self.gather(stream)
        assert all(isinstance(number, int) and number >= 0 for number in stream.filenos())

    def test_it_comes_back_when_it_is_plugged_in_again(self, stream: Stream) -> None:
        """Going down and coming back are told once each, and readings go on."""
        self.gather(stream)
        self.unplug(stream)
        told = self._until(stream, up=False)
        assert [block.payload[0] for block in told if block.kind == Kind.SOURCE] == [0]
        self.plug(stream)
        told = self._until(stream, up=True)
        assert [block.payload[0] for block in told if block.kind == Kind.SOURCE] == [1]
        assert stream.counters[Count.REOPENED] == 1
        assert stream.counters[Count.DOWN_NS] > 0
        assert not [each for each in self.gather(stream) if each.kind == Kind.SOURCE]

    def _until(self, stream: Stream, up: bool) -> list[Block]:
        """Poll until it is up, or down; then once more, and the blocks of it all."""
        blocks, found, end = Blocks(), list[Block](), time.monotonic() + PATIENCE
        while stream.up != up:
            assert time.monotonic() < end, f"it never went {'up' if up else 'down'}"
            found += self.poll(stream, blocks)
            time.sleep(PAUSE)
        return found + self.poll(stream, blocks)
