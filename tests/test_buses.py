"""CAN buses over UDP, SocketCAN and python-can: on their bytes, and against python-can itself."""

import socket
import struct
import time
import uuid

import can
import numpy as np
import pytest
from bus_peers import drawn_messages, free_port, group, opened, pair, receive, wait_for

from skinfield.errors import InputError
from skinfield.wire.can import BusSettings, open_bus
from skinfield.wire.can.adapters import BATCH, PER_DATAGRAM, SocketCanBus
from skinfield.wire.can.kernel import TOO_LONG, take_headers
from skinfield.wire.can.messages import ERROR, EXTENDED, REMOTE, CanMessages

STRUCT = struct.Struct("=IB3x8s")  # struct can_frame of linux/can.h


def struct_of(messages: CanMessages, row: int) -> bytes:
    return STRUCT.pack(messages.ids[row], messages.lengths[row], messages.data[row].tobytes())


def python_can_of(messages: CanMessages, row: int) -> can.Message:
    identifier, length = int(messages.ids[row]), int(messages.lengths[row])
    remote = bool(identifier & REMOTE)
    return can.Message(
        arbitration_id=identifier & 0x1FFFFFFF,
        is_extended_id=bool(identifier & EXTENDED),
        is_remote_frame=remote,
        dlc=length,
        data=None if remote else messages.data[row, :length].tobytes(),
    )


def assert_received(received: list[tuple[int, bytes, int]], messages: CanMessages) -> None:
    assert [identifier for identifier, _, _ in received] == messages.ids.tolist()
    for row, (identifier, data, _) in enumerate(received):
        length = 0 if identifier & REMOTE else messages.lengths[row]
        assert data == messages.data[row, :length].tobytes()


