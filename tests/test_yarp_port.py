"""Bottles and a port of ours, byte for byte: golden examples of YARP's, and what its tools say."""

import socket
import struct
from collections.abc import Iterator
from contextlib import closing

import pytest
from hypothesis import given
from hypothesis import strategies as st
from live_skins import wait_for
from yarp_peers import NameServer, Peer, values_of

from skinfield.errors import InputError
from skinfield.wire import yarp
from skinfield.wire.yarp import Port, bytes_from_bottle, envelope, text_from_bottle
from skinfield.wire.yarp.carriers import words_from_text

VALUES = [[1, 2], [1.0, 0.5], "a b", 3.0]
TEXT = b'(1 2) (1.0 0.5) "a b" 3.0\r\n'


def ints(*numbers: int) -> bytes:
    return struct.pack(f"<{len(numbers)}i", *numbers)


BYTES = (
    ints(256, 4, 257, 2, 1, 2, 276, 2) + struct.pack("<2d", 1.0, 0.5) + ints(4, 3) + b"a b"
    + ints(20) + struct.pack("<d", 3.0)
)  # fmt: skip


def yarp_number(value: int) -> bytes:
    return b"YA" + ints(value) + b"RP"


def command(word: bytes) -> bytes:
    """A port command in bytes: one letter, or text."""
    if len(word) == 1:
        return b"\0\0\0\0~" + word + b"\0\x01"
    return ints(len(word) + 1) + b"~\0\0\x01" + word + b"\0"


def block(*blocks: bytes) -> bytes:
    """A message of the tcp carrier."""
    index = bytes([len(blocks), 1]) + b"\xff" * 8 + b"".join(ints(len(b)) for b in blocks)
    return yarp_number(10) + index + ints(0) + b"".join(blocks)


GOLDEN = [  # as YARP's documentation of its data format and of its ports shows them
    ('0 "hello world"', [0, "hello world"]),
    ("set poss (10 10 -10 -10 5) ()", ["set", "poss", [10, 10, -10, -10, 5], []]),
    ("10.0 10.0 -10.0 -10.0 5.0", [10.0, 10.0, -10.0, -10.0, 5.0]),
    ('"say \\"hi\\"\\n\\\\" "" "5" "true"', ['say "hi"\n\\', "", "5", "true"]),
    ("inf -inf 1e-05 -9223372036854775808", [float("inf"), -float("inf"), 1e-05, -(1 << 63)]),
]


@pytest.mark.parametrize(("text", "values"), GOLDEN)
def test_golden_texts(text: str, values: list[object]) -> None:
    assert text_from_bottle(values) == text


numbers = st.one_of(st.integers(-(1 << 31), (1 << 31) - 1), st.floats())
bottles = st.lists(st.recursive(numbers, lambda inner: st.lists(inner, max_size=3)), max_size=5)


@given(bottles)
def test_numbers_are_read_as_what_they_are(values: list[object]) -> None:
    assert repr(values_of(text_from_bottle(values))) == repr(values)


def test_words_of_commands() -> None:
    assert words_from_text('[add] "tcp://reader" x') == ["add", "tcp://reader", "x"]
    assert words_from_text('add  "a b" [] "c\\"d" (') == ["add", "a b", "", 'c"d', "("]
    assert words_from_text('"open') == ["open"]


def test_golden_bytes() -> None:
    # a list of doubles: 256 + 20, two of them; then one of mixed types with a list of ints in it
    assert bytes_from_bottle([1.0, -2.5]) == ints(276, 2) + struct.pack("<2d", 1.0, -2.5)
    mixed = ints(256, 2) + ints(257, 2, 7, 8) + ints(4, 2) + b"ab"
    assert bytes_from_bottle([[7, 8], "ab"]) == mixed
    assert bytes_from_bottle([]) == ints(256, 0)


class Visitor:
    """Says something to a port, and reads so many bytes of what it answers."""

    def __init__(self, port: Port) -> None:
        self.port = port
        self.socket = socket.create_connection(("127.0.0.1", port.socket_port), 10.0)

    def says(self, data: bytes, answer: bytes) -> None:
        self.socket.sendall(data)
        assert self.reads(len(answer)) == answer

    def reads(self, count: int) -> bytes:
        found = b""
        self.socket.settimeout(0.01)
        for _ in range(3000):
            if len(found) == count:
                break
            self.port.step()
            try:
                data = self.socket.recv(count - len(found))
            except TimeoutError:
                continue
            if not data:
                break
            found += data
        return found

    def is_closed(self) -> bool:
        return self.reads(1) == b""

    def close(self) -> None:
        self.socket.close()


@pytest.fixture
def port() -> Iterator[Port]:
    with closing(Port("/out", "127.0.0.1")) as made:
        yield made


@pytest.fixture
def visitor(port: Port) -> Iterator[Visitor]:
    with closing(Visitor(port)) as made:
        yield made


def test_a_reader_types_what_yarps_page_says(port: Port, visitor: Visitor) -> None:
    visitor.says(b"CONNECT foo\r\n", b"Welcome foo\r\n")
    visitor.says(b"\r\n", b"Port command not understood.\r\n")
    assert port.write(VALUES) == 0
    visitor.says(b"r\r\n", b"")
    port.step(0.1)
    assert port.outputs == {"foo": "text"}
    assert port.write(VALUES, envelope(12, 1215723086.182938)) == 1
    expected = b"D 12 1215723086.182938\r\n" + TEXT
    assert visitor.reads(len(expected)) == expected
    port.write([])
    assert visitor.reads(5) == b"D\r\n\r\n"


