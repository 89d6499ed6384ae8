"""Microcontrollers that send packets: one for each patch."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from time import monotonic_ns
from typing import Any

import numpy as np

from skinfield.emulator.can_boards import FAULTS, Fates, Schedule, chances_of
from skinfield.emulator.electronics import Converters, converters_from, starts_of
from skinfield.emulator.settings import VirtualSettings, numbers_of
from skinfield.emulator.transports import open_link
from skinfield.errors import Floats, InputError
from skinfield.skin import Patch, Skin
from skinfield.wire.packet import (
    COMMANDS,
    EVERY_DEVICE,
    Answer,
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
    number : int
    encoder : PacketEncoder
    values : (n_channels,) array
    period : float, s
    sending, quiet : bool
    """

    patch: Patch
    number: int
    encoder: PacketEncoder
    values: Floats
    period: float = PERIOD
    sending: bool = True
    quiet: bool = False
    unplugged: set[int] = field(default_factory=set)
    booted_ns: int = field(default_factory=monotonic_ns)

    @property
    def clock_us(self) -> int:
        """Of its own clock."""
        return (monotonic_ns() - self.booted_ns) // 1000


def device_of(patch: Patch, number: int) -> Device:
    """A device for a patch."""
    if patch.n_channels > 65535:
        raise InputError(
            f"patch {patch.name!r} has {patch.n_channels} channels, expected up to 65535 for "
            "packets: split it up"
        )
    encoder = PacketEncoder(patch.n_channels, device=number)
    encoder.encode(np.zeros(patch.n_channels), 0)  # compiles before the first reading
    encoder.sequence = encoder.reading = 0
    return Device(patch, number, encoder, np.full(patch.n_channels, REST))


def packet_converters(skin: Skin, settings: VirtualSettings) -> Converters:
    """Counts of the taxels of all patches."""
    return converters_from(skin, settings, REST, 65535.0)


class Ear:
    """Finds whole commands in a stream; what is none is passed over."""

    def __init__(self) -> None:
        self._bytes = b""

    def packets(self, more: bytes) -> Iterator[Packet]:
        """Commands that are whole with these bytes."""
        self._bytes = (self._bytes + more)[-4 * LONGEST :]
        for _ in range(MOST):
            at = self._bytes.find(MAGIC)
            if at < 0:
                self._bytes = self._bytes[-1:]  # the letter that may begin the next
                return
            self._bytes = self._bytes[at:]
            if len(self._bytes) < HEADER_BYTES + CRC_BYTES:
                return
            try:
                packet = packet_from_bytes(self._bytes)
            except InputError:
                if self._is_cut():
                    return
                self._bytes = self._bytes[1:]
                continue
            self._bytes = self._bytes[HEADER_BYTES + len(packet.payload) + CRC_BYTES :]
            if packet.kind in COMMANDS:
                yield packet

    def _is_cut(self) -> bool:
        """Whether the packet at the beginning may be whole with more bytes."""
        length = int.from_bytes(self._bytes[6:8], "little")
        whole = HEADER_BYTES + length + CRC_BYTES
        return len(self._bytes) < whole <= LONGEST


