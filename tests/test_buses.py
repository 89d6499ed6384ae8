"""Buses over UDP and of python-can: against python-can itself."""

import multiprocessing
import socket
import time
import uuid

import can
import numpy as np
import pytest
from bus_peers import drawn_messages, free_port, group, opened, pair, receive, wait_for
from test_buses_map import python_cans

from skinfield.acquisition import CanMessages
from skinfield.acquisition.can import EXTENDED, REMOTE
from skinfield.errors import InputError
from skinfield.sources.buses import BusSettings, open_bus
from skinfield.sources.buses import datagrams as datagrams_module
from skinfield.sources.buses.udp import BATCH


def echo(channel: str, port: int, ready: object) -> None:
    """A process that knows python-can only: returns each message with its identifier plus 1."""
    with can.Bus(interface="udp_multicast", channel=channel, port=port) as bus:
        ready.set()  # type: ignore[attr-defined]
        for _ in range(100):
            message = bus.recv(30)
            if message is None or message.arbitration_id == 0x7FF:
                return
            if message.arbitration_id % 2 == 0:  # its own answers come back to it, too
                message.arbitration_id += 1
                bus.send(message)


def assert_same(heard: can.Message | None, sent: can.Message) -> None:
    assert heard is not None
    assert heard.equals(sent, timestamp_delta=None, check_channel=False)


def test_python_can_in_another_process_hears_and_answers() -> None:
    context = multiprocessing.get_context("spawn")
    channel, port, ready = group(), free_port(), context.Event()
    other = context.Process(target=echo, args=(channel, port, ready), daemon=True)
    try:
        with opened(BusSettings("udp_multicast", channel, port)) as (bus,):
            other.start()
            assert ready.wait(60)
            assert bus.up
            before = time.time_ns()
            for row in range(20):
                assert bus.send(2 * row | (EXTENDED if row % 3 else 0), bytes(range(row % 9)))
            answers = receive(bus, 20)
            assert [identifier & 0x1FFFFFFF for identifier, _, _ in answers] == [
                2 * row + 1 for row in range(20)
            ]
            assert [data for _, data, _ in answers] == [bytes(range(row % 9)) for row in range(20)]
            stamps = [stamp for _, _, stamp in answers]
            assert stamps == sorted(stamps)
            assert before <= stamps[0] <= stamps[-1] <= time.time_ns()
            assert bus.malformed == bus.overflowed == 0
            bus.send(0x7FF, b"")
        other.join(30)
        assert other.exitcode == 0
    finally:
        if other.pid is not None:
            other.kill()
            other.join()


@pytest.mark.parametrize("singly", [False, True])
def test_all_kinds_of_messages_both_ways(singly: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if singly:  # as on a system without recvmmsg
        monkeypatch.setattr(datagrams_module, "many_at_once", lambda name: None)
    channel, port = group(), free_port()
    messages = drawn_messages(np.random.default_rng(3), 300)
    with (
        opened(BusSettings("udp_multicast", channel, port)) as (bus,),
        can.Bus(interface="udp_multicast", channel=channel, port=port) as other,
    ):
        for row in range(len(messages)):
            if row % 50 == 0:  # python-can's buffer is a small one
                assert bus.send_many(messages, 50, row) == 50
            heard = other.recv(30)
            assert heard is not None
            assert heard.equals(
                python_cans(messages, row), timestamp_delta=None, check_channel=False
            )
        assert bus.receive(CanMessages(8)) == 0  # its own messages do not come back to it
        for row in range(len(messages)):
            other.send(python_cans(messages, row))
        heard = receive(bus, len(messages))
        assert [identifier for identifier, _, _ in heard] == messages.ids.tolist()
        for row, (identifier, data, _) in enumerate(heard):
            length = 0 if identifier & REMOTE else messages.lengths[row]
            assert data == messages.data[row, :length].tobytes()


def test_can_fd_and_error_frames_are_counted_not_handed_on() -> None:
    channel, port = group(), free_port()
    with (
        opened(BusSettings("udp_multicast", channel, port)) as (bus,),
        can.Bus(interface="udp_multicast", channel=channel, port=port) as other,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock,
    ):
        other.send(can.Message(arbitration_id=1, data=bytes(12), is_fd=True))
        other.send(can.Message(arbitration_id=1, is_error_frame=True))
        sock.sendto(b"what is this?", (channel, port))
        sock.sendto(bytes(600), (channel, port))
        other.send(can.Message(arbitration_id=2))
        assert [identifier for identifier, _, _ in receive(bus, 1)] == [2 | EXTENDED]
        assert (bus.malformed, bus.errors) == (3, 1)
        assert bus.octets > 700


@pytest.mark.parametrize("local", ["", "127.0.0.1"])
def test_what_stays_on_this_machine_reaches_all_here(local: str) -> None:
    channel, port = group(), free_port()
    settings = BusSettings("udp_multicast", channel, port, local="127.0.0.1")
    with (
        opened(settings, BusSettings("udp_multicast", channel, port, local=local)) as (one, other),
        can.Bus(interface="udp_multicast", channel=channel, port=port) as third,
    ):
        one.send(1, b"here")
        assert [each[:2] for each in receive(other, 1)] == [(1, b"here")]
        heard = third.recv(30)
        assert heard is not None
        assert bytes(heard.data) == b"here"
        other.send(2, b"there")
        assert [each[:2] for each in receive(one, 1)] == [(2, b"there")]
        third.send(can.Message(arbitration_id=3, is_extended_id=False))
        assert [each[0] for each in receive(one, 1) + receive(other, 1)] == [3, 3]


def test_ipv6_group() -> None:
    settings = BusSettings("udp_multicast", "ff15::7079:4321", free_port())
    with opened(settings, settings) as (one, other):
        if not one.up:
            pytest.skip(f"no multicast of IPv6 here: {one.fault}")
        if not one.send(5, b"six"):
            pytest.skip("multicast of IPv6 is not routed here")
        assert receive(other, 1)[0][:2] == (5, b"six")
        assert one.receive(CanMessages(4)) == 0


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


def test_more_than_one_batch_and_less_room_than_messages() -> None:
    count = 2 * BATCH + 5
    messages = drawn_messages(np.random.default_rng(4), count)
    with pair() as (host, board):
        assert board.send_many(messages, count) == count
        few = CanMessages(7)
        wait_for(lambda: host.receive(few, 2) == 5)  # the others wait
        assert few.ids.tolist()[2:] == messages.ids.tolist()[:5]
        assert [each[0] for each in receive(host, count - 5)] == messages.ids.tolist()[5:]


def test_drops_of_the_system_are_counted() -> None:
    with pair() as (host, board):
        assert host._receiver is not None
        host._receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)  # the least there is
        messages = drawn_messages(np.random.default_rng(5), 200)
        board.send_many(messages, 200)
        heard, room = 0, CanMessages(256)
        for _ in range(3):  # the count comes with the first datagram that is taken after the loss
            heard += host.receive(room)
            board.send_many(messages, 1)
        heard += host.receive(room)
        assert heard < 203
        assert heard + host.overflowed == 203


