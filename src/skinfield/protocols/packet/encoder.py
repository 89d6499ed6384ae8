"""Whole readings to packets at full speed, for a skin in software."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.acquisition import Status
from skinfield.acquisition.block import Octets
from skinfield.errors import InputError, Ints, check_count, check_shape
from skinfield.protocols.packet.encode import DTYPES
from skinfield.protocols.packet.layout import (
    CRC_BYTES,
    HEADER_BYTES,
    LONGEST_PAYLOAD,
    WIDTH,
    PacketKind,
)

ETHERNET = 1472 - HEADER_BYTES - CRC_BYTES  # bytes of payload of a datagram that is not split up


class PacketEncoder:
    """Readings of one device to packets; nothing is allocated after the beginning.

    Parameters
    ----------
    channels : int
    kind : PacketKind
        BYTES, SHORTS, FLOATS or SIGNED.
    device : int
    payload : int, bytes
        At most, of one packet; the default fits an Ethernet of 1500 bytes.

    Attributes
    ----------
    octets : (B,) uint8 array
        The packets of the last reading, one after the other.
    offsets : (P + 1,) int64 array
        Packet i is `octets[offsets[i]:offsets[i + 1]]`.
    sequence, reading : int
        Numbers of the next packet and reading; whoever sends a HELLO in between adds 1.
    """

    def __init__(
        self,
        channels: int,
        kind: PacketKind = PacketKind.SHORTS,
        *,
        device: int = 1,
        payload: int = ETHERNET,
    ) -> None:
        check_count("channels", channels, 1, 65535, "of one device")
        check_count("device", device, 0, 0xFFFE, "65535 stands for all of them")
        if kind not in WIDTH:
            raise InputError(f"kind is {kind!r}, expected BYTES, SHORTS, FLOATS or SIGNED")
        self.kind = PacketKind(kind)
        width = WIDTH[self.kind]
        check_count("payload", payload, width, LONGEST_PAYLOAD, "bytes of a packet's payload")
        self.channels, self.device, self.per_packet = channels, device, payload // width
        packets = -(-channels // self.per_packet)
        self.octets: Octets = np.zeros(
            packets * (HEADER_BYTES + CRC_BYTES) + width * channels, np.uint8
        )
        self.offsets: Ints = np.zeros(packets + 1, np.int64)
        self._values: NDArray[np.generic] = np.zeros(channels, DTYPES[self.kind])
        self.sequence = self.reading = 0

    def encode(self, values: ArrayLike, time_us: int, status: Status = Status.OK) -> int:
        """Write the packets of one reading.

        Parameters
        ----------
        values : (channels,) array
            Within what the kind can hold; cast to its type.
        time_us : int, µs
            Of the device's clock.
        status : Status

        Returns
        -------
        int
            Packets.
        """
        from skinfield.protocols.packet.encode_kernel import encode_reading

        check_shape("values", np.asarray(values), (self.channels,), "one per channel")
        self._values[:] = values
        packets = encode_reading(
            self._values.view(np.uint8), WIDTH[self.kind], self.channels, int(self.kind),
            self.device, 0, self.per_packet, self.sequence, self.reading, time_us & 0xFFFFFFFF,
            int(status), self.octets, self.offsets,
        )  # fmt: skip
        self.sequence = (self.sequence + packets) & 0xFFFFFFFF
        self.reading = (self.reading + 1) & 0xFFFF
        return int(packets)

    def packet(self, index: int) -> Octets:
        """Bytes of packet `index` of the last reading, without copying."""
        return self.octets[self.offsets[index] : self.offsets[index + 1]]
