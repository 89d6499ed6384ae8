"""Where buses and devices are, from the words of a command line."""

from collections.abc import Sequence

from skinfield.errors import InputError
from skinfield.sources.buses import BusSettings
from skinfield.sources.buses.settings import GROUP, PORT


def host_and_port(text: str, host: str, port: int) -> tuple[str, int]:
    """Host and port from ``"192.0.2.7:5000"``, ``"[::1]:5000"``, ``"192.0.2.7"`` or ``":5000"``.

    Parameters
    ----------
    text : str
    host, port
        Where the text does not say.

    Raises
    ------
    InputError
        If the port is none.
    """
    before, colon, after = text.rpartition(":")
    if not colon or "]" in after or (":" in before and not before.startswith("[")):
        before, after = text, ""
    if after and not (after.isdecimal() and int(after) <= 65535):
        raise InputError(f"port of {text!r} is {after!r}, expected a number from 0 to 65535")
    return before.strip("[]") or host, int(after) if after else port


def bus_settings(bus: str, channels: Sequence[str], count: int, bitrate: int) -> list[BusSettings]:
    """Settings of `count` CAN buses of one interface.

    Parameters
    ----------
    bus : str
        See `BusSettings.interface`.
    channels : sequence of str
        One for each, or none for the usual ones. Of `udp_multicast`: ``group:port``, or
        ``group:port@local`` with the address of an interface of one's own (``@127.0.0.1``: what is
        sent stays on this machine). Of `udp`: ``host:port`` of the boards, or
        ``:port`` to wait for them at a port of one's own, ``0.0.0.0:port`` for those of other
        machines, too. Of others: the name of the channel.
    count : int
        Buses that the boards are on.

    Raises
    ------
    InputError
        If there are more channels or fewer, or one cannot be understood.
    """
    if channels and len(channels) != count:
        raise InputError(
            f"channels are {', '.join(channels)}, expected {count}: one for each bus that the "
            "boards are on"
        )
    return [
        _bus(bus, channels[i] if channels else "", i, bitrate if bus != "udp" else 0)
        for i in range(count)
    ]


def _bus(bus: str, channel: str, number: int, bitrate: int) -> BusSettings:
    if bus == "udp_multicast":
        place, _, local = channel.partition("@")
        group, port = host_and_port(place, GROUP, PORT + number)
        return BusSettings(bus, group, port, local=local)
    if bus == "udp":
        host, port = host_and_port(channel, "127.0.0.1", PORT + number)
        if listens(channel, host):
            return BusSettings(bus, host, port)
        named = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
        return BusSettings(bus, own_address(host), 0, named)
    if bus == "socketcan":
        return BusSettings(bus, channel or f"can{number}")
    return BusSettings(bus, channel, bitrate=bitrate)


def listens(text: str, host: str) -> bool:
    """Whether a place is one's own: none, a port alone, or all of one's addresses."""
    return not text or text.startswith(":") or host in ("0.0.0.0", "::")


def own_address(host: str) -> str:
    """Address to bind for talking with a host: this machine's own, or all of its own."""
    if host in ("127.0.0.1", "localhost", "::1"):
        return "::1" if host == "::1" else "127.0.0.1"
    return "::" if ":" in host else "0.0.0.0"
