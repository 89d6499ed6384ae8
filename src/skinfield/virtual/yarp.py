"""A robot's ports of YARP, one for each patch, and the name server that knows them."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from skinfield.conditioning import ICubByte
from skinfield.errors import Floats, InputError
from skinfield.layout import Patch, Skin
from skinfield.protocols.yarp import (
    PORT,
    NameServer,
    NameTable,
    Port,
    Registration,
    envelope,
    port_of,
)
from skinfield.sources.live.places import host_and_port
from skinfield.virtual.electronics import (
    Converters,
    converters_from,
    starts_of,
)
from skinfield.virtual.patch_faults import PatchFaults
from skinfield.virtual.schedule import Schedule
from skinfield.virtual.settings import VirtualSettings

PERIOD = 0.02  # s, as robots publish their skin
REST = float(ICubByte().no_load)
REGISTER = "register"
SECOND = 1e-9  # s per ns


class Sender:
    """One port with what it is about to send.

    Attributes
    ----------
    patch : Patch
    port : Port
    values : (n_channels,) array
    number : int
        Of the next message.
    quiet : bool
        While it is away.
    unplugged : set of int
        Modules.
    """

    def __init__(self, patch: Patch, host: str, server: NameServer | None) -> None:
        self.patch, self.port = patch, Port(port_of(patch.name), host, 0, server)
        self.values: Floats = np.full(patch.n_channels, REST)
        self.number, self.quiet = 0, False
        self.unplugged: set[int] = set()

    def send(self, counts: Floats, now_ns: int, withheld: bool) -> int:
        """Send the counts of the taxels; how many got them."""
        self.values[self.patch.channel] = counts
        for module in self.unplugged:
            self.values[self.patch.channel[self.patch.module == module]] = 0.0
        number, self.number = self.number, (self.number + 1) % (1 << 31)
        if withheld:
            return 0
        return self.port.write(self.values.tolist(), envelope(number, now_ns * SECOND))


class YarpPorts(PatchFaults[Sender]):
    """See `hardware.Hardware`.

    The channel is ``host:port``, where a small name server of its own answers (127.0.0.1:10000), or
    ``register:host:port`` of a robot's name server, which is told of the ports.

    Parameters
    ----------
    skin : Skin
    settings : VirtualSettings
    """

    def __init__(self, skin: Skin, settings: VirtualSettings) -> None:
        if len(settings.channels) > 1:
            raise InputError(f"channels are {list(settings.channels)}, expected a name server's")
        rng = np.random.default_rng([settings.seed, 2])
        self._rng = np.random.default_rng([settings.seed, 4])
        self._starts = starts_of(skin)
        self.converters: Converters = byte_converters(skin, settings)
        self.schedule = Schedule(settings.spread, settings.wires.jitter, rng)
        self._rate = settings.rate
        self.readings = self.sent = self.withheld = self.lost = 0
        self._root: Port | None = None
        super().__init__("port", [])
        self.set_chances(settings.wires.lose, settings.wires.duplicate, settings.wires.swap)
        try:
            self._open(skin, settings.channels[0] if settings.channels else "")
        except BaseException:
            self.close()
            raise

    def _open(self, skin: Skin, channel: str) -> None:
        word, _, rest = channel.partition(":")
        elsewhere = word == REGISTER
        host, port = host_and_port(rest if elsewhere else channel, "127.0.0.1", PORT)
        server = NameServer(host, port) if elsewhere else None
        table = NameTable()
        if not elsewhere:
            self._root = Port("/root", host, port, data=table.answer)
        for patch in skin:
            sender = Sender(patch, "" if elsewhere else host, server)
            self.devices.append(sender)
            sender.port.register()
            if not elsewhere:
                name = sender.port.name
                table.known[name] = Registration(name, host, sender.port.socket_port)
        self._address = f"{host}:{self._root.socket_port if self._root else port}"

    @property
    def addresses(self) -> list[str]:
        """See `Hardware`: of the name server."""
        return [self._address]

    @property
    def chances(self) -> Mapping[str, float]:
        """See `Hardware`."""
        return {"lose": self._lose, "duplicate": 0.0, "swap": 0.0}

    def set_chances(self, lose: float, duplicate: float, swap: float) -> None:
        """See `Hardware`; a lost message is one that the port left out."""
        if duplicate or swap:
            raise InputError("ports of YARP neither double nor swap messages, expected 0 for both")
        self._lose = lose

    def start(self, now_ns: int) -> None:
        """See `Hardware`; nothing is sent before somebody reads."""
        self._reschedule(now_ns)

    def _reschedule(self, now_ns: int) -> None:
        period = round(1e9 / self._rate if self._rate else 1e9 * PERIOD)
        periods = {
            place: period
            for place, sender in enumerate(self.devices)
            if sender.port.readers and not sender.quiet
        }
        self.schedule.set(periods, len(self.devices), now_ns)

    def filenos(self) -> Sequence[int]:
        """See `Hardware`."""
        root = self._root.filenos() if self._root is not None else []
        return [*root, *(number for each in self.devices for number in each.port.filenos())]

    def listen(self, now_ns: int, warmth: float) -> None:
        """See `Hardware`."""
        if self._root is not None:
            self._root.step()
        for sender in self.devices:
            sender.port.step()
        self._reschedule(now_ns)

    def send(self, members: Sequence[int], now_ns: int) -> None:
        """See `Hardware`."""
        for place in members:
            sender = self.devices[place]
            first, last = self._starts[place], self._starts[place + 1]
            lost = bool(self._lose) and self._rng.random() < self._lose
            self.lost += lost
            self.withheld += self.off
            counts = self.converters.counts[first:last]
            self.sent += sender.send(counts, now_ns, self.off or lost)
            sender.port.step()
        self.readings += len(members)

    def _went(self, device: Sender) -> None:
        device.number = 0

    def counts(self) -> dict[str, Any]:
        """See `Hardware`."""
        return {
            "messages": self.sent,
            "lost": self.lost,
            "duplicated": 0,
            "swapped": 0,
            "refused": sum(sender.port.skipped for sender in self.devices),
            "withheld": self.withheld,
            "commands": 0,
            "reboots": self.reboots,
        }

    def close(self) -> None:
        """See `Hardware`."""
        for sender in self.devices:
            with suppress(InputError):  # a name server that is gone knows nothing any more
                sender.port.unregister()
            sender.port.close()
        if self._root is not None:
            self._root.close()


def byte_converters(skin: Skin, settings: VirtualSettings) -> Converters:
    """Bytes of the taxels of all patches, as the robot's boards make them of iCub's skin."""
    return converters_from(skin, settings, REST, 255.0)
