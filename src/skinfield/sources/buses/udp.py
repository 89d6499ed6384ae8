"""A CAN bus over UDP, to a multicast group or to one address, in python-can's own format."""

import socket
from collections.abc import Sequence

import numpy as np

from skinfield.acquisition.block import Octets
from skinfield.acquisition.can import CanMessages
from skinfield.errors import InputError
from skinfield.sources.buses.batched import BatchedBus
from skinfield.sources.buses.datagrams import Datagrams
from skinfield.sources.buses.rows import check_rows
from skinfield.sources.buses.settings import BusSettings
from skinfield.sources.buses.system import NAME, address_octets
from skinfield.sources.buses.udp_sockets import (
    Place,
    group_of,
    let_go,
    multicast_receiver,
    multicast_sender,
    peer_of,
    resolved,
    unicast_socket,
)

BATCH = 128  # datagrams of one system call
LONGEST = 512  # bytes of a datagram: python-can's are below 240, even of CAN FD


class UdpBus(BatchedBus):
    """See `Bus` and `BusSettings`; what it sent itself does not come back to it."""

    def __init__(self, settings: BusSettings) -> None:
        from skinfield.sources.buses.can_map_kernel import unpack_messages
        from skinfield.sources.buses.can_pack_kernel import ENCODED, pack_messages

        self._unpack, self._pack = unpack_messages, pack_messages
        super().__init__(settings, Datagrams(BATCH, LONGEST), Datagrams(BATCH, ENCODED))
        self._group: Place | None = None
        self._peer: Place | None = None
        if settings.interface == "udp_multicast":
            self._group = group_of(settings)
        else:
            self._own = resolved(settings.channel or "127.0.0.1", settings.port, "channel")
            self._peer = peer_of(settings)
        self._own_name: Octets = np.zeros(NAME, np.uint8)
        self._seconds = np.zeros(1)
        self._receiver: socket.socket | None = None
        self._sender: socket.socket | None = None
        self._addressed = False  # whether somebody is known to send to
        self._warm()
        self.reopen()

    def _warm(self) -> None:
        """Compile before the first message."""
        self._take(0, self._one, 0)
        self._encode(self._one, 0, 0)

    @property
    def address(self) -> tuple[str, int]:
        """Host and port at which it listens; ("", 0) while it is down."""
        if self._receiver is None:
            return "", 0
        host, port = self._receiver.getsockname()[:2]
        return str(host), int(port)

    def reopen(self) -> bool:
        """Open the sockets anew."""
        self._release()
        try:
            if self._group is not None:
                self._open_group(self._group)
            else:
                self._open_unicast()
        except OSError as error:
            self._release()
            self.fault = f"{self.settings.label}: {error.strerror or error}"
            return False
        self._in.of_new_socket()
        self.up, self.fault = True, ""
        return True

    def _open_group(self, group: Place) -> None:
        local = self.settings.local
        self._receiver, self.buffer_bytes = multicast_receiver(group, local)
        self._sender = multicast_sender(group, local)
        name = address_octets(group.family, self._sender.getsockname())
        self._own_name[: len(name)] = np.frombuffer(name, np.uint8)

    def _open_unicast(self) -> None:
        if self._peer is not None and self._peer.family != self._own.family:
            raise InputError(
                f"peer is {self.settings.peer!r} and channel {self.settings.channel!r}, expected "
                "both of IPv4 or both of IPv6"
            )
        self._receiver, self.buffer_bytes = unicast_socket(self._own)
        self._sender = self._receiver
        if self._peer is not None:
            name = address_octets(self._peer.family, self._peer.address)
            self._out.address(np.frombuffer(name, np.uint8))
            self._addressed = True
            # an empty datagram tells a host that only answers where to answer to
            self._out.lengths[0] = 0
            self._out.send(self._sender, 1, connected=False)

    def receive(self, into: CanMessages, first: int = 0) -> int:
        """Take in what has arrived."""
        at, room = first, len(into)
        while self.up and at < room and self._receiver is not None:
            limit = min(BATCH, room - at)
            count = self._in.receive(self._receiver, limit)
            if count < 0:
                self._broke(-count)
                break
            if count:
                self.octets += self._in.bytes
                at = self._take(count, into, at)
                self._note_sender(count)
            if count < limit:
                break
        return at - first

    def _take(self, count: int, into: CanMessages, at: int) -> int:
        batch = self._in
        return int(
            self._unpack(
                batch.flat,
                LONGEST,
                batch.lengths,
                batch.stamp_ns,
                batch.names,
                self._own_name,
                count,
                at,
                into.ids,
                into.lengths,
                into.data,
                into.stamp_ns,
                self._counts,
            )
        )

    def _note_sender(self, count: int) -> None:
        """Without a peer that is configured, answers go to whoever sent last."""
        if self._group is None and self._peer is None:
            name = self._in.names[count - 1]
            if not self._addressed or (name != self._out.names[0]).any():
                self._out.address(name)
                self._addressed = True

    def send_many(self, messages: CanMessages, count: int, first: int = 0) -> int:
        """Send rows of `messages`."""
        done = 0
        check_rows(messages, first, count)
        connected = self._group is not None
        while done < count and self._sender is not None and (connected or self._addressed):
            part = min(BATCH, count - done)
            self._encode(messages, first + done, part)
            sent = self._out.send(self._sender, part, connected)
            if sent < 0:
                self._broke(-sent)
                break
            done += sent
            if sent < part:
                break
        return done

    def _encode(self, messages: CanMessages, first: int, count: int) -> None:
        self._pack(
            messages.ids,
            messages.lengths,
            messages.data,
            messages.stamp_ns,
            first,
            count,
            self._out.flat,
            self._out.octets.shape[1],
            self._out.lengths,
            self._seconds,
            self._seconds.view(np.int64),
        )

    def filenos(self) -> Sequence[int]:
        """Of the socket that receives."""
        return (self._receiver.fileno(),) if self._receiver is not None else ()

    def _release(self) -> None:
        if self._sender is not self._receiver:
            let_go(self._sender)
        let_go(self._receiver)
        self._receiver = self._sender = None
        self.up = False
