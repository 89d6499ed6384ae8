"""Devices in software, each at a place of its own, for the tests of live sources."""

import ctypes
import os
import socket
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from tempfile import gettempdir

import numpy as np
import pytest
from bus_peers import free_port, rows_of, wait_for

from skinfield.emulator import VirtualSettings
from skinfield.emulator.packet import Ear
from skinfield.emulator.transports import open_link
from skinfield.signal import Blocks, Channels, Count, Source, Stream
from skinfield.signal.contract import SourceContract
from skinfield.skin import Skin
from skinfield.skin.generators import by_name
from skinfield.wire.can import BusSettings, open_bus
from skinfield.wire.can.messages import CanMessages
from skinfield.wire.cyskin import CySkinEncoder, on_boards, uids_of
from skinfield.wire.cyskin.shared_memory import DATA_HEAD, HEADER_WORDS, libc
from skinfield.wire.icub import ICubConfiguration, configuration_for
from skinfield.wire.packet.packets import Packet, PacketKind, encode_counts
from skinfield.wire.sources import CySkinCan, ICubCan, PacketSerial, PacketTcp

HEXAGON = Skin((by_name("hexagon72"),))
ON_CYSKIN, CYSKIN_BOARDS = on_boards(HEXAGON)


class Host:
    """A stream that takes in whatever comes, and the channels that it fills."""

    def __init__(self, stream: Stream) -> None:
        self.stream, self.blocks = stream, Blocks()
        self.channels = Channels(sum(port.channels for port in stream.ports))

    def poll(self) -> int:
        self.blocks.clear()
        taken = self.stream.poll(self.blocks, 0, time.time_ns())
        self.channels.apply(self.blocks)
        return int(taken)

    def until(self, condition: Callable[[], object]) -> None:
        wait_for(lambda: (self.poll(), condition())[1])

    def came(self, there: slice | list[int]) -> np.ndarray:
        """Counts, once those are there."""
        self.until(lambda: np.isfinite(self.channels.counts[there]).all())
        return self.channels.counts

    def count(self, what: Count) -> int:
        return int(self.stream.counters[what])


class ICubBoard:
    """Board 1 with six triangles, over UDP: what it was told, and readings when asked."""

    def __init__(self) -> None:
        self.bus = open_bus(BusSettings("udp", port=0))
        self.port = self.bus.address[1]
        self.own = free_port()
        self.told: list[tuple[int, bytes]] = []
        self.sent = 0
        self.blocker: socket.socket | None = None
        self._rows = CanMessages(64)

    @property
    def settings(self) -> BusSettings:
        """Of the bus, for the host."""
        return BusSettings("udp", port=self.own, peer=f"127.0.0.1:{self.port}")

    @property
    def configuration(self) -> ICubConfiguration:
        return configuration_for(*HEXAGON)

    def source(self, configure: bool = True) -> ICubCan | CySkinCan:
        return ICubCan(self.configuration, (self.settings,), configure)

    def listen(self) -> list[tuple[int, bytes]]:
        """All that it was told until now."""
        self.told += rows_of(self._rows, self.bus.receive(self._rows))
        return self.told

    def send(self, message_class: int = 4) -> int:
        """Send one reading of all triangles; blocks of counts that it makes."""
        self.listen()
        self.sent += 1
        value = self.sent % 200
        for triangle in range(6):
            identifier = message_class << 8 | 1 << 4 | triangle
            self.bus.send(identifier, b"\x40" + bytes([value]) * 7)
            self.bus.send(identifier, b"\xc0" + bytes([value]) * 5 + b"\0\0")
        return 12

    def unplug(self, stream: Stream) -> None:
        """Break the host's socket, and keep its port from it."""
        stream.buses[0]._socket.close()  # type: ignore[attr-defined]
        self.blocker = sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

        def bound() -> bool:
            with suppress(OSError):
                sock.bind(("127.0.0.1", self.own))
            return sock.getsockname()[1] == self.own

        wait_for(bound)

    def plug(self) -> None:
        assert self.blocker is not None
        self.blocker.close()

    def close(self) -> None:
        self.bus.close()
        if self.blocker is not None:
            self.blocker.close()


class CySkinBoard(ICubBoard):
    """CySkin's board 1 with six modules, on the same bus: one packet, and so one block."""

    def __init__(self) -> None:
        super().__init__()
        self.encoder = CySkinEncoder(CYSKIN_BOARDS)

    def source(self, configure: bool = True) -> ICubCan | CySkinCan:
        return CySkinCan(CYSKIN_BOARDS, (self.settings,), configure=configure)

    def send(self, message_class: int = 4) -> int:
        self.listen()
        self.sent += 1
        self.encoder.counts[:] = np.arange(72) + self.sent
        count = self.encoder.encode(self._rows, 0, 0)
        assert self.bus.send_many(self._rows, count) == count
        return 1


