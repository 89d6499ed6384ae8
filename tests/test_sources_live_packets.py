"""Packets over UDP, TCP and serial: what goes wrong on the way, and who is told what."""

import errno
import socket
import time
from ctypes import set_errno
from pathlib import Path

import pytest
from bus_peers import pair, wait_for
from live_devices import Host, PacketServer, SerialLine, packet
from packet_reference import packets_of

from skinfield.errors import InputError
from skinfield.signal import Count
from skinfield.wire.can.messages import CanMessages
from skinfield.wire.packet import PacketDevice
from skinfield.wire.packet.packets import PacketKind
from skinfield.wire.sources import PacketSerial, PacketUdp


def test_a_server_that_dies_in_the_middle_of_a_packet_and_returns() -> None:
    server = PacketServer()
    host = Host(server.source().open())
    server.send()
    host.until(lambda: host.channels.counts[5] == 5)
    server.send(packet(1)[:50])
    host.poll()
    server.close()
    host.until(lambda: not host.stream.up)
    assert host.stream.filenos() == []
    server.plug()
    server.number = 1
    host.until(lambda: host.stream.up)
    server.send()
    host.until(lambda: host.channels.counts[5] == 7)
    assert host.count(Count.MALFORMED) == 0  # the half packet is forgotten, not mixed with others
    assert host.count(Count.REOPENED) == 1
    host.until(lambda: server.listen()[-1:] == [PacketKind.START])
    host.stream.close()
    server.close()


@pytest.mark.parametrize(
    ("made", "fault"), [(PacketServer, "tcp 127.0.0.1:"), (SerialLine, "No such file")]
)
def test_a_device_that_is_not_there_yet_is_waited_for(made: type, fault: str) -> None:
    device = made()
    device.unplug()
    host = Host(device.source().open())
    assert not host.stream.up
    assert fault in host.stream.fault
    host.poll()
    device.plug()
    host.until(lambda: host.stream.up)
    device.send()
    host.until(lambda: host.count(Count.READINGS) == 1)
    wait_for(device.listen)
    assert set(device.told) == {PacketKind.START}
    host.stream.close()
    wait_for(lambda: device.listen()[-1] == PacketKind.STOP)
    device.close()


def test_a_line_whose_node_is_another_device_now() -> None:
    line, other = SerialLine(), SerialLine()
    host = Host(line.source().open())
    host.until(lambda: host.stream.up)
    line.path.unlink()
    line.path.symlink_to(other.path.resolve())
    host.until(lambda: not host.stream.up)
    host.until(lambda: host.stream.up)
    other.send()
    host.until(lambda: host.count(Count.READINGS) == 1)
    host.stream.close()
    line.close()
    other.close()


def test_a_rate_that_no_line_has(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="baud"):
        PacketSerial(72, "/dev/null", baud=3)
    host = Host(PacketSerial(72, str(tmp_path / "none")).open())
    assert not host.stream.up
    (tmp_path / "none").write_text("no line")
    host.poll()
    assert not host.stream._links[0].reopen()
    assert "none" in host.stream.fault
    host.stream.close()


def test_a_device_is_told_to_start_until_it_sends_and_to_stop() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as device:
        device.bind(("127.0.0.1", 0))
        device.settimeout(30)
        peer = f"127.0.0.1:{device.getsockname()[1]}"
        host = Host(PacketUdp((PacketDevice(1, 72),), port=0, peer=peer).open())
        host.poll()
        data, address = device.recvfrom(4096)
        assert [each.kind for each in packets_of(data)] == [PacketKind.START]
        host.stream.poll(host.blocks, 0, time.time_ns() + 2 * 10**9)
        assert [each.kind for each in packets_of(device.recv(4096))] == [PacketKind.START]
        device.sendto(packet(0) + packet(1), address)
        host.until(lambda: host.count(Count.READINGS) == 2)
        host.stream.close()
        assert [each.kind for each in packets_of(device.recv(4096))] == [PacketKind.STOP]


def test_ports_of_several_devices() -> None:
    devices = (PacketDevice(1, 72, "palm"), PacketDevice(9, 12))
    stream = PacketUdp(devices, port=0, unit="Pa").open()
    assert [(port.name, port.channels, port.unit) for port in stream.ports] == [
        ("palm", 72, "Pa"),
        ("device9", 12, "Pa"),
    ]
    stream.close()
    with pytest.raises(InputError, match="host is 'nowhere"):
        PacketUdp(72, "nowhere.invalid").open()


@pytest.mark.parametrize(
    ("code", "passes"),
    [(errno.EAGAIN, True), (errno.ENOBUFS, True), (errno.EINTR, True), (errno.ECONNREFUSED, True),
     (errno.ENETDOWN, False), (errno.ENODEV, False), (errno.EBADF, False)],
)  # fmt: skip
def test_errors_of_the_system_pass_by_or_break_the_bus(code: int, passes: bool) -> None:
    with pair() as (host, board):

        def receiving(*_: object) -> int:
            set_errno(code)
            return -1

        def sending(*_: object) -> bool:
            raise OSError(code, "refused")

        board.send(1, b"")
        receive, send = host._receive, board._put
        host._receive, board._put = receiving, sending
        assert host.receive(CanMessages(4)) == 0
        assert not board.send(2, b"")
        assert host.up == board.up == passes
        host._receive, board._put = receive, send
        if passes:
            wait_for(lambda: host.receive(CanMessages(4)))
        else:
            assert host.fault
            assert host.filenos() == ()
            assert not host.send(1, b"")
            assert host.reopen()
