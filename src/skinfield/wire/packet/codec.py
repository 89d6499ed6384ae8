"""Codec of packets: datagrams and streams of bytes to blocks, readings to packets."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import InputError, Ints, check_count, check_shape
from skinfield.signal import Blocks, Count, Status
from skinfield.signal.block import Octets
from skinfield.wire.packet.packets import (
    CRC_BYTES,
    DTYPES,
    HEADER_BYTES,
    Packet,
    PacketFlag,
    PacketKind,
    encode_counts,
)


@dataclass(frozen=True)
class PacketDevice:
    """One device, whose channels follow those of the device before it.

    Parameters
    ----------
    number : int
        That its packets carry.
    channels : int
        Packets with others are counted as foreign.
    name : str
        Of its port; default "skin", or "device<number>" of several.
    """

    number: int
    channels: int
    name: str = ""

    def __post_init__(self) -> None:
        check_count("number of a device", self.number, 0, 0xFFFE, "65535 stands for all of them")
        check_count("channels of a device", self.channels, 1, 65535, "taxels and dummies")

    @staticmethod
    def several(devices: "Sequence[PacketDevice] | int") -> "tuple[PacketDevice, ...]":
        """Devices; a number stands for device 1 with so many channels."""
        return (PacketDevice(1, devices),) if isinstance(devices, int) else tuple(devices)


class PacketDecoder:
    """Packets of some devices to blocks; nothing is allocated after the beginning.

    Every packet is one of `RECEIVED` and `FOREIGN`: of another device, a command, or with channels
    that the device has not. Bytes that are no packet are `MALFORMED`. Of those received some may be
    `DUPLICATED` or `SWAPPED`. `READINGS`, `LOST` and `BYTES` are counted too; the other counters
    are the connection's. What came twice becomes no blocks. A late packet becomes blocks whose
    stamps are as much older as the device's clock says, at most a second.

    Parameters
    ----------
    devices : sequence of PacketDevice, or int
        In the order of their channels; see `PacketDevice.several`.
    """

    def __init__(self, devices: Sequence[PacketDevice] | int) -> None:
        from skinfield.wire.packet.kernel import CHANNELS, COLUMNS, OFFSET, WINDOW

        self.devices = PacketDevice.several(devices)
        numbers = [device.number for device in self.devices]
        if not numbers or len(set(numbers)) < len(numbers):
            raise InputError(f"devices have the numbers {numbers}, expected one or more, each once")
        count = len(numbers)
        slots: NDArray[np.int32] = np.full(65536, -1, np.int32)
        slots[numbers] = np.arange(count)
        self.state: Ints = np.zeros((count, COLUMNS), np.int64)
        channels = [device.channels for device in self.devices]
        self.state[:, CHANNELS] = channels
        self.state[:, OFFSET] = np.cumsum([0, *channels[:-1]])
        self.channels = sum(channels)  # of all devices
        window, marks = np.zeros((count, WINDOW), np.int64), np.zeros(self.channels, np.uint8)
        self.tables = slots, self.state, window, marks  # as the kernels take them
        self._torn: Ints = np.zeros(1, np.int64)

    def decode_many(
        self,
        datagrams: Octets,
        lengths: Ints,
        stamp_ns: Ints,
        first: int,
        last: int,
        blocks: Blocks,
        channel: int,
        counters: Ints,
    ) -> int:
        """Append what datagrams `first` to `last` (exclusive) bring, each whole or not at all.

        Parameters
        ----------
        datagrams : (N, L) uint8 array
        lengths : (N,) int64 array
        stamp_ns : (N,) int64 array, ns
            When each came in.
        first, last : int
        blocks : Blocks
        channel : int
            Of the first device's first channel.
        counters : (len(Count),) int64 array

        Returns
        -------
        int
            The first that was left because the blocks might not hold it; `last` if none was.
        """
        from skinfield.wire.packet.kernel import decode_packets

        last = min(last, len(datagrams), len(lengths), len(stamp_ns))
        into = blocks.words, blocks.octets, blocks.singles, blocks.end
        left, _ = decode_packets(
            datagrams, lengths, stamp_ns, first, last, True, self._torn, into, channel,
            self.tables, counters,
        )  # fmt: skip
        return int(left)


BUFFER = 1 << 18  # bytes; what arrives between two polls must fit


class PacketScanner:
    """Packets out of a stream of bytes, found again after whatever was damaged.

    Bytes are received straight into `free`, and `take` is told how many. What is left of a packet
    that is not whole stays for the next call. Each run of bytes that are no packet is counted once
    as `MALFORMED`.

    Parameters
    ----------
    decoder : PacketDecoder
    """

    def __init__(self, decoder: PacketDecoder) -> None:
        self.decoder = decoder
        self.octets: Octets = np.zeros(BUFFER, np.uint8)
        self.used = 0
        self._rows = self.octets[np.newaxis]  # as one datagram that goes on and on
        self._lengths: Ints = np.zeros(1, np.int64)
        self._stamps: Ints = np.zeros(1, np.int64)
        self._torn: Ints = np.zeros(1, np.int64)

    @property
    def free(self) -> Octets:
        """Where the next bytes belong: pass it to `recv_into` or `readinto`; may be empty."""
        return self.octets[self.used :]

    def take(self, received: int, blocks: Blocks, channel: int, counters: Ints, now_ns: int) -> int:
        """Append what the bytes bring that were put into `free`.

        Parameters
        ----------
        received : int
            Bytes; 0 to go on with those that had no room in the blocks before.
        blocks, channel, counters
            As for `PacketDecoder.decode_many`.
        now_ns : int, ns
            Stamp of the blocks.

        Returns
        -------
        int
            Bytes that are done with.
        """
        from skinfield.wire.packet.kernel import decode_packets

        check_count("received", received, 0, len(self.octets) - self.used, "bytes put into `free`")
        used = self.used + received
        self._lengths[0], self._stamps[0] = used, now_ns
        into = blocks.words, blocks.octets, blocks.singles, blocks.end
        _, at = decode_packets(
            self._rows, self._lengths, self._stamps, 0, 1, False, self._torn, into, channel,
            self.decoder.tables, counters,
        )  # fmt: skip
        counters[Count.BYTES] += received
        if at:
            self.octets[: used - at] = self.octets[at:used]
        self.used = used - at
        return int(at)

    def forget(self) -> None:
        """Drop the half packet of a connection that broke."""
        self.used = 0
        self._torn[0] = 0


ETHERNET = 1472 - HEADER_BYTES - CRC_BYTES  # bytes of payload of a datagram that is not split up


class PacketEncoder:
    """Readings of one device to packets, in plain Python: for devices in software.

    Parameters
    ----------
    channels : int
    kind : PacketKind
        BYTES, SHORTS, FLOATS or SIGNED.
    device : int

    Attributes
    ----------
    sequence, reading : int
        Numbers of the next packet and reading; whoever sends a HELLO in between adds 1.
    """

    def __init__(
        self, channels: int, kind: PacketKind = PacketKind.SHORTS, *, device: int = 1
    ) -> None:
        PacketDevice(device, channels)  # refuses what cannot be
        if kind not in DTYPES:
            raise InputError(f"kind is {kind!r}, expected BYTES, SHORTS, FLOATS or SIGNED")
        self.kind = PacketKind(kind)
        self.channels, self.device = channels, device
        self.per_packet = ETHERNET // DTYPES[self.kind].itemsize
        self.sequence = self.reading = 0

    def encode(self, values: ArrayLike, time_us: int, status: Status = Status.OK) -> list[bytes]:
        """Packets of one reading.

        Parameters
        ----------
        values : (channels,) array
            Within what the kind can hold; cast to its type.
        time_us : int, µs
            Of the device's clock.
        status : Status
        """
        array = np.asarray(values)
        check_shape("values", array, (self.channels,), "one per channel")
        packets = []
        for first in range(0, self.channels, self.per_packet):
            part = array[first : first + self.per_packet]
            last = first + len(part) == self.channels
            packet = Packet(
                kind=self.kind, device=self.device, sequence=self.sequence, time_us=time_us,
                channel=first, reading=self.reading, status=status,
                flags=PacketFlag.LAST if last else PacketFlag.NONE,
            )  # fmt: skip
            packets.append(encode_counts(part, packet))
            self.sequence = (self.sequence + 1) & 0xFFFFFFFF
        self.reading = (self.reading + 1) & 0xFFFF
        return packets
