"""Microcontrollers that send packets: one for each patch."""

from collections.abc import Mapping, Sequence
from time import monotonic_ns
from typing import Any

import numpy as np

from skinfield.layout import Skin
from skinfield.protocols.packet import (
    EVERY_DEVICE,
    Answer,
    Hello,
    Packet,
    PacketKind,
    encode_packet,
)
from skinfield.virtual.delivery import FAULTS, Fates, chances_of
from skinfield.virtual.electronics import (
    Converters,
    starts_of,
)
from skinfield.virtual.links import open_link
from skinfield.virtual.packet_device import PERIOD, REST, Device, device_of, packet_converters
from skinfield.virtual.packet_ear import Ear
from skinfield.virtual.patch_faults import PatchFaults
from skinfield.virtual.schedule import Schedule
from skinfield.virtual.settings import VirtualSettings

DONE, UNKNOWN = 0, 1  # results of a command
FASTEST_US = 50


class PacketDevices(PatchFaults[Device]):
    """See `hardware.Hardware`.

    Parameters
    ----------
    skin : Skin
    settings : VirtualSettings
    """

    def __init__(self, skin: Skin, settings: VirtualSettings) -> None:
        rng = np.random.default_rng([settings.seed, 2])
        super().__init__("device", [device_of(patch, n) for n, patch in enumerate(skin, 1)])
        self._starts = starts_of(skin)
        self.converters: Converters = packet_converters(skin, settings)
        self._base = self.converters.level.copy()
        self.schedule = Schedule(settings.spread, settings.wires.jitter, rng)
        self._rate = settings.rate
        packets = sum(len(device.encoder.offsets) for device in self.devices)
        self._fates = Fates(packets, settings.wires, rng)
        self._kept = b""
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
            self._send(packets[index] if index >= 0 else memoryview(self._kept))
        kept = int(self._fates.kept[0])
        if kept >= 0:
            self._kept = bytes(packets[kept])
            self._fates.kept[0] = -1

    def _send(self, packet: memoryview) -> None:
        if self._link.send(packet):
            self.sent += 1
        else:
            self.refused += 1

    def _went(self, device: Device) -> None:
        device.sending, device.period = True, PERIOD

    def _booted(self, device: Device) -> None:
        """Begin anew: the numbers of packets and readings, and the clock."""
        device.booted_ns = monotonic_ns()
        device.encoder.sequence = device.encoder.reading = 0
        place = self.devices.index(device)
        rows = slice(int(self._starts[place]), int(self._starts[place + 1]))
        self.converters.level[rows] = self._base[rows]
        self._hello(device)

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
        if self._fates.kept[0] == -1 and self._kept and not self.off:
            self._send(memoryview(self._kept))
        self._link.close()
