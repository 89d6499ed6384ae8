"""Packets of microcontrollers over UDP."""

import os
import socket
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skinfield.acquisition import Blocks, Count
from skinfield.errors import check_count
from skinfield.protocols.packet import PacketDevice
from skinfield.sources.buses.datagrams import Datagrams
from skinfield.sources.buses.settings import BusSettings
from skinfield.sources.buses.system import address_octets, buffer_note
from skinfield.sources.buses.udp_sockets import let_go, peer_of, resolved, unicast_socket
from skinfield.sources.live.packet_stream import PacketStream, checked_devices

BATCH = 64  # datagrams of one system call
LONGEST = 65536  # bytes of a datagram
ROUNDS = 16  # of a poll
PORT = 43210


@dataclass(frozen=True)
class PacketUdp:
    """Devices that send packets by UDP.

    Parameters
    ----------
    devices : sequence of PacketDevice, or int
        A number: one device, of number 1, with so many channels.
    host : str
        Own address that is bound. The default hears this machine only; 0.0.0.0 hears all.
    port : int
        Own port that is bound; 0 takes a free one.
    peer : str
        ``host:port`` of a device that is told to start, and to stop at the end. Left empty, devices
        send by themselves.
    names : sequence of str
        Of the devices' ports; default "skin", or "device<number>" of several.
    unit : str
        Of the numbers, one of `skinfield.reading.UNITS`.
    """

    devices: Sequence[PacketDevice] | int
    host: str = "127.0.0.1"
    port: int = PORT
    peer: str = ""
    names: Sequence[str] = ()
    unit: str = "count"

    def __post_init__(self) -> None:
        object.__setattr__(self, "devices", checked_devices(self.devices))
        object.__setattr__(self, "names", tuple(self.names))
        check_count("port", self.port, 0, 65535, "of UDP")

    def open(self) -> "PacketUdpStream":
        """Bind the port.

        Raises
        ------
        InputError
            If an address is not understood.
        """
        return PacketUdpStream(self)


class UdpLink:
    """A bound socket that takes in datagrams in batches."""

    def __init__(self, settings: PacketUdp) -> None:
        self._own = resolved(settings.host, settings.port, "host")
        peer = peer_of(BusSettings("udp", peer=settings.peer))
        self.batch = Datagrams(BATCH, LONGEST)
        self._out = Datagrams(1, LONGEST)
        self.has_peer = peer is not None
        if peer is not None:
            self._out.address(np.frombuffer(address_octets(peer.family, peer.address), np.uint8))
        self._socket: socket.socket | None = None
        self.up, self.fault, self.buffer_bytes = False, "", 0
        self.reopen()

    @property
    def address(self) -> tuple[str, int]:
        """Host and port at which it listens; ("", 0) while it is down."""
        if self._socket is None:
            return "", 0
        host, port = self._socket.getsockname()[:2]
        return str(host), int(port)

    @property
    def note(self) -> str:
        """What should be known of it, in words."""
        return buffer_note(f"udp {self._own.address}", self.buffer_bytes)

    def reopen(self) -> bool:
        """Bind anew."""
        self.close()
        try:
            self._socket, self.buffer_bytes = unicast_socket(self._own)
        except OSError as error:
            self.fault = f"udp {self._own.address}: {error.strerror or error}"
            return False
        self.batch.of_new_socket()
        self.up, self.fault = True, ""
        return True

    def receive(self) -> int:
        """Fill the batch; how many datagrams."""
        count = self.batch.receive(self._socket, BATCH) if self._socket is not None else 0
        return count if count >= 0 else self._broke(-count)

    def send(self, packet: bytes) -> None:
        """Send one datagram to the peer."""
        if self._socket is not None and self.has_peer:
            self._out.octets[0, : len(packet)] = np.frombuffer(packet, np.uint8)
            self._out.lengths[0] = len(packet)
            sent = self._out.send(self._socket, 1, connected=False)
            if sent < 0:
                self._broke(-sent)

    def _broke(self, code: int) -> int:
        self.close()
        self.fault = f"udp {self._own.address}: {os.strerror(code)}"
        return 0

    def filenos(self) -> Sequence[int]:
        """Of the socket."""
        return (self._socket.fileno(),) if self._socket is not None else ()

    def close(self) -> None:
        """Let go of the socket."""
        let_go(self._socket)
        self._socket, self.up = None, False


class PacketUdpStream(PacketStream):
    """See `PacketStream`."""

    def __init__(self, source: PacketUdp) -> None:
        self._link = UdpLink(source)
        devices = checked_devices(source.devices)
        try:
            super().__init__(devices, source.names, source.unit, self._link, self._link.has_peer)
            self._first = self._count = self._overflowed = 0
            self._decode(Blocks(1024), 0)  # compiles before the first packet
        except BaseException:
            self._link.close()
            raise

    @property
    def address(self) -> tuple[str, int]:
        """Host and port at which it listens."""
        return self._link.address

    def _take_packets(self, blocks: Blocks, channel: int, now_ns: int) -> None:
        for _ in range(ROUNDS):
            if self._first == self._count:
                self._first, self._count = 0, self._link.receive()
                if not self._count:
                    break
            self._decode(blocks, channel)
            if self._first < self._count or self._count < BATCH:
                break  # the blocks are full, or nothing more waits
        self._overflowed = self._count_since(
            Count.OVERFLOWED, self._link.batch.dropped, self._overflowed
        )

    def _decode(self, blocks: Blocks, channel: int) -> None:
        batch = self._link.batch
        self._first = self.decoder.decode_many(
            batch.octets,
            batch.lengths,
            batch.stamp_ns,
            self._first,
            self._count,
            blocks,
            channel,
            self.counters,
        )

    def _tell_device(self, packet: bytes) -> None:
        self._link.send(packet)