def test_a_peer_that_is_gone_breaks_nothing() -> None:
    with opened(BusSettings("udp", port=0, peer=f"127.0.0.1:{free_port()}")) as (board,):
        for _ in range(20):
            board.send(1, b"x")
            assert board.receive(CanMessages(4)) == 0
        assert board.up


def test_a_broken_socket_is_down_until_it_is_opened_again() -> None:
    with pair() as (host, board):
        board.send(1, b"x")
        receive(host, 1)
        port = host.address[1]
        assert host._receiver is not None
        host._receiver.close()  # as ENETDOWN and such do
        assert host.receive(CanMessages(4)) == 0
        assert not host.up
        assert host.fault
        assert host.filenos() == ()
        assert not host.send(1, b"")
        assert host.reopen()
        assert host.up
        assert host.address[1] != port  # port 0: another free one


def test_address_that_is_taken_is_no_error_but_down() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        with opened(BusSettings("udp", port=sock.getsockname()[1])) as (bus,):
            assert not bus.up
            assert "in use" in bus.fault
            assert bus.receive(CanMessages(4)) == 0
            sock.close()
            assert bus.reopen()


def test_interfaces_of_python_can() -> None:
    channel = uuid.uuid4().hex
    messages = drawn_messages(np.random.default_rng(6), 40)
    with (
        opened(BusSettings("virtual", channel)) as (bus,),
        can.Bus(interface="virtual", channel=channel) as other,
    ):
        assert bus.send_many(messages, 40) == 40
        for row in range(40):
            heard = other.recv(1)
            assert heard is not None
            assert heard.equals(
                python_cans(messages, row), timestamp_delta=None, check_channel=False
            )
        for row in range(40):
            other.send(python_cans(messages, row))
        other.send(can.Message(arbitration_id=3, is_error_frame=True))
        other.send(can.Message(arbitration_id=3, is_fd=True, data=bytes(16)))
        assert [each[0] for each in receive(bus, 40)] == messages.ids.tolist()
        assert bus.receive(CanMessages(4)) == 0
        assert (bus.errors, bus.malformed) == (1, 1)
        bus.close()
        assert bus.receive(CanMessages(4)) == 0
        assert not bus.send(1, b"")


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        (BusSettings("telepathy"), "expected udp_multicast, udp, socketcan or one of.*virtual"),
        (BusSettings("udp_multicast", "192.168.1.1"), "expected a multicast group"),
        (BusSettings("udp_multicast", port=0), "expected a multicast group"),
        (BusSettings("udp_multicast", "no such host"), "channel is 'no such host'"),
        (BusSettings("udp", peer="nobody"), "expected host:port"),
        (BusSettings("udp", peer="127.0.0.1:0"), "expected host:port"),
        (BusSettings("udp", "::1", 0, peer="127.0.0.1:9"), "both of IPv4 or both of IPv6"),
        (BusSettings("socketcand", "x"), "cannot be opened.*host"),
    ],
)
def test_settings_that_cannot_be_used(settings: BusSettings, text: str) -> None:
    with pytest.raises(InputError, match=text):
        open_bus(settings)


def test_messages_that_cannot_be_sent() -> None:
    with pair() as (host, _):
        with pytest.raises(InputError, match="expected up to 8"):
            host.send(1, bytes(9))
        with pytest.raises(InputError, match="rows 3 to 9"):
            host.send_many(CanMessages(8), 6, 3)


@pytest.mark.parametrize(
    "wrong", [{"interface": ""}, {"port": 70000}, {"channel": 3}, {"bitrate": -1}]
)
def test_settings_are_checked(wrong: dict) -> None:
    with pytest.raises(InputError):
        BusSettings(**wrong)
