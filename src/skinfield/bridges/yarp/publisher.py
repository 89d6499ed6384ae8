"""Publisher of a running skin's contacts on a port of YARP, from a process of its own."""

import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field

import numpy as np

from skinfield.bridges.child import say_ready
from skinfield.bridges.yarp.contacts import ContactList
from skinfield.errors import InputError, check_range
from skinfield.loop.client import Live, NotRunning, connect
from skinfield.loop.snapshot import Snapshot
from skinfield.skin import Patch
from skinfield.wire.can.bus import host_and_port
from skinfield.wire.yarp import PORT, NameServer, Port, checked_name, envelope

HERE = 10.0  # s to wait for the ring
SLICE = 0.02  # s at most without a look at the port
PAUSE = 2e-3  # s after a look that found no new reading
ASK = 10.0  # s between questions whether the name server still knows the port
NUMBERS = 1 << 31  # of messages, after which they begin anew
LOCAL = "127.0.0.1"
NOWHERE = "none"
USUAL = "robot"  # a robot that was not named


@dataclass(frozen=True, kw_only=True)
class YarpSettings:
    """What is published, where and how often.

    Parameters
    ----------
    robot : str
        Its name comes before the ports' of all robots but "robot".
    name_server : str, optional
        ``host:port``, where the ports are registered; default this machine's, port 10000;
        ``none``: nowhere, and then nobody can tell us to connect.
    port : str, optional
        Name of the port for contacts; default ``/skinfield/NAME/skin_events:o`` with the live
        skin's name, or ``/ROBOT/skinfield/NAME/...``. ``/skinManager/skin_events:o`` takes the
        place of skinManager's.
    host : str
        Address to listen at; empty for all of this machine.
    rate : float, 1/s
        Messages at most; the newest reading wins.
    parts : mapping of str to sequence of int
        Body part, link and skin part of patches whose names do not tell them.
    taxels : bool
        Whether what each patch's taxels read is published as well.
    """

    robot: str = USUAL
    name_server: str | None = None
    port: str | None = None
    host: str = ""
    rate: float = 100.0
    parts: Mapping[str, Sequence[int]] = field(default_factory=dict)
    taxels: bool = False

    def __post_init__(self) -> None:
        check_range("rate", self.rate, 0.1, 10_000.0, "messages per second")
        if self.port is not None:
            checked_name(self.port)
        self.server  # noqa: B018 - refuses an address that cannot be read

    @property
    def server(self) -> NameServer | None:
        """The name server; None for none."""
        text = self.name_server or LOCAL
        return None if text == NOWHERE else NameServer(*host_and_port(text, LOCAL, PORT))

    def prefix(self, name: str) -> str:
        """Before the names of the ports, of the live skin of that name."""
        return f"/skinfield/{name}" if self.robot == USUAL else f"/{self.robot}/skinfield/{name}"


class YarpPublisher:
    """Sends each new reading's contacts to whoever reads the port.

    Attributes
    ----------
    events : Port
    taxels : dict of str to Port
        By the names of patches; empty unless asked for.
    """

    def __init__(self, live: Live, settings: YarpSettings) -> None:
        self._live, self._every = live, 1.0 / settings.rate
        self._list = ContactList(live.skin, settings.parts)
        self._number, self._next = 0, 0.0
        prefix = settings.prefix(live.name)
        name = settings.port or f"{prefix}/skin_events:o"
        self.events = Port(name, settings.host, 0, settings.server)
        self.taxels: dict[str, Port] = {}
        try:
            for patch in live.skin if settings.taxels else ():
                name = f"{prefix}/{'_'.join(patch.name.split())}_comp:o"
                self.taxels[patch.name] = Port(name, settings.host, 0, settings.server)
        except BaseException:
            self.close()
            raise

    @property
    def ports(self) -> tuple[Port, ...]:
        """All."""
        return (self.events, *self.taxels.values())

    def step(self) -> None:
        """Listen to the ports, wait a little for a reading, and send it."""
        for port in self.ports:
            port.step()
        wait = self._next - time.monotonic()
        if wait > 0.0:
            self.events.step(min(wait, SLICE))
            return
        self._live.reader.wait(self._live.reader.number, SLICE)
        found = self._live.next_answered()
        now = time.monotonic()
        if found is not None and found.fresh:
            self._next = max(self._next + self._every, now - self._every)
            self.send(found)
        else:
            self._next = now + PAUSE

    def send(self, snapshot: Snapshot) -> None:
        """Send a reading: its contacts, none included, and what the taxels read."""
        stamp = envelope(self._number, snapshot.stamp_ns * 1e-9)
        self._number = (self._number + 1) % NUMBERS
        if self.events.readers:
            self.events.write([each.values for each in self._list.of(snapshot)], stamp)
        for name, port in self.taxels.items():
            if port.readers:
                port.write(compensated(snapshot, self._live.skin[name]), stamp)

    def close(self) -> None:
        """Let go of the ports."""
        for port in self.ports:
            port.close()


def compensated(snapshot: Snapshot, patch: Patch) -> list[float]:
    """What taxels read beyond their baseline, by channel; nan where one has no reading."""
    values, valid, _ = snapshot.taxels(patch.name)
    channels = np.zeros(patch.n_channels)
    channels[patch.channel] = np.where(valid, values, np.nan)
    found: list[float] = channels.tolist()
    return found


def keep_registered(ports: tuple[Port, ...], stop: threading.Event) -> None:
    """Register the ports again when the name server was started anew; until told to stop."""
    while not stop.wait(ASK):
        for port in ports:
            with suppress(InputError):  # not there now: asked again soon
                if port.server is not None and port.server.where(port.name, port.name) is None:
                    port.register()


def serve(name: str, settings: YarpSettings, stop: threading.Event) -> None:
    """Publish a running skin until told to stop; see `skinfield.bridges.child`."""
    with ExitStack() as ends:
        live = ends.enter_context(connect(name, timeout=HERE))
        publisher = YarpPublisher(live, settings)
        ends.callback(publisher.close)
        for port in publisher.ports:
            port.register()
            ends.callback(_unregister, port)
        watch = threading.Thread(target=keep_registered, args=(publisher.ports, stop), daemon=True)
        watch.start()
        say_ready(
            port=publisher.events.name,
            socket=publisher.events.socket_port,
            taxels=[port.name for port in publisher.taxels.values()],
            name_server=None if settings.server is None else
            f"{settings.server.host}:{settings.server.port}",
        )  # fmt: skip
        while not stop.is_set():
            publisher.step()
            if live.reader.replaced():
                raise NotRunning(f"{name!r} was started anew: the bridge begins anew, too")


def _unregister(port: Port) -> None:
    with suppress(InputError):  # a name server that is gone knows nothing any more
        port.unregister()