def test_what_yarp_connect_says_to_a_port(port: Port, visitor: Visitor) -> None:
    visitor.says(b"CONNACK admin\r\n", b"Welcome admin\r\n")
    visitor.says(b"a\r\n[ver]\r\n", b"[ver] 1 2 3\r\n<ACK>\r\n")
    visitor.says(b"a\r\n[list] [out]\r\n", b"\r\n<ACK>\r\n")
    visitor.says(
        b'a\r\n[add] "tcp://reader"\r\n',
        b'-1 "Do not know how to connect to tcp://reader: there is no name server"\r\n<ACK>\r\n',
    )
    visitor.says(
        b"a\r\n[add] udp://reader\r\n",
        b"-1 \"Cannot connect to udp://reader: carrier is 'udp', expected one of text, text_ack, "
        b'tcp"\r\n<ACK>\r\n',
    )
    visitor.says(b"a\r\nxyz\r\n", b'[fail] "expected [ver], [add], [del] or [list]"\r\n<ACK>\r\n')
    visitor.says(b"d\r\nto nobody\r\n", b"<ACK>\r\n")
    visitor.says(b"q\r\n", b"")
    assert visitor.is_closed()


def test_a_message_goes_out_when_the_one_before_is_acknowledged(
    port: Port, visitor: Visitor
) -> None:
    visitor.says(b"CONNACK slow\nr\n", b"Welcome slow\r\n<ACK>\r\n")
    assert port.write([1]) == 1
    assert port.write([2]) == 0
    assert port.skipped == 1
    visitor.says(b"<ACK>\r\n", b"D\r\n1\r\n")
    assert port.write([3]) == 1
    assert visitor.reads(6) == b"D\r\n3\r\n"


def test_a_reader_that_takes_nothing_holds_up_nobody(port: Port, visitor: Visitor) -> None:
    other = Visitor(port)
    for each in (visitor, other):
        each.says(b"CONNECT x\nr\n", b"Welcome x\r\n")
    port.step(0.1)
    big = ["x" * 50_000]
    sent = 0
    for _ in range(200):
        sent += port.write(big)
        other.reads(len(big[0]) + 5)
    assert port.skipped > 0
    assert sent > 200
    assert len(port.outputs) == 1  # of the one name
    other.close()


def test_others_are_told_what_they_are(port: Port, visitor: Visitor) -> None:
    visitor.says(b"GET / HTTP/1.1\r\n", b"* Error. Protocol not found.\r\n")
    assert visitor.reads(100).endswith(b"CONNECT and a name.\r\n")
    assert visitor.is_closed()
    endless = Visitor(port)
    endless.says(b"CONNECT " + b"x" * 2000, b"a line has more than 1000 bytes")
    assert endless.reads(100) == b", expected no more\r\n"
    endless.close()


class Reader(Peer):
    """A port that others connect to, by the carrier that they choose."""

    def talk(self, link: socket.socket, line: object) -> None:
        head = link.recv(8, socket.MSG_WAITALL)
        if head.startswith(b"YA"):
            size = link.recv(4, socket.MSG_WAITALL)
            name = size + link.recv(struct.unpack("<i", size)[0], socket.MSG_WAITALL)
            link.sendall(yarp_number(self.port))
        else:
            name = link.makefile("rb", buffering=0).readline()
            link.sendall(b"Welcome " + name)
        self.heard.append(head + name)
        self.got = b""
        while data := link.recv(4096):
            self.got += data


@pytest.mark.parametrize("carrier", ["tcp", "text", "text_ack"])
def test_it_connects_when_it_is_told_to(carrier: str) -> None:
    names, reader = NameServer(), Reader()
    names.known["/reader"] = ("127.0.0.1", reader.port)
    server = yarp.NameServer("127.0.0.1", names.port)
    with closing(names), closing(reader), closing(Port("/out", "127.0.0.1", server=server)) as port:
        port.register()
        assert names.known["/out"] == ("127.0.0.1", port.socket_port)
        assert names.asked[0] == f"register /out tcp 127.0.0.1 {port.socket_port}"
        assert names.asked[1] == "set /out offers text text_ack tcp"
        assert port.add(f"{carrier}://reader").startswith("Added connection from /out to ")
        assert port.add("/nobody") == "Do not know how to connect to /nobody"
        port.write(VALUES, "7 1.5")
        assert port.outputs == {"/reader": carrier}
        assert port.remove("/reader") == "Removed connection from /out to /reader"
        wait_for(lambda: len(reader._threads) > 1)
        for thread in reader._threads[1:]:
            thread.join(10.0)
        is_text = carrier.startswith("text")
        start = b"CONNECT /out\r\n" if carrier == "text" else b"CONNACK /out\r\n"
        assert reader.heard[-1] == (start if is_text else b"YA\xe4\x1e\0\0RP" + ints(5) + b"/out\0")
        told = b"D 7 1.5\r\n" + TEXT + b"q\r\n"
        blocks = block(command(b"D 7 1.5"), BYTES) + block(command(b"q"))
        assert reader.got == (told if is_text else blocks)
        port.unregister()
        assert "/out" not in names.known


def test_a_name_server_that_is_not_there() -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        place = free.getsockname()[1]
    with pytest.raises(InputError, match="expected a running `yarp server`"):
        yarp.NameServer("127.0.0.1", place).where("me", "/x")
