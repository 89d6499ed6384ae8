"""Linux's own CAN, raw: all messages that wait in one system call.

Layouts are those of linux/can.h and linux/can/raw.h. This was tested on the bytes, through sockets
of another family; no real bus was at hand.
"""

import errno
import os
import socket
import struct
from collections.abc import Sequence

import numpy as np

from skinfield.acquisition.can import CanMessages
from skinfield.errors import InputError
from skinfield.sources.buses.batched import BatchedBus
from skinfield.sources.buses.datagrams import Datagrams
from skinfield.sources.buses.rows import check_rows
from skinfield.sources.buses.settings import BusSettings
from skinfield.sources.buses.system import set_options
from skinfield.sources.buses.udp_sockets import let_go

BATCH = 256  # messages of one system call
SOL_CAN_RAW, CAN_RAW_ERR_FILTER = 101, 2
ERRORS_OF_INTEREST = 0x1FFFFFFF  # CAN_ERR_MASK: all kinds
ABSENT = {errno.ENODEV, errno.ENETDOWN, errno.ENXIO}  # no such device now, or not set up


class SocketCanBus(BatchedBus):
    """See `Bus` and `BusSettings`.

    Parameters
    ----------
    settings : BusSettings
    sock : socket, optional
        An open one in place of a CAN device; for tests of the bytes.
    """

    def __init__(self, settings: BusSettings, sock: socket.socket | None = None) -> None:
        from skinfield.sources.buses.socketcan_kernel import (
            STRUCT,
            messages_of_structs,
            structs_of_messages,
        )

        self._read, self._write = messages_of_structs, structs_of_messages
        super().__init__(settings, Datagrams(BATCH, STRUCT), Datagrams(BATCH, STRUCT))
        self._socket: socket.socket | None = None
        self._words_in = self._in.flat.view(np.uint32)
        self._words_out = self._out.flat.view(np.uint32)
        self._take(0, self._one, 0)  # compiles before the first message
        self._encode(self._one, 0, 0)
        if sock is None:
            _check_system()
            self.reopen()
        else:
            self._use(sock)

    def reopen(self) -> bool:
        """Open the socket anew."""
        self._release()
        device = self.settings.channel or "can0"
        try:
            sock = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        except OSError as error:
            self.fault = f"{self.settings.label}: {error.strerror or error}"
            return False
        try:
            sock.setsockopt(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, struct.pack("=I", ERRORS_OF_INTEREST))
            sock.bind((device,))
            code = sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
            if code:  # a device that is there but down can be bound: the error waits behind
                raise OSError(code, os.strerror(code))
        except OSError as error:
            let_go(sock)
            self.fault = f"{device}: {error.strerror or error}{_remedy(error.errno, device)}"
            return False
        self._use(sock)
        return True

    def _use(self, sock: socket.socket) -> None:
        self.buffer_bytes = set_options(sock)
        self._in.of_new_socket()
        self._socket, self.up, self.fault = sock, True, ""

    def receive(self, into: CanMessages, first: int = 0) -> int:
        """Take in what has arrived."""
        at, room = first, len(into)
        while at < room and self._socket is not None:
            limit = min(BATCH, room - at)
            count = self._in.receive(self._socket, limit)
            if count < 0:
                self._broke(-count)
                break
            if count:
                self.octets += self._in.bytes
                at = self._take(count, into, at)
            if count < limit:
                break
        return at - first

    def _take(self, count: int, into: CanMessages, at: int) -> int:
        return int(
            self._read(
                self._in.flat,
                self._words_in,
                self._in.lengths,
                self._in.stamp_ns,
                count,
                at,
                into.ids,
                into.lengths,
                into.data,
                into.stamp_ns,
                self._counts,
            )
        )

    def send_many(self, messages: CanMessages, count: int, first: int = 0) -> int:
        """Send rows of `messages`; a full queue of the device takes fewer."""
        check_rows(messages, first, count)
        done = 0
        while done < count and self._socket is not None:
            part = min(BATCH, count - done)
            self._encode(messages, first + done, part)
            sent = self._out.send(self._socket, part, connected=True)
            if sent < 0:
                self._broke(-sent)
                break
            done += sent
            if sent < part:
                break
        return done

    def _encode(self, messages: CanMessages, first: int, count: int) -> None:
        self._write(
            messages.ids,
            messages.lengths,
            messages.data,
            first,
            count,
            self._out.flat,
            self._words_out,
            self._out.lengths,
        )

    def filenos(self) -> Sequence[int]:
        """Of the socket."""
        return (self._socket.fileno(),) if self._socket is not None else ()

    def _release(self) -> None:
        let_go(self._socket)
        self._socket, self.up = None, False


def _check_system() -> None:
    """Raise InputError where there is no CAN at all."""
    other = "take interface udp_multicast or udp, or one of python-can's (pcan, slcan, ...)"
    if not hasattr(socket, "AF_CAN"):
        raise InputError(
            f"interface is 'socketcan', expected Linux: this Python has no AF_CAN; {other}"
        )
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError as error:
        if error.errno in (errno.EAFNOSUPPORT, errno.EPROTONOSUPPORT):
            raise InputError(
                "interface is 'socketcan', expected a kernel with CAN: this one refuses "
                f"({error.strerror}); modprobe can can_raw, or {other}"
            ) from None
        if error.errno in (errno.EPERM, errno.EACCES):
            raise InputError(
                f"interface is 'socketcan', expected leave to open it ({error.strerror}): run "
                f"where that is permitted, or {other}"
            ) from None


def _remedy(code: int | None, device: str) -> str:
    if code not in ABSENT:
        return ""
    return f"; ip link set {device} up type can bitrate 1000000"