class PacketDevices:
    """See `skin.Hardware`.

    Parameters
    ----------
    skin : Skin
    settings : VirtualSettings
    """

    def __init__(self, skin: Skin, settings: VirtualSettings) -> None:
        rng = np.random.default_rng([settings.seed, 2])
        self.devices = [device_of(patch, n) for n, patch in enumerate(skin, 1)]
        self.off, self.reboots = False, 0
        self._starts = starts_of(skin)
        self.converters: Converters = packet_converters(skin, settings)
        self._base = self.converters.level.copy()
        self.schedule = Schedule(settings.spread, settings.wires.jitter, rng)
        self._rate = settings.rate
        packets = sum(len(device.encoder.offsets) for device in self.devices)
        self._fates = Fates(packets, settings.wires, rng)
        self._waiting = b""
        self._ear = Ear()
        self.readings = self.commands = self.sent = self.refused = self.withheld = 0
        self._link = open_link(settings)

    @property
    def addresses(self) -> list[str]:
        """See `Hardware`."""
        return [self._link.address]

    @property
    def chances(self) -> Mapping[str, float]:
        """See `Hardware`."""
        return chances_of(self._fates)

    def start(self, now_ns: int) -> None:
        """See `Hardware`; each device says what it is first."""
        for device in self.devices:
            self._hello(device)
        self._reschedule(now_ns)

    def _reschedule(self, now_ns: int) -> None:
        periods = {
            place: round(1e9 / self._rate if self._rate else 1e9 * device.period)
            for place, device in enumerate(self.devices)
            if device.sending and not device.quiet
        }
        self.schedule.set(periods if self._link.heard else {}, len(self.devices), now_ns)

    def filenos(self) -> Sequence[int]:
        """See `Hardware`."""
        return self._link.filenos()

    def listen(self, now_ns: int, warmth: float) -> None:
        """See `Hardware`."""
        before = self._link.heard
        for packet in self._ear.packets(self._link.receive()):
            for device in self.devices:
                if packet.device in (device.number, EVERY_DEVICE) and not device.quiet:
                    self._obey(device, packet, warmth)
        if self._link.heard and not before:
            for device in self.devices:
                self._hello(device)
        self._reschedule(now_ns)

    def _obey(self, device: Device, packet: Packet, warmth: float) -> None:
        self.commands += 1
        result = DONE
        if packet.kind in (PacketKind.START, PacketKind.STOP):
            device.sending = packet.kind == PacketKind.START
        elif packet.kind == PacketKind.PERIOD and len(packet.payload) >= 4:
            micros = int.from_bytes(packet.payload[:4], "little")
            device.period = max(micros, FASTEST_US) * 1e-6
        elif packet.kind == PacketKind.TARE:
            place = self.devices.index(device)
            rows = slice(int(self._starts[place]), int(self._starts[place + 1]))
            offset = self.converters.quiet(warmth)[rows] - REST
            self.converters.level[rows] -= offset
        elif packet.kind == PacketKind.ASK:
            self._hello(device)
        else:
            result = UNKNOWN
        answer = Answer(int(packet.kind), result, packet.sequence)
        self._say(device, PacketKind.ANSWER, answer.payload)

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
            device=device.number,
            sequence=device.encoder.sequence,
            time_us=device.clock_us & 0xFFFFFFFF,
            payload=payload,
        )
        device.encoder.sequence = (device.encoder.sequence + 1) & 0xFFFFFFFF
        if not self.off and self._link.heard:
            self._send(memoryview(encode_packet(packet)))

    def send(self, members: Sequence[int], now_ns: int) -> None:
        """See `Hardware`."""
        packets: list[memoryview] = []
        for place in members:
            device = self.devices[place]
            first, last = self._starts[place], self._starts[place + 1]
            device.values[device.patch.channel] = self.converters.counts[first:last]
            for module in device.unplugged:
                device.values[device.patch.channel[device.patch.module == module]] = 0.0
            for index in range(device.encoder.encode(device.values, device.clock_us)):
                packets.append(device.encoder.packet(index).data)
        self.readings += len(members)
        if self.off:
            self.withheld += len(packets)
        elif self._fates.idle:
            for packet in packets:
                self._send(packet)
        else:
            self._send_by_fate(packets)

    def _send_by_fate(self, packets: list[memoryview]) -> None:
        going = self._fates.draw(len(packets))
        for index in self._fates.order[:going].tolist():
            self._send(packets[index] if index >= 0 else memoryview(self._waiting))
        waiting = int(self._fates.waiting[0])
        if waiting >= 0:
            self._waiting = bytes(packets[waiting])
            self._fates.waiting[0] = -1

    def _send(self, packet: memoryview) -> None:
        if self._link.send(packet):
            self.sent += 1
        else:
            self.refused += 1

    def _boot(self, device: Device) -> None:
        """Begin anew: the numbers of packets and readings, and the clock."""
        device.booted_ns = monotonic_ns()
        device.encoder.sequence = device.encoder.reading = 0
        place = self.devices.index(device)
        rows = slice(int(self._starts[place]), int(self._starts[place + 1]))
        self.converters.level[rows] = self._base[rows]
        self._hello(device)

    def check(self, kind: str, what: str) -> None:
        """See `Hardware`."""
        if kind == "unplug":
            self._modules(what)
        elif kind == "bus-off":
            numbers_of(what, 1, "bus")
        else:
            self._devices(what)

    def begin(self, kind: str, what: str, now_ns: int) -> None:
        """See `Hardware`."""
        self.check(kind, what)
        if kind == "unplug":
            for device, module in self._modules(what):
                device.unplugged.add(module)
        elif kind == "bus-off":
            self.off = True
        else:
            for device in self._devices(what):
                device.quiet, device.sending, device.period = True, True, PERIOD
                self.reboots += 1
            self._reschedule(now_ns)

    def end(self, kind: str, what: str, now_ns: int, warmth: float) -> None:
        """See `Hardware`."""
        if kind == "unplug":
            for device, module in self._modules(what):
                device.unplugged.discard(module)
        elif kind == "bus-off":
            self.off = False
        else:
            for device in self._devices(what):
                device.quiet = False
                self._boot(device)
            self._reschedule(now_ns)

    def _devices(self, what: str) -> list[Device]:
        return [self.devices[n] for n in numbers_of(what, len(self.devices), "device")]

    def _modules(self, what: str) -> list[tuple[Device, int]]:
        """Modules of device 0, as ``"3"``, or of the named one, as ``"1.3"``."""
        first, dot, second = what.partition(".")
        found = []
        for device in self._devices(first) if dot else self.devices[:1]:
            modules = np.unique(device.patch.module).tolist()
            for place in numbers_of(second if dot else first, len(modules), "module"):
                found.append((device, int(modules[place])))
        return found

    def set_chances(self, lose: float, duplicate: float, swap: float) -> None:
        """See `Hardware`."""
        self._fates.chances[:] = lose, duplicate, swap

    def counts(self) -> dict[str, Any]:
        """See `Hardware`."""
        return {
            "messages": self.sent,
            **{name: int(self._fates.counts[i]) for i, name in enumerate(FAULTS)},
            "refused": self.refused,
            "withheld": self.withheld,
            "commands": self.commands,
            "reboots": self.reboots,
        }

    def close(self) -> None:
        """See `Hardware`."""
        if self._fates.waiting[0] == -1 and self._waiting and not self.off:
            self._send(memoryview(self._waiting))
        self._link.close()