@pytest.fixture
def wire() -> tuple[SocketCanBus, socket.socket]:
    """SocketCAN through a pair of sockets of another family: most kernels have no bus."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    theirs.settimeout(30)
    bus = SocketCanBus(BusSettings("socketcan", "can0"), ours)
    yield bus, theirs
    bus.close()
    theirs.close()


def test_datagrams_of_udp_hold_structs_of_linux() -> None:
    messages = drawn_messages(np.random.default_rng(3), PER_DATAGRAM + 9)
    expected = [struct_of(messages, row) for row in range(len(messages))]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        other.settimeout(30)
        peer = f"127.0.0.1:{other.getsockname()[1]}"
        with opened(BusSettings("udp", port=0, peer=peer)) as (bus,):
            assert other.recv(2000) == b""  # where to answer to
            assert bus.send_many(messages, len(messages)) == len(messages)
            assert other.recv(2000) == b"".join(expected[:PER_DATAGRAM])
            assert other.recv(2000) == b"".join(expected[PER_DATAGRAM:])
            before = time.time_ns()
            for part in (expected[:1], expected[1:40], [], expected[40:]):
                other.sendto(b"".join(part), bus.address)
            received = receive(bus, len(messages))
            assert_received(received, messages)
            stamps = [stamp for _, _, stamp in received]
            assert stamps == sorted(stamps)
            assert before <= stamps[0] <= stamps[-1] <= time.time_ns()
            assert bus.malformed == bus.errors == bus.overflowed == 0


def test_what_is_no_message_is_counted_not_handed_on() -> None:
    good = STRUCT.pack(7, 1, b"x")
    with (
        opened(BusSettings("udp", port=0)) as (bus,),
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other,
    ):
        for datagram in (
            b"what is this?",
            bytes(1600),  # longer than any
            STRUCT.pack(1, 9, bytes(8)) + good,
            STRUCT.pack(0x800, 1, bytes(8)) + STRUCT.pack(ERROR | 0x1000, 8, bytes(8)) + good,
        ):
            other.sendto(datagram, bus.address)
        assert [each[:2] for each in receive(bus, 2)] == [(7, b"x")] * 2
        assert (bus.malformed, bus.errors) == (4, 1)


def test_host_answers_to_whoever_sent_last() -> None:
    with pair() as (host, board):
        assert not host.send(1, b"")  # to whom?
        wait_for(lambda: host.receive(CanMessages(4)) == 0 and host.send(0x20D, b"\x07\x00"))
        assert receive(board, 1)[0][:2] == (0x20D, b"\x07\x00")
        assert board.send(0x4D5, bytes(8))
        assert receive(host, 1)[0][:2] == (0x4D5, bytes(8))
        with opened(BusSettings("udp", port=0, peer=f"127.0.0.1:{host.address[1]}")) as (later,):
            assert later.send(1, b"")
            receive(host, 1)
            assert host.send(2, b"x")
            assert receive(later, 1)[0][:2] == (2, b"x")
        assert host.malformed == 0


def test_ipv6() -> None:
    with opened(BusSettings("udp", "::1", port=0)) as (host,):
        if not host.up:
            pytest.skip(f"no IPv6 here: {host.fault}")
        settings = BusSettings("udp", "::1", port=0, peer=f"[::1]:{host.address[1]}")
        with opened(settings) as (board,):
            assert board.send(5, b"six")
            assert receive(host, 1)[0][:2] == (5, b"six")


def test_more_than_one_batch_and_less_room_than_messages() -> None:
    count = 2 * BATCH + 5
    messages = drawn_messages(np.random.default_rng(4), count)
    with pair() as (host, board):
        for identifier in messages.ids.tolist():  # in a datagram each
            assert board.send(identifier, b"")
        few = CanMessages(7)
        wait_for(lambda: host.receive(few) == 7)  # the others wait
        assert few.ids.tolist() == messages.ids.tolist()[:7]
        assert [each[0] for each in receive(host, count - 7)] == messages.ids.tolist()[7:]
        assert board.send_many(messages, count) == count  # in few datagrams
        assert [each[0] for each in receive(host, count, room=50)] == messages.ids.tolist()


def test_drops_of_the_system_are_counted() -> None:
    with pair() as (host, board):
        host._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)  # the least there is
        room = CanMessages(256)
        for row in range(200):
            board.send(row, b"12345678")
        received = 0
        for _ in range(3):  # the count comes with the first datagram that is taken after the loss
            received += host.receive(room)
            board.send(200, b"")
        received += host.receive(room)
        assert received < 203
        assert received + host.overflowed == 203


def test_a_peer_that_is_gone_breaks_nothing() -> None:
    with opened(BusSettings("udp", port=0, peer=f"127.0.0.1:{free_port()}")) as (board,):
        for _ in range(20):
            board.send(1, b"x")
            assert board.receive(CanMessages(4)) == 0
        assert board.up


def test_address_that_is_taken_is_no_error_but_down() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        with opened(BusSettings("udp", port=sock.getsockname()[1])) as (bus,):
            assert not bus.up
            assert "in use" in bus.fault
            assert bus.receive(CanMessages(4)) == 0
            sock.close()
            assert bus.reopen()


def test_socketcan_has_a_struct_in_each_datagram(wire: tuple[SocketCanBus, socket.socket]) -> None:
    bus, theirs = wire
    messages = drawn_messages(np.random.default_rng(1), 300)
    received = []
    for row in range(len(messages)):
        theirs.send(struct_of(messages, row))
        received += receive(bus, 1) if row % 50 == 49 or row == 299 else []
    received += receive(bus, len(messages) - len(received))
    assert_received(received, messages)
    assert bus.send_many(messages, 60) == 60
    for row in range(60):
        assert theirs.recv(100) == struct_of(messages, row)
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
    bus._socket.close()
    assert bus.receive(CanMessages(4)) == 0
    assert (bus.up, bus.filenos()) == (False, ())


def test_a_kernel_without_can_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except (OSError, AttributeError):
        with pytest.raises(InputError, match=r"expected a kernel with CAN.*interface udp"):
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
    take_headers(headers, control.view(np.uint32), 3, 99, lengths, stamps, drops)
    assert lengths.tolist() == [16, 32, TOO_LONG]
    assert stamps.tolist() == [5_000_000_007, 5_000_000_007, 99]
    assert drops.tolist() == [4, 2**32 - 1 + 5]  # the socket's 32 bits ran over
    assert headers[:, 5].tolist() == [64] * 3


@pytest.mark.parametrize("interface", ["virtual", "udp_multicast"])
def test_interfaces_of_python_can(interface: str) -> None:
    own = interface == "udp_multicast"
    channel = group() if own else uuid.uuid4().hex
    options = {"port": free_port()} if own else {}
    messages = drawn_messages(np.random.default_rng(6), 40)
    with (
        opened(BusSettings(interface, channel, options=tuple(options.items()))) as (bus,),
        can.Bus(interface=interface, channel=channel, **options) as other,
    ):
        assert bus.send_many(messages, 40) == 40
        for row in range(40):
            message = other.recv(30)
            if message is None and own:
                pytest.skip("what is sent to a group does not arrive on this machine")
            assert message.equals(
                python_can_of(messages, row), timestamp_delta=None, check_channel=False
            )
        for row in range(40):
            other.send(python_can_of(messages, row))
        other.send(can.Message(arbitration_id=3, is_error_frame=True))
        other.send(can.Message(arbitration_id=3, is_fd=True, data=bytes(16)))
        other.send(python_can_of(messages, 0))
        received = receive(bus, 41)
        assert_received(received[:40], messages)
        assert (bus.errors, bus.malformed) == (1, 1)
        bus.close()
        assert bus.receive(CanMessages(4)) == 0
        assert not bus.send(1, b"")


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        (["telepathy"], "expected udp, socketcan or one of.*udp_multicast.*virtual"),
        (["udp", "no such host"], "channel is 'no such host'"),
        (["udp", "", 0, "nobody"], "expected host:port"),
        (["udp", "", 0, "127.0.0.1:0"], "expected host:port"),
        (["udp", "::1", 0, "127.0.0.1:9"], "both of IPv4 or both of IPv6"),
        (["socketcand", "x"], "cannot be opened.*host"),
        ([""], "interface is ''"),
        (["udp", "", 70000], "port is 70000"),
        (["udp", 3], "channel"),
        (["slcan", "", 0, "", -1], "bitrate is -1"),
    ],
)
def test_settings_that_cannot_be_used(settings: list, text: str) -> None:
    with pytest.raises(InputError, match=text):
        open_bus(BusSettings(*settings))


def test_messages_that_cannot_be_sent() -> None:
    with pair() as (host, _):
        with pytest.raises(InputError, match="expected up to 8"):
            host.send(1, bytes(9))
        with pytest.raises(InputError, match="rows 0 to 9"):
            host.send_many(CanMessages(8), 9)
