"""Addresses of buses, from the words of a command line."""

from skinfield.errors import InputError
from skinfield.sources.buses import Bus, BusSettings
from skinfield.virtual.settings import VirtualSettings

HIGHEST = 65535  # port


def host_and_port(text: str, default: tuple[str, int]) -> tuple[str, int]:
    """Host and port from ``"127.0.0.1:5000"``, ``"[::1]:5000"``, ``"127.0.0.1"`` or ``":0"``.

    Raises
    ------
    InputError
        If the port is none.
    """
    host, colon, port = text.rpartition(":")
    if not colon or ("]" in port) or (host.count(":") and not host.startswith("[")):
        host, port = text, ""
    if port and not (port.isdecimal() and int(port) <= HIGHEST):
        raise InputError(f"port of {text!r} is {port!r}, expected a number from 0 to {HIGHEST}")
    return host.strip("[]") or default[0], int(port) if port else default[1]


def bus_settings(settings: VirtualSettings, count: int) -> list[BusSettings]:
    """Settings of `count` CAN buses, one per channel that is named, the rest by default.

    Raises
    ------
    InputError
        If more channels are named than the boards need, or fewer than there must be.
    """
    given = settings.channels
    if len(given) > count or (given and len(given) < count):
        raise InputError(
            f"channels are {list(given)}, expected {count}, one for each bus: the boards of this "
            f"skin need {count} of them, with sixteen boards each"
        )
    return [_bus(settings.bus, given[i] if given else "", i) for i in range(count)]


def _bus(interface: str, channel: str, number: int) -> BusSettings:
    if interface == "udp_multicast":
        usual = BusSettings()
        host, port = host_and_port(channel, (usual.channel, usual.port + number))
        return BusSettings(interface=interface, channel=host, port=port)
    if interface == "udp":
        host, port = host_and_port(channel, ("127.0.0.1", 0))
        return BusSettings(interface=interface, channel=host, port=port)
    usual_channel = f"can{number}" if interface == "socketcan" else ""
    return BusSettings(interface=interface, channel=channel or usual_channel)


def address_of(bus: Bus) -> str:
    """Where a host finds a bus."""
    place = getattr(bus, "address", None)
    if place is not None:
        return f"{place[0]}:{place[1]}"
    known = getattr(bus, "settings", None)
    return known.channel if isinstance(known, BusSettings) else ""
