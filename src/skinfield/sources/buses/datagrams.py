"""Datagrams in batches: one system call takes in or sends all there are."""

import ctypes
import errno
import socket
from time import time_ns

import numpy as np

from skinfield.acquisition.block import Octets
from skinfield.errors import Ints
from skinfield.sources.buses.system import NAME, address_from_octets, address_octets, many_at_once

HEADER = 64  # bytes of struct mmsghdr
CONTROL = 64  # bytes for the control messages of a datagram: a stamp takes 32, drops 24
TRANSIENT = {  # of a send or a receive: nothing is broken, less or nothing went through
    errno.EAGAIN,
    errno.EWOULDBLOCK,
    errno.EINTR,
    errno.ENOBUFS,
    errno.ENOMEM,
    errno.ECONNREFUSED,  # nobody listens there now: datagrams ask for no answer
}


class Datagrams:
    """Room for a batch of datagrams; nothing is allocated after the beginning.

    Where the system has no `recvmmsg` and `sendmmsg`, one call per datagram does the same.

    Parameters
    ----------
    batch : int
        Datagrams of one call.
    size : int, bytes
        Of the longest datagram that is understood; longer ones are marked.

    Attributes
    ----------
    octets : (batch, size) uint8 array
    lengths : (batch,) int64 array
        -1 of a datagram that was longer than `size`.
    stamp_ns : (batch,) int64 array, ns
        When the kernel took it in, else when it was read.
    names : (batch, 32) uint8 array
        Addresses as struct sockaddr_in or sockaddr_in6: senders, after `receive`.
    bytes : int
        Of the last batch.
    """

    def __init__(self, batch: int, size: int) -> None:
        self.octets: Octets = np.zeros((batch, size), np.uint8)
        self.flat: Octets = self.octets.reshape(-1)
        self.lengths: Ints = np.zeros(batch, np.int64)
        self.stamp_ns: Ints = np.zeros(batch, np.int64)
        self.names: Octets = np.zeros((batch, NAME), np.uint8)
        self.bytes = 0
        self._control: Octets = np.zeros(batch * CONTROL, np.uint8)
        self._drops: Ints = np.zeros(2, np.int64)
        self._headers: Ints = np.zeros((batch, 8), np.int64)
        self._vectors: Ints = np.zeros((batch, 2), np.int64)
        self._receive = many_at_once("recvmmsg")
        self._send = many_at_once("sendmmsg")
        self._rows = [memoryview(row) for row in self.octets]
        self._point()
        self._warm()

    def _point(self) -> None:
        """Fill in what the headers point at."""
        batch, size = self.octets.shape
        steps = np.arange(batch)
        self._vectors[:, 0] = self.octets.ctypes.data + steps * size
        self._vectors[:, 1] = size
        self._headers[:, 0] = self.names.ctypes.data + steps * NAME
        self._headers[:, 1] = NAME
        self._headers[:, 2] = self._vectors.ctypes.data + steps * 16
        self._headers[:, 3] = 1
        self._headers[:, 4] = self._control.ctypes.data + steps * CONTROL
        self._headers[:, 5] = CONTROL
        self._pointer = self._headers.ctypes.data

    def _warm(self) -> None:
        """Compile before the first datagram comes."""
        from skinfield.sources.buses.datagram_kernel import take_headers

        self._take_headers = take_headers
        self._take(0, 0)

    def _take(self, count: int, now_ns: int) -> None:
        self.bytes = self._take_headers(
            self._headers,
            self._control,
            count,
            now_ns,
            self.lengths,
            self.stamp_ns,
            self._drops,
            NAME,
            CONTROL,
        )

    def __len__(self) -> int:
        return len(self.lengths)

    @property
    def dropped(self) -> int:
        """Datagrams that the kernel dropped for want of room, in all; 0 where it does not tell."""
        return int(self._drops[1])

    def of_new_socket(self) -> None:
        """Forget the count of an earlier socket; what was dropped stays counted."""
        self._drops[0] = 0

    def receive(self, sock: socket.socket, limit: int) -> int:
        """Take in up to `limit` datagrams that have arrived; never waits.

        Returns
        -------
        int
            Datagrams, or minus the errno of an error that is not transient.
        """
        limit = min(limit, len(self.lengths))
        if self._receive is None:
            return self._receive_singly(sock, limit)
        count = self._receive(sock.fileno(), self._pointer, limit, socket.MSG_DONTWAIT, None)
        if count > 0:
            self._take(count, time_ns())
            return count
        code = ctypes.get_errno() if count < 0 else 0
        if code == errno.ENOSYS:  # the library has it, the system does not
            self._receive = None
        return _verdict(code) if code != errno.ENOSYS else 0

    def _receive_singly(self, sock: socket.socket, limit: int) -> int:
        self.bytes = 0
        for i in range(limit):
            try:
                length, _, flags, sender = sock.recvmsg_into([self._rows[i]])
            except OSError as error:
                return i or _verdict(error.errno or errno.EIO)
            self.bytes += length
            self.lengths[i] = -1 if flags & socket.MSG_TRUNC else length
            self.stamp_ns[i] = time_ns()
            if sock.family in (socket.AF_INET, socket.AF_INET6) and sender:
                name = np.frombuffer(address_octets(sock.family, sender), np.uint8)
                self.names[i, : len(name)] = name
        return limit

    def address(self, name: Octets) -> None:
        """Address all datagrams to `name`, the octets of a struct sockaddr_in or sockaddr_in6."""
        self.names[:, : len(name)] = name
        family = int(self.names[0, 0])
        self._headers[:, 1] = 28 if family == socket.AF_INET6 else 16

    def send(self, sock: socket.socket, count: int, connected: bool) -> int:
        """Send the first `count` datagrams of `lengths`; never waits.

        Parameters
        ----------
        connected : bool
            Whether the socket knows where to, else what `address` was given last.

        Returns
        -------
        int
            Datagrams that the system took, or minus the errno of an error that is not transient.
        """
        if self._send is None:
            return self._send_singly(sock, count, connected)
        self._vectors[:count, 1] = self.lengths[:count]
        self._headers[:count, 5] = 0
        if connected:
            self._headers[:count, 1] = 0
        done = 0
        while done < count:
            sent = self._send(
                sock.fileno(), self._pointer + done * HEADER, count - done, socket.MSG_DONTWAIT
            )
            if sent <= 0:
                code = ctypes.get_errno()
                if code == errno.ENOSYS:
                    self._send = None
                    return self._send_singly(sock, count, connected)
                return done or _verdict(code)
            done += sent
        return done

    def _send_singly(self, sock: socket.socket, count: int, connected: bool) -> int:
        for i in range(count):
            octets = self._rows[i][: self.lengths[i]]
            try:
                if connected:
                    sock.send(octets)
                else:
                    sock.sendto(octets, address_from_octets(self.names[i].tobytes()))
            except OSError as error:
                return i or _verdict(error.errno or errno.EIO)
        return count


def _verdict(code: int) -> int:
    return 0 if code == 0 or code in TRANSIENT else -code
