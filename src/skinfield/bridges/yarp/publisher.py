"""Publisher of a running skin's contacts on a port of YARP, from a process of its own."""

import threading
import time
from contextlib import ExitStack, suppress

import numpy as np

from skinfield.bridges.child import say_ready
from skinfield.bridges.yarp.contacts import ContactList
from skinfield.bridges.yarp.settings import YarpSettings
from skinfield.errors import InputError
from skinfield.loop.client import Live, NotRunning, connect
from skinfield.loop.fit_ring import FitReader, best_contacts
from skinfield.loop.snapshot import Snapshot
from skinfield.skin import Patch
from skinfield.wire.yarp import Port, envelope

HERE = 10.0  # s to wait for the ring
SLICE = 0.02  # s at most without a look at the port
PAUSE = 2e-3  # s after a look that found no new reading
ASK = 10.0  # s between questions whether the name server still knows the port
NUMBERS = 1 << 31  # of messages, after which they begin anew


class Publisher:
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
        self._fit = FitReader(live.name)
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
            rows, _ = best_contacts(snapshot, self._fit)
            self.events.write([each.values for each in self._list.of(snapshot, rows)], stamp)
        for name, port in self.taxels.items():
            if port.readers:
                port.write(compensated(snapshot, self._live.skin[name]), stamp)

    def close(self) -> None:
        """Let go of the ports."""
        for port in self.ports:
            port.close()
        self._fit.close()


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
        publisher = Publisher(live, settings)
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
