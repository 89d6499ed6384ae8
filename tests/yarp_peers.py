"""A robot's side of YARP in plain Python, from YARP's own pages alone; nothing of skinfield.

`NameServer` and `Sender` speak as "YARP without YARP" and "The name server protocol" of YARP's
documentation show it; `values_of` reads a bottle's text.
"""

import re
import socket
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress


def as_yarp(number: float) -> str:
    """A double as YARP prints it: 21 digits at most, always with a point or an exponent."""
    text = f"{number:.21g}"
    return text if any(c in text for c in ".en") else text + ".0"


TOKEN = re.compile(r'"([^"]*)"|([()])|([^\s()]+)')


def values_of(text: str) -> list[object]:
    """Values of a bottle: numbers, words, texts and lists, by a reader of its own."""
    lists: list[list[object]] = [[]]
    for quoted, bracket, word in TOKEN.findall(text):
        if bracket == "(":
            lists.append([])
        elif bracket:
            inner = lists.pop()
            lists[-1].append(inner)
        else:
            lists[-1].append(_plain(word) if word else quoted)
    assert len(lists) == 1
    return lists[0]


def _plain(word: str) -> object:
    for kind in (int, float):
        with suppress(ValueError):
            return kind(word)
    return word


class Peer:
    """A TCP server with a thread; each connection is given to `talk`, all bytes are kept."""

    def __init__(self) -> None:
        self.port = 0
        self.heard: list[bytes] = []
        self.connections: list[socket.socket] = []
        self._lock = threading.Lock()
        self.listen()

    def listen(self) -> None:
        self.server = socket.create_server(("127.0.0.1", self.port))
        self.port = self.server.getsockname()[1]
        self._threads = [threading.Thread(target=self._accept, args=(self.server,), daemon=True)]
        self._threads[0].start()

    def _accept(self, server: socket.socket) -> None:
        while True:
            try:
                link, _ = server.accept()
            except OSError:
                return
            with self._lock:
                self.connections.append(link)
                self.heard.append(b"")
                number = len(self.heard) - 1
            thread = threading.Thread(target=self._talk, args=(link, number), daemon=True)
            thread.start()
            self._threads.append(thread)

    def _talk(self, link: socket.socket, number: int) -> None:
        with suppress(OSError):
            self.talk(link, lambda end: self._until(link, number, end))

    def _until(self, link: socket.socket, number: int, end: bytes) -> str:
        """The next line, byte by byte."""
        line = b""
        while not line.endswith(end):
            data = link.recv(1)
            if not data:
                raise OSError("closed")
            line += data
            self.heard[number] += data
        return line.decode().rstrip("\r\n")

    def talk(self, link: socket.socket, line: Callable[[bytes], str]) -> None:
        raise NotImplementedError

    def close(self) -> None:
        for each in (self.server, *self.connections):
            with suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()
        for thread in self._threads:
            thread.join(10.0)
        self.connections.clear()


class NameServer(Peer):
    """Answers `query`, `register` and `unregister`."""

    def __init__(self) -> None:
        self.known: dict[str, tuple[str, int]] = {}
        self.asked: list[str] = []
        super().__init__()

    def talk(self, link: socket.socket, line: Callable[[bytes], str]) -> None:
        hello = line(b"\n")
        assert hello.startswith("CONNECT ")
        link.sendall(f"Welcome {hello[8:]}\r\n".encode())
        while True:
            assert line(b"\n") == "d"
            asked = line(b"\n").replace('"', "")
            self.asked.append(asked)
            words = asked.split()
            if words[0] == "register":
                host = "127.0.0.1" if words[3] == "..." else words[3]
                self.known[words[1]] = (host, int(words[4]))
            if words[0] == "unregister":
                self.known.pop(words[1], None)
            answer = ""
            if words[1] in self.known and words[0] in ("register", "query"):
                host, port = self.known[words[1]]
                answer = f"registration name {words[1]} ip {host} port {port} type tcp\r\n"
            link.sendall(f"{answer}*** end of message\r\n".encode())


class Sender(Peer):
    """A port that sends vectors to whoever asked for them with `r`."""

    welcome = "Welcome {}\r\n"

    def __init__(self) -> None:
        self.readers: list[socket.socket] = []
        self.number = -1
        super().__init__()

    def talk(self, link: socket.socket, line: Callable[[bytes], str]) -> None:
        hello = line(b"\n")
        assert hello.startswith("CONNECT ")
        link.sendall(self.welcome.format(hello[8:]).encode())
        assert line(b"\n") == "r"
        self.readers.append(link)
        line(b"\n")  # nothing more is said, until it is closed

    def send(self, values: Sequence[float], number: int | None = None, word: str = "D") -> None:
        """One vector to all readers, with its number and time."""
        self.number = self.number + 1 if number is None else number
        numbers = " ".join(as_yarp(value) for value in values)
        self.say(f"{word} {self.number} 1215723086.182938\r\n{numbers}\r\n".encode())

    def say(self, data: bytes) -> None:
        for each in self.readers:
            with suppress(OSError):
                each.sendall(data)

    def close(self) -> None:
        super().close()
        self.readers.clear()