def packet(number: int, channels: int = 72) -> bytes:
    """Reading `number` of device 1."""
    values = (np.arange(channels) + number) % 4096
    return encode_counts(
        values, Packet(kind=PacketKind.SHORTS, sequence=number, time_us=1000 * number)
    )


class PacketSocket:
    """A device that sends by UDP."""

    def __init__(self) -> None:
        self.number, self.socket = -1, socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.close = self.socket.close

    def send(self, stream: Stream) -> int:
        """Send one reading; blocks of counts that it makes."""
        self.number += 1
        self.socket.sendto(packet(self.number), stream.address)  # type: ignore[attr-defined]
        return 1


class PacketServer:
    """A device behind a TCP server."""

    bus, source_at = "tcp", lambda place: PacketTcp(72, port=int(place.rpartition(":")[2]))

    def __init__(self) -> None:
        self.place, self.number, self.told = self.new_place(), -1, list[int]()
        self.plug()

    def new_place(self) -> str:
        return "127.0.0.1:0"

    def plug(self) -> None:
        where = VirtualSettings(hardware="packet", bus=self.bus, channels=(self.place,))
        self.link, self._ear = open_link(where), Ear()
        self.place = self.link.address

    def source(self) -> Source:
        return type(self).source_at(self.place)

    def listen(self) -> list[int]:
        """Kinds of all packets that it was told until now."""
        self.told += [each.kind for each in self._ear.packets(self.link.receive())]
        return self.told

    def send(self, data: bytes | None = None) -> int:
        """Send one reading; blocks of counts that it makes."""
        wait_for(lambda: (self.listen(), self.link.heard)[1])
        self.number += 1
        self.link.say(packet(self.number) if data is None else data)
        assert not self.link.counts["refused"]
        return 1

    def unplug(self, stream: Stream | None = None) -> None:
        self.link.close()

    close = unplug


class SerialLine(PacketServer):
    """A device at a pseudo-terminal, whose node keeps its name."""

    bus, source_at = "serial", lambda place: PacketSerial(72, place)

    def new_place(self) -> str:
        return f"{gettempdir()}/skinfield-{uuid.uuid4().hex}"

    @property
    def path(self) -> Path:
        return Path(self.place)


class SharedMemoryWriter:
    """The side of CySkin's tool: makes the memory, and removes it."""

    def __init__(self, uids: np.ndarray, key: int, data_key: int) -> None:
        self._uids, self._areas = np.asarray(uids, np.uint32), []
        # the maker's tool asks for 10 bytes of header, not words
        self.header = self._made(key, 10, HEADER_WORDS)
        words = 2 * len(self._uids) + DATA_HEAD
        self._data = self._made(data_key, 4 * words, words)
        self.header[2], self.header[1], self.header[0] = data_key, 0, len(self._uids)
        self.sample = 0

    def _made(self, key: int, size: int, words: int) -> np.ndarray:
        number = libc().shmget(key, size, 0o1600)  # IPC_CREAT
        if number < 0:
            raise OSError(ctypes.get_errno(), "no shared memory")
        address = libc().shmat(number, None, 0)
        self._areas.append((number, address))
        return np.ctypeslib.as_array((ctypes.c_uint32 * words).from_address(address))

    def write(self, responses: np.ndarray, time_ms: int) -> None:
        """Write one sample (N,), in the tool's own order: its number is the last word."""
        words, count = self._data, len(self._uids)
        words[DATA_HEAD : DATA_HEAD + count] = self._uids
        words[DATA_HEAD + count :] = responses
        words[2], words[1], words[0] = count, time_ms, self.sample
        self.sample += 1

    def close(self) -> None:
        for number, address in self._areas:
            libc().shmctl(number, 0, None)  # IPC_RMID
            libc().shmdt(address)
        self._areas = []


class Memory:
    """CySkin's acquisition tool, at keys of its own."""

    def __init__(self) -> None:
        self.uids, self.number = uids_of(CYSKIN_BOARDS)[0], 0
        self.key = int.from_bytes(os.urandom(3), "big") + 1000
        self.plug()

    def plug(self) -> None:
        self.writer = SharedMemoryWriter(self.uids, self.key, self.key + (1 << 25))

    def send(self) -> int:
        self.number += 1
        self.writer.write(np.arange(len(self.uids)) + self.number, self.number)
        return 1

    def unplug(self, stream: Stream) -> None:
        self.close()

    def close(self) -> None:
        self.writer.close()


class WithDevice(SourceContract):
    """A source with a device of its own, which sends and goes away when it is told to."""

    made: type

    def make(self) -> Source:
        return self.device.source()  # type: ignore[no-any-return]

    @pytest.fixture(autouse=True)
    def _device(self) -> Iterator[None]:
        self.device = self.made()
        yield
        self.device.close()

    def provoke(self, stream: Stream) -> int:
        return int(self.device.send())


class Leaving(WithDevice):
    """A device that can be unplugged, too."""

    def unplug(self, stream: Stream) -> None:
        self.device.unplug(stream)

    def plug(self, stream: Stream) -> None:
        self.device.plug()
