"""A port on sockets: others connect to it, and it connects to others when it is told to.

One thread, and nothing waits but for the two things that `yarp connect` asks of a port: where the
other port is, and a connection to it; both have a time limit. A reader that has not taken, or not
acknowledged, the message before gets the next one after it: newest wins, the others are counted.
"""

import select
import socket
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress

from skinfield.errors import InputError
from skinfield.protocols.yarp.bottle import Value
from skinfield.protocols.yarp.carriers import Carrier, carrier_named, checked_name, message
from skinfield.protocols.yarp.connection import Connection, connected
from skinfield.protocols.yarp.name_server import (
    NameServer,
    query,
    register,
    set_property,
    unregister,
)
from skinfield.protocols.yarp.session import Session

MOST = 64  # connections
Data = Callable[[list[Value], str], Sequence[str] | None]


class Port:
    """See above.

    Parameters
    ----------
    name : str
        Of the port, as /skinfield/left_arm/skin_events:o.
    host : str
        Address to listen at; empty for all of this machine.
    socket_port : int
        0: any that is free.
    server : NameServer, optional
        That is told of the port, and asked for others.
    data : callable, optional
        Takes the values of a message to the port's owner and the host that it came from; gives the
        lines to answer, or None.

    Attributes
    ----------
    skipped : int
        Messages that a reader did not get because it had not taken the one before.

    Raises
    ------
    InputError
        If the name cannot be used, or the address is taken.
    """

    def __init__(
        self,
        name: str,
        host: str = "",
        socket_port: int = 0,
        server: NameServer | None = None,
        data: Data | None = None,
    ) -> None:
        checked_name(name)
        self.name, self.server, self._data = name, server, data
        self.skipped = self.sent = 0
        self._connections: list[Connection] = []
        self._from = ""  # host of the connection that is being listened to
        try:
            self._listener = socket.create_server((host, socket_port), backlog=MOST)
        except OSError as error:
            raise InputError(
                f"port {name} cannot listen at {host or 'any address'}:{socket_port}: {error}, "
                "expected an address of this machine that is free"
            ) from None
        self._listener.setblocking(False)
        self.host = host
        self.socket_port: int = self._listener.getsockname()[1]

    def register(self) -> None:
        """Tell the name server where the port is.

        Raises
        ------
        InputError
            If it does not answer, or does not know the port afterwards.
        """
        if self.server is None:
            return
        machine = self.host if self.host not in ("", "0.0.0.0", "::") else "..."
        there = self.server.ask(register(self.name, machine, self.socket_port), self.name)
        if there.registration is None:
            raise InputError(
                f"name server at {self.server.host}:{self.server.port} did not take {self.name}: "
                f"it said {there.lines!r:.200}, expected a registration"
            )
        names = [each.value for each in Carrier]
        for key in ("offers", "accepts"):
            self.server.ask(set_property(self.name, key, *names), self.name)

    def unregister(self) -> None:
        """Tell the name server that the port is gone."""
        if self.server is not None:
            self.server.ask(unregister(self.name), self.name)

    def filenos(self) -> list[int]:
        """Sockets that become readable when something is said."""
        return [self._listener.fileno(), *(each.socket.fileno() for each in self._connections)]

    def step(self, timeout: float = 0.0) -> None:
        """Listen and answer; waits for something to do, `timeout` s at most."""
        waiting = [each.socket for each in self._connections if each.waits]
        sockets = [self._listener, *(each.socket for each in self._connections)]
        ready, writable, _ = select.select(sockets, waiting, [], timeout)
        for each in self._connections:
            if each.socket in writable:
                each.send(b"")
                each.gone = each.gone or (
                    each.session is not None and each.session.done and not each.waits
                )
        for each in list(self._connections):
            if each.socket in ready and not each.gone:
                self._from = _host_of(each.socket)
                each.receive()
        if self._listener in ready:
            self._accept()
        self._drop_gone()

    def _accept(self) -> None:
        with suppress(OSError):
            sock, _ = self._listener.accept()
            if len(self._connections) >= MOST:
                sock.close()
                return
            self._connections.append(Connection(sock, Session(self), None))

    def _drop_gone(self) -> None:
        for each in [each for each in self._connections if each.gone or each.silent]:
            self._connections.remove(each)
            each.close()

    def write(self, values: Sequence[Value], stamp: str = "") -> int:
        """Send a bottle to all readers that are free; how many got it.

        Parameters
        ----------
        values : sequence of values
        stamp : str
            Of `carriers.envelope`.
        """
        made: dict[bool, bytes] = {}
        command, count = f"D {stamp}" if stamp else "D", 0
        for each in self._connections:
            output = each.output
            if output is None or each.gone:
                continue
            if not each.free:
                self.skipped += 1
                continue
            is_text = output.carrier.is_text
            if is_text not in made:
                made[is_text] = message(output.carrier, command, values)
            output.sent()
            each.send(made[is_text])
            count += 1
        self.sent += count
        return count

    @property
    def readers(self) -> int:
        """How many read from it."""
        return sum(each.output is not None for each in self._connections)

    # what a `Session` asks of its owner

    def describe(self) -> list[str]:
        """See `Owner`."""
        lines = [f"This is {self.name} at tcp://{self.host or '0.0.0.0'}:{self.socket_port}/"]
        for outgoing, what in ((True, "output"), (False, "input")):
            for name, carrier in self.connections(outgoing).items():
                ends = (self.name, name) if outgoing else (name, self.name)
                lines.append(
                    f"There is an {what} connection from {ends[0]} to {ends[1]} using {carrier}"
                )
            if not self.connections(outgoing):
                lines.append(f"There are no {'outgoing' if outgoing else 'incoming'} connections")
        return lines

    def connections(self, outgoing: bool) -> Mapping[str, str]:
        """See `Owner`."""
        if outgoing:
            outputs = [each.output for each in self._connections if each.output is not None]
            return {output.name: output.carrier.value for output in outputs}
        sessions = [each.session for each in self._connections if each.output is None]
        return {
            session.peer: session.carrier.value
            for session in sessions
            if session is not None and session.carrier is not None and session.peer
        }

    def data(self, values: list[Value]) -> Sequence[str] | None:
        """See `Owner`."""
        return None if self._data is None else self._data(values, self._from)

    def add(self, wanted: str) -> str:
        """See `Owner`; the name server says where the other port is."""
        carrier_name, _, name = wanted.rpartition(":/")
        name = name if carrier_name else wanted
        try:
            carrier = carrier_named(carrier_name or Carrier.TCP.value)
            if self.server is None:
                return f"Do not know how to connect to {wanted}: there is no name server"
            there = self.server.ask(query(name), self.name).registration
            if there is None:
                return f"Do not know how to connect to {wanted}"
            self.remove(name)
            connection = connected(carrier, self.name, name, (there.host, there.port))
        except (InputError, OSError) as error:
            return f"Cannot connect to {wanted}: {error}"
        self._connections.append(connection)
        return f"Added connection from {self.name} to {wanted}"

    def remove(self, name: str) -> str:
        """See `Owner`."""
        for each in self._connections:
            if each.output is not None and each.output.name == name and not each.gone:
                self._connections.remove(each)
                each.close()
                return f"Removed connection from {self.name} to {name}"
        return f"Could not find an outgoing connection to {name}"

    def close(self) -> None:
        """Say goodbye to all readers and let go; the name server is told by `unregister`."""
        for each in self._connections:
            each.close()
        self._connections.clear()
        self._listener.close()


def _host_of(sock: socket.socket) -> str:
    try:
        return str(sock.getpeername()[0])
    except OSError:
        return "127.0.0.1"
