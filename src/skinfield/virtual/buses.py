"""Addresses of buses, from the words of a command line."""

from skinfield.errors import InputError
from skinfield.sources.buses import Bus, BusSettings
from skinfield.sources.buses.settings import GROUP
from skinfield.sources.live.places import host_and_port
from skinfield.virtual.settings import VirtualSettings


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
        place, _, local = channel.partition("@")
        group, port = host_and_port(place, GROUP, usual.port + number)
        return BusSettings(interface=interface, channel=group, port=port, local=local)
    if interface == "udp":
        host, port = host_and_port(channel, "127.0.0.1", 0)
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
