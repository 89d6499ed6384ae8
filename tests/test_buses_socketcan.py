"""SocketCAN on its bytes, through a pair of sockets of another family: most kernels have no bus."""

import socket
import struct

import numpy as np
import pytest
from bus_peers import drawn_messages, receive

from skinfield.acquisition import CanMessages
from skinfield.acquisition.can import ERROR, REMOTE
from skinfield.errors import InputError
from skinfield.sources.buses import BusSettings, open_bus
from skinfield.sources.buses.datagram_kernel import TOO_LONG, take_headers
from skinfield.sources.buses.socketcan import SocketCanBus

STRUCT = struct.Struct("=IB3x8s")  # struct can_frame of linux/can.h


@pytest.fixture
def wire() -> tuple[SocketCanBus, socket.socket]:
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    theirs.settimeout(30)
    bus = SocketCanBus(BusSettings("socketcan", "can0"), ours)
    yield bus, theirs
    bus.close()
    theirs.close()


def test_frames_are_read(wire: tuple[SocketCanBus, socket.socket]) -> None:
    bus, theirs = wire
    messages = drawn_messages(np.random.default_rng(1), 300)
    heard = []
    for row in range(len(messages)):
        data = messages.data[row].tobytes()
        theirs.send(STRUCT.pack(int(messages.ids[row]), int(messages.lengths[row]), data))
        heard += receive(bus, 1) if row % 50 == 49 or row == 299 else []
    heard += receive(bus, len(messages) - len(heard))
    assert [identifier for identifier, _, _ in heard] == messages.ids.tolist()
    for row, (identifier, data, _) in enumerate(heard):
        length = 0 if identifier & REMOTE else messages.lengths[row]
        assert data == messages.data[row, :length].tobytes()


def test_frames_are_written(wire: tuple[SocketCanBus, socket.socket]) -> None:
    bus, theirs = wire
    messages = drawn_messages(np.random.default_rng(2), 60)
    assert bus.send_many(messages, 60) == 60
    for row in range(60):
        expected = STRUCT.pack(
            int(messages.ids[row]), int(messages.lengths[row]), messages.data[row].tobytes()
        )
        assert theirs.recv(100) == expected
    assert bus.send(0x20D, b"\x07\x00")
    assert theirs.recv(100) == STRUCT.pack(0x20D, 2, b"\x07\x00")


def test_errors_and_other_sizes_are_counted(wire: tuple[SocketCanBus, socket.socket]) -> None:
    bus, theirs = wire
    theirs.send(STRUCT.pack(ERROR | 4, 8, bytes(8)))
    theirs.send(STRUCT.pack(1, 9, bytes(8)))
    theirs.send(bytes(72))  # CAN FD
    theirs.send(bytes(5))
    theirs.send(STRUCT.pack(7, 1, b"x"))
    assert [each[:2] for each in receive(bus, 1)] == [(7, b"x")]
    assert (bus.errors, bus.malformed) == (1, 3)


def test_a_full_queue_takes_fewer(wire: tuple[SocketCanBus, socket.socket]) -> None:
    bus, theirs = wire
    messages = drawn_messages(np.random.default_rng(3), 256)
    sent = sum(bus.send_many(messages, 256) for _ in range(400))
    assert 0 < sent < 400 * 256
    assert bus.up
    assert theirs.recv(100)[:4] == messages.ids[:1].tobytes()


def test_a_device_that_goes_is_down(wire: tuple[SocketCanBus, socket.socket]) -> None:
    bus, _ = wire
    assert bus._socket is not None
    bus._socket.close()
    assert bus.receive(CanMessages(4)) == 0
    assert not bus.up
    assert bus.fault
    assert bus.filenos() == ()


def test_where_the_kernel_has_no_can_that_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except (OSError, AttributeError):
        with pytest.raises(InputError, match=r"expected a kernel with CAN.*udp_multicast"):
            open_bus(BusSettings("socketcan"))
    monkeypatch.delattr(socket, "AF_CAN", raising=False)
    with pytest.raises(InputError, match="no AF_CAN"):
        open_bus(BusSettings("socketcan"))


def test_stamps_and_drops_out_of_control_messages() -> None:
    headers, control = np.zeros((3, 8), np.int64), np.zeros(3 * 64, np.uint8)
    stamp = struct.pack("=QIIqq", 32, 1, 35, 5, 7)
    dropped = [struct.pack("=QIII4x", 20, 1, 40, count) for count in (2**32 - 1, 4)]
    for row, content in enumerate([stamp + dropped[0], dropped[1] + stamp, b"\x07" * 64]):
        control[row * 64 : row * 64 + len(content)] = np.frombuffer(content, np.uint8)
        headers[row, 5], headers[row, 7] = len(content), 16 * (row + 1)
    headers[2, 6] = 0x20  # MSG_TRUNC
    lengths, stamps, drops = np.zeros(3, np.int64), np.zeros(3, np.int64), np.zeros(2, np.int64)
    octets = take_headers(headers, control, 3, 99, lengths, stamps, drops, 32, 64)
    assert octets == 96
    assert lengths.tolist() == [16, 32, TOO_LONG]
    assert stamps.tolist() == [5_000_000_007, 5_000_000_007, 99]
    assert drops.tolist() == [4, 2**32 - 1 + 5]  # the socket's 32 bits ran over
    assert headers[:, 5].tolist() == [64] * 3
