"""Every live source keeps the contract, with a device in software at the other end."""

import uuid
from collections.abc import Iterator
from pathlib import Path

import can
import numpy as np
import pytest
from live_devices import (
    CYSKIN_BOARDS,
    HEXAGON,
    CySkinBoard,
    ICubBoard,
    Memory,
    PacketServer,
    SerialLine,
    packet,
)

from skinfield.signal import Source, Stream
from skinfield.testing import SourceContract
from skinfield.wire.can import BusSettings
from skinfield.wire.cyskin import uids_of
from skinfield.wire.icub import configuration_for
from skinfield.wire.sources import (
    CySkinCan,
    CySkinSharedMemory,
    ICubCan,
    PacketSerial,
    PacketTcp,
    PacketUdp,
    ReplaySource,
    SimulationSource,
)


class TestICubCan(SourceContract):
    @pytest.fixture(autouse=True)
    def _board(self) -> Iterator[None]:
        self.board = ICubBoard()
        yield
        self.board.close()

    def make(self) -> Source:
        return ICubCan(self.board.configuration, (self.board.settings,))

    def provoke(self, stream: Stream) -> int:
        return self.board.send()

    def unplug(self, stream: Stream) -> None:
        self.board.unplug(stream)

    def plug(self, stream: Stream) -> None:
        self.board.plug()


class TestCySkinCan(TestICubCan):
    @pytest.fixture(autouse=True)
    def _board(self) -> Iterator[None]:
        self.board = CySkinBoard()
        yield
        self.board.close()

    def make(self) -> Source:
        return CySkinCan(CYSKIN_BOARDS, (self.board.settings,))


class TestICubOverPythonCan(SourceContract):
    @pytest.fixture(autouse=True)
    def _bus(self) -> Iterator[None]:
        self.channel, self.sent = uuid.uuid4().hex, 0
        with can.Bus(interface="virtual", channel=self.channel) as self.bus:
            yield

    def make(self) -> Source:
        return ICubCan(configuration_for(*HEXAGON), (BusSettings("virtual", self.channel),))

    def provoke(self, stream: Stream) -> int:
        self.sent += 1
        head = b"\x40" + bytes([self.sent % 200]) * 7
        self.bus.send(can.Message(arbitration_id=0x415, is_extended_id=False, data=head))
        tail = b"\xc0" + bytes([self.sent % 200]) * 5
        self.bus.send(can.Message(arbitration_id=0x415, is_extended_id=False, data=tail))
        return 2


class TestPacketUdp(SourceContract):
    @pytest.fixture(autouse=True)
    def _device(self) -> Iterator[None]:
        import socket

        self.number = -1
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as self.socket:
            yield

    def make(self) -> Source:
        return PacketUdp(72, port=0)

    def provoke(self, stream: Stream) -> int:
        self.number += 1
        address = stream.address  # type: ignore[attr-defined]
        self.socket.sendto(packet(self.number), address)
        return 1


class TestPacketTcp(SourceContract):
    @pytest.fixture(autouse=True)
    def _server(self) -> Iterator[None]:
        self.server = PacketServer()
        yield
        self.server.close()

    def make(self) -> Source:
        return PacketTcp(72, port=self.server.port)

    def provoke(self, stream: Stream) -> int:
        return self.server.send()

    def unplug(self, stream: Stream) -> None:
        self.server.close()

    def plug(self, stream: Stream) -> None:
        self.server.listen()


class TestPacketSerial(SourceContract):
    @pytest.fixture(autouse=True)
    def _line(self) -> Iterator[None]:
        self.line = SerialLine()
        yield
        self.line.close()

    def make(self) -> Source:
        return PacketSerial(72, str(self.line.path))

    def provoke(self, stream: Stream) -> int:
        return self.line.send()

    def unplug(self, stream: Stream) -> None:
        self.line.unplug()

    def plug(self, stream: Stream) -> None:
        self.line.plug()


class TestCySkinSharedMemory(SourceContract):
    rounds = 1  # it holds the newest sample only

    @pytest.fixture(autouse=True)
    def _memory(self) -> Iterator[None]:
        self.memory = Memory(uids_of(CYSKIN_BOARDS)[0])
        yield
        self.memory.close()

    def make(self) -> Source:
        return CySkinSharedMemory(CYSKIN_BOARDS, self.memory.key)

    def provoke(self, stream: Stream) -> int:
        self.memory.send()
        return 1

    def unplug(self, stream: Stream) -> None:
        self.memory.unplug()

    def plug(self, stream: Stream) -> None:
        self.memory.plug()
        self.memory.send()


class TestSimulationSource(SourceContract):
    source = SimulationSource(np.arange(60.0).reshape(5, 12), rate=500.0)


class TestReplaySource(SourceContract):
    @pytest.fixture(autouse=True)
    def _file(self, tmp_path: Path) -> None:
        self.path = tmp_path / "recording.csv"
        rows = [f"{i / 500},{i},{i + 1},{i + 2}" for i in range(40)]
        self.path.write_text("\n".join(["time_s,taxel_0,taxel_1,taxel_2", *rows]) + "\n")

    def make(self) -> Source:
        return ReplaySource(self.path, loop=True)
