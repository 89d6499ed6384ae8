"""Every live source keeps the contract, with a device in software at the other end."""

import uuid
from collections.abc import Iterator
from pathlib import Path

import can
import pytest
from live_devices import (
    CYSKIN_BOARDS,
    HEXAGON,
    CySkinBoard,
    ICubBoard,
    Leaving,
    Memory,
    PacketServer,
    PacketSocket,
    SerialLine,
    WithDevice,
)

from skinfield.files.recordings.replay import ReplaySource
from skinfield.signal import Source, Stream
from skinfield.signal.contract import SourceContract
from skinfield.wire.can import BusSettings
from skinfield.wire.icub import configuration_for
from skinfield.wire.sources import CySkinSharedMemory, ICubCan, PacketUdp


class TestICubCan(Leaving):
    made = ICubBoard


class TestCySkinCan(Leaving):
    made = CySkinBoard


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
        for first, taxels in ((0x40, 7), (0xC0, 5)):
            data = bytes([first, *[self.sent % 200] * taxels])
            self.bus.send(can.Message(arbitration_id=0x415, is_extended_id=False, data=data))
        return 2


class TestPacketUdp(WithDevice):
    made = PacketSocket

    def make(self) -> Source:
        return PacketUdp(72, port=0)

    def provoke(self, stream: Stream) -> int:
        return int(self.device.send(stream))


class TestPacketTcp(Leaving):
    made = PacketServer


class TestPacketSerial(Leaving):
    made = SerialLine


class TestCySkinSharedMemory(Leaving):
    made = Memory
    rounds = 1  # it holds the newest sample only

    def make(self) -> Source:
        return CySkinSharedMemory(CYSKIN_BOARDS, self.device.key)

    def plug(self, stream: Stream) -> None:
        super().plug(stream)
        self.device.send()


class TestReplaySource(SourceContract):
    @pytest.fixture(autouse=True)
    def _file(self, tmp_path: Path) -> None:
        self.path = tmp_path / "recording.csv"
        rows = [f"{i / 500},{i},{i + 1},{i + 2}" for i in range(40)]
        self.path.write_text("\n".join(["time_s,taxel_0,taxel_1,taxel_2", *rows]) + "\n")

    def make(self) -> Source:
        return ReplaySource(self.path, loop=True)
