"""Client of YARP's name server, which knows where ports are.

As in YARP 4.0.0: `doc/020_nameserver_and_protocols/name_server.dox` and, for the bytes of the
answers, `src/libYARP_name/src/yarp/name/NameServerConnectionHandler.h`. The name server is a port:
a request is data to it, and lines come back, of which the last is ``*** end of message``.
"""

import socket
from dataclasses import dataclass
from time import monotonic

from skinfield.errors import InputError
from skinfield.wire.yarp.carriers import Carrier, Lines, Value, checked_name, greeting, message

PORT = 10000
END = "*** end of message"
ANSWER_BYTES = 65536
PATIENCE = 2.0  # s for an answer
Place = tuple[str, int]  # host and port


def request_bytes(own: str, command: str, name: str, *more: Value) -> bytes:
    """All bytes of a connection that asks one thing about a port, from a party of the name `own`.

    Parameters
    ----------
    own : str
    command : str
        ``query``, ``register``, ``unregister`` or ``set``.
    name : str
        Of the port.
    more : values
        What belongs to the command.
    """
    checked_name(name)
    if not name.startswith("/"):
        raise InputError(f"name of a port is {name!r}, expected one that begins with a slash")
    return greeting(Carrier.TEXT, own) + message(Carrier.TEXT, "d", [command, name, *more])


def place_from_line(line: str) -> Place | None:
    """Where a port is, as a line of an answer says it; None if the line says something else."""
    words = line.replace('"', "").split()
    if words[:1] != ["registration"] or words[1:8:2] != ["name", "ip", "port", "type"]:
        return None
    if not (words[6].isascii() and words[6].isdecimal() and 0 < int(words[6]) < 65536):
        return None  # a port without a socket says "none"
    return words[4], int(words[6])


class NameReply:
    """An answer of the name server, as it comes in.

    Attributes
    ----------
    lines : list of str
        Without the welcome and the end.
    complete : bool
    """

    def __init__(self) -> None:
        self._in = Lines(ANSWER_BYTES)
        self.lines: list[str] = []
        self.complete = False

    def feed(self, data: bytes) -> bool:
        """Take in what came; whether it is complete."""
        self._in.feed(data)
        while not self.complete and (line := self._in.take()) is not None:
            if line.startswith(END):
                self.complete = True
            elif not line.startswith("Welcome "):
                self.lines.append(line)
        return self.complete

    @property
    def place(self) -> Place | None:
        """The first in it: where a port is."""
        return next(filter(None, map(place_from_line, self.lines)), None)


@dataclass(frozen=True)
class NameServer:
    """Where a name server is; each question is a connection of its own, and waits.

    Parameters
    ----------
    host : str
    port : int
    """

    host: str = "127.0.0.1"
    port: int = PORT

    def ask(self, own: str, command: str, name: str, *more: Value) -> NameReply:
        """Send a command as in `request_bytes`, and wait for the answer.

        Raises
        ------
        InputError
            If it does not answer in time, or what comes is no answer.
        """
        request = request_bytes(own, command, name, *more)
        answer, end = NameReply(), monotonic() + PATIENCE
        try:
            with socket.create_connection((self.host, self.port), PATIENCE) as link:
                link.sendall(request)
                while not answer.complete:
                    link.settimeout(max(end - monotonic(), 1e-3))
                    data = link.recv(4096)
                    if not data:
                        raise OSError("it closed the connection")
                    answer.feed(data)
        except (OSError, UnicodeError) as error:
            raise InputError(
                f"name server at {self.host}:{self.port} does not answer: {error}, expected a "
                "running `yarp server`: see `yarp where`"
            ) from None
        return answer

    def where(self, own: str, name: str) -> Place | None:
        """Where a port is; None if nobody knows. Raises as `ask`."""
        return self.ask(own, "query", name).place
