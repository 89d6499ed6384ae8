"""Buses of the tests, each at a place of its own: tests run beside each other."""

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from skinfield.signal import Blocks, counters
from skinfield.wire.can import Bus, BusSettings, open_bus
from skinfield.wire.can.messages import EXTENDED, REMOTE, CanDecoder, CanMessages

PATIENCE = 120.0  # s, after which something is broken, however busy the machine


def group() -> str:
    """A multicast group that no other test has."""
    return "239.74." + ".".join(str(1 + octet % 254) for octet in os.urandom(2))


def free_port() -> int:
    """A port that is free now."""
    import socket

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("", 0))
        return int(sock.getsockname()[1])


def wait_for(condition: Callable[[], object]) -> None:
    """Wait until it holds."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "it never came"
        time.sleep(1e-3)


def rows_of(messages: CanMessages, count: int, first: int = 0) -> list[tuple[int, bytes]]:
    """Identifiers and data of rows `first` to `count`."""
    return [
        (int(messages.ids[row]), messages.data[row, : messages.lengths[row]].tobytes())
        for row in range(first, count)
    ]


def decoded_in_parts(
    make: Callable[[], CanDecoder], rows: tuple[CanMessages, int], room: int
) -> tuple[int, np.ndarray]:
    """Calls that it took with so little room, and what was counted: the blocks as with enough."""
    decoder, small, whole, seen = make(), Blocks(room), Blocks(1 << 16), counters()
    make().decode(*rows, whole, 0, counters())
    parts, at, calls = b"", 0, 0
    while at < rows[1]:
        small.clear()
        then = decoder.decode(*rows, small, 0, seen, at)
        assert at < then <= rows[1]
        at, calls, parts = then, calls + 1, parts + small.data.tobytes()
    assert parts == whole.data.tobytes()
    return calls, seen


def receive(bus: Bus, count: int, room: int = 256) -> list[tuple[int, bytes, int]]:
    """Identifier, data and stamp of the next messages; patiently."""
    messages, found = CanMessages(room), []

    def all_there() -> bool:
        rows = rows_of(messages, bus.receive(messages))
        for (identifier, data), stamp in zip(rows, messages.stamp_ns.tolist(), strict=False):
            found.append((identifier, b"" if identifier & REMOTE else data, stamp))
        return len(found) >= count

    wait_for(all_there)
    return found


@contextmanager
def opened(*settings: BusSettings) -> Iterator[list[Bus]]:
    """Open buses, and close them at the end."""
    buses = [open_bus(each) for each in settings]
    try:
        yield buses
    finally:
        for bus in buses:
            bus.close()


@contextmanager
def pair() -> Iterator[tuple[Bus, Bus]]:
    """A host and its board over plain UDP."""
    with opened(BusSettings("udp", port=0)) as (host,):
        peer = f"127.0.0.1:{host.address[1]}"
        with opened(BusSettings("udp", port=0, peer=peer)) as (board,):
            yield host, board


def drawn_messages(rng: np.random.Generator, count: int) -> CanMessages:
    """Messages of all kinds."""
    messages = CanMessages(count)
    extended = rng.random(count) < 0.5
    messages.ids[:] = np.where(
        extended, rng.integers(0, 1 << 29, count) | EXTENDED, rng.integers(0, 1 << 11, count)
    )
    messages.ids[rng.random(count) < 0.1] |= np.uint32(REMOTE)
    messages.lengths[:] = rng.integers(0, 9, count)
    messages.data[:] = rng.integers(0, 256, (count, 8))
    messages.data[np.arange(8) >= messages.lengths[:, None]] = 0
    messages.stamp_ns[:] = rng.integers(0, 1 << 60, count)
    return messages
