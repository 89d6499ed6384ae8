"""Microcontrollers that send packets: one for each patch."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from time import monotonic_ns

import numpy as np

from skinfield.emulator.electronics import Converters, manufacture
from skinfield.emulator.hardware import Hardware
from skinfield.emulator.settings import VirtualSettings
from skinfield.emulator.transports import open_link
from skinfield.errors import InputError
from skinfield.skin import Patch, Skin
from skinfield.wire.packet import (
    COMMANDS,
    EVERY_DEVICE,
    CommandReply,
    Hello,
    Packet,
    PacketEncoder,
    PacketKind,
    encode_packet,
    packet_from_bytes,
)
from skinfield.wire.packet.packets import CRC_BYTES, HEADER_BYTES, LONGEST, MAGIC

REST = 1000.0  # counts of an unloaded taxel
PERIOD = 0.02  # s, where nobody says another
MOST = 64  # commands of one call, so that a flood of them delays no reading for long
DONE, UNKNOWN = 0, 1  # results of a command
FASTEST_US = 50


@dataclass
class Device:
    """One microcontroller.

    Attributes
    ----------
    patch : Patch
    encoder : PacketEncoder
    period : float, s
    sending : bool
    """

    patch: Patch
    encoder: PacketEncoder
    period: float = PERIOD
    sending: bool = True
    booted_ns: int = field(default_factory=monotonic_ns)

    @property
    def clock_us(self) -> int:
        """Of its own clock."""
        return (monotonic_ns() - self.booted_ns) // 1000


class Ear:
    """Finds whole commands in a stream; what is none is passed over."""

    def __init__(self) -> None:
        self._bytes = b""

    def packets(self, more: bytes) -> Iterator[Packet]:
        """Commands that are whole with these bytes."""
        self._bytes = (self._bytes + more)[-4 * LONGEST :]
        for _ in range(MOST):
            at = self._bytes.find(MAGIC)
            self._bytes = self._bytes[at if at >= 0 else -1 :]  # one letter may begin the next
            size = HEADER_BYTES + int.from_bytes(self._bytes[6:8], "little") + CRC_BYTES
            if len(self._bytes) < HEADER_BYTES or len(self._bytes) < size <= LONGEST:
                return
            try:
                packet = packet_from_bytes(self._bytes)
            except InputError:
                self._bytes = self._bytes[1:]
                continue
            self._bytes = self._bytes[size:]
            if packet.kind in COMMANDS:
                yield packet


class PacketDevices(Hardware):
    """See `Hardware`."""

    def __init__(self, skin: Skin, settings: VirtualSettings) -> None:
        self.devices = [
            Device(patch, PacketEncoder(patch.n_channels, device=number))
            for number, patch in enumerate(skin, 1)
        ]
        level = np.full(sum(len(patch) for patch in skin), REST)
        converters = Converters(manufacture(skin, settings), settings, level, (0.0, 65535.0))
        self._wire = open_link(settings)
        self._modules = [np.unique(patch.module) for patch in skin]
        parts = [len(modules) for modules in self._modules]
        super().__init__(skin, settings, parts, converters, [self._wire])
        self._ear = Ear()
        self._greeted = False

    def _period(self, board: int) -> float | None:
        device = self.devices[board]
        return device.period if device.sending and self._wire.heard else None

    def listen(self, now_ns: int, warmth: float) -> None:
        """See `Hardware`."""
        for packet in self._ear.packets(self._wire.receive()):
            for board in set(range(self._boards)) - self.quiet:
                if packet.device in (board + 1, EVERY_DEVICE):
                    self._obey(board, packet, warmth)
        self.reschedule(now_ns)

    def reschedule(self, now_ns: int) -> None:
        """See `Hardware`; each device says first what it is to who has come."""
        if self._wire.heard and not self._greeted:
            for device in self.devices:
                self._hello(device)
        self._greeted = self._wire.heard
        super().reschedule(now_ns)

    def _obey(self, board: int, packet: Packet, warmth: float) -> None:
        self.commands += 1
        device, result = self.devices[board], DONE
        if packet.kind in (PacketKind.START, PacketKind.STOP):
            device.sending = packet.kind == PacketKind.START
        elif packet.kind == PacketKind.PERIOD and len(packet.payload) >= 4:
            micros = int.from_bytes(packet.payload[:4], "little")
            device.period = max(micros, FASTEST_US) * 1e-6
        elif packet.kind == PacketKind.TARE:
            rows = self._rows(board)
            self.converters.level[rows] -= self.converters.quiet(warmth)[rows] - REST
        elif packet.kind == PacketKind.ASK:
            self._hello(device)
        else:
            result = UNKNOWN
        answer = CommandReply(int(packet.kind), result, packet.sequence)
        self._say(device, PacketKind.ANSWER, answer.payload)

    def _rows(self, board: int) -> slice:
        """Taxels of a device, among those of all patches."""
        return slice(*self._starts[board : board + 2].tolist())

    def _hello(self, device: Device) -> None:
        hello = Hello(
            channels=device.encoder.channels,
            period_us=round((1.0 / self._rate if self._rate else device.period) * 1e6),
            name=device.patch.name.encode()[:64].decode("utf-8", "ignore"),
        )
        self._say(device, PacketKind.HELLO, hello.payload)

    def _say(self, device: Device, kind: PacketKind, payload: bytes) -> None:
        packet = Packet(
            kind=kind,
            device=device.encoder.device,
            sequence=device.encoder.sequence,
            time_us=device.clock_us & 0xFFFFFFFF,
            payload=payload,
        )
        device.encoder.sequence = (device.encoder.sequence + 1) & 0xFFFFFFFF
        if not self._wire.off and self._wire.heard:
            self._wire.say(encode_packet(packet))

    def send(self, members: Sequence[int], now_ns: int) -> None:
        """See `Hardware`."""
        made = self._wire.made
        made.clear()
        for board in members:
            device = self.devices[board]
            values = np.full(device.patch.n_channels, REST)
            values[device.patch.channel] = self.converters.counts[self._rows(board)]
            for number, part in self.unplugged:
                if number == board:
                    gone = device.patch.module == self._modules[board][part]
                    values[device.patch.channel[gone]] = 0.0
            made += device.encoder.encode(values, device.clock_us)
        self.readings += len(members)
        self._wire.send(len(made))

    def _reset(self, board: int) -> None:
        self.devices[board].sending, self.devices[board].period = True, PERIOD

    def _awake(self, board: int, warmth: float) -> None:
        """Begin anew: the numbers of packets and readings, and the clock."""
        device, rows = self.devices[board], self._rows(board)
        device.booted_ns = monotonic_ns()
        device.encoder.sequence = device.encoder.reading = 0
        self.converters.level[rows] = REST
        self._hello(device)
