"""Sockets of the buses over UDP: where to listen, where to send."""

import socket
import struct
import sys
from contextlib import suppress
from typing import NamedTuple, cast

from skinfield.errors import InputError
from skinfield.sources.buses.settings import GROUP, BusSettings
from skinfield.sources.buses.system import set_options

Address = tuple[str | int, ...]
HERE = "127.0.0.1"  # as `local`: stay on this machine


class Place(NamedTuple):
    """An address that the system can use."""

    family: int
    address: Address


def resolved(host: str, port: int, name: str) -> Place:
    """Address of a host.

    Raises
    ------
    InputError
        If it is not understood.
    """
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
    except (OSError, UnicodeError) as error:
        raise InputError(
            f"{name} is {host!r}, expected an address or a host's name: {error}"
        ) from None
    family, _, _, _, address = found[0]
    return Place(int(family), cast(Address, address))


def peer_of(settings: BusSettings) -> Place | None:
    """The configured peer of a bus over plain UDP."""
    if not settings.peer:
        return None
    host, _, port = settings.peer.rpartition(":")
    if not host or not port.isdigit() or not 0 < int(port) < 65536:
        raise InputError(f"peer is {settings.peer!r}, expected host:port, as in 127.0.0.1:43113")
    return resolved(host.strip("[]"), int(port), "peer")


def group_of(settings: BusSettings) -> Place:
    """The group of a multicast bus.

    Raises
    ------
    InputError
        If the channel is no group.
    """
    place = resolved(settings.channel or GROUP, settings.port, "channel")
    octets = socket.inet_pton(place.family, str(place.address[0]).partition("%")[0])
    is_group = octets[0] >> 4 == 14 if place.family == socket.AF_INET else octets[0] == 0xFF
    if not is_group or settings.port == 0:
        raise InputError(
            f"channel is {settings.channel!r}, port {settings.port}, expected a multicast group "
            f"(224.0.0.0/4, as {GROUP}, or ff00::/8) and its port; one address only: interface udp"
        )
    return place


def multicast_receiver(group: Place, local: str) -> tuple[socket.socket, int]:
    """Member of a group, always on the loopback too; the socket and the bytes of its buffer.

    Raises
    ------
    OSError
        If the system has no such interface now, or no multicast.
    """
    sock = socket.socket(group.family, socket.SOCK_DGRAM)
    try:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if hasattr(socket, "SO_REUSEPORT"):  # python-can sets it, so all at the port must
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        size = set_options(sock)
        # bound to the group itself where the system can: other groups at the port stay out
        any_host = "" if sys.platform != "linux" else str(group.address[0])
        sock.bind((any_host, *group.address[1:]))
        chosen = "" if local == HERE else local
        failures = [error for each in (chosen, HERE) if (error := _join(sock, group, each))]
        if len(failures) == 2 or (chosen and failures):
            raise failures[0]
    except BaseException:
        sock.close()
        raise
    return sock, size


def _join(sock: socket.socket, group: Place, local: str) -> OSError | None:
    """Become a member on an interface; why not."""
    octets = socket.inet_pton(group.family, str(group.address[0]).partition("%")[0])
    try:
        if group.family == socket.AF_INET:
            member = octets + socket.inet_aton(local or "0.0.0.0")
            sock.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
        else:
            member = octets + struct.pack("@I", _index(local))
            sock.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_JOIN_GROUP, member)
    except OSError as error:
        return error
    return None


def _index(local: str) -> int:
    """Number of an interface; 0: the system chooses."""
    return socket.if_nametoindex("lo" if local == HERE else local) if local else 0


def multicast_sender(group: Place, local: str) -> socket.socket:
    """Socket of its own port to send to a group: so its datagrams can be told from others'.

    A machine without any network has no way to the group but its loopback, which is taken then.
    """
    hops = 0 if local == HERE else 1  # with 0, datagrams reach all on this machine and no other
    try:
        return _sender(group, "" if local == HERE else local, hops)
    except OSError:
        if local not in ("", HERE):
            raise
        return _sender(group, HERE, hops)


def _sender(group: Place, local: str, hops: int) -> socket.socket:
    sock = socket.socket(group.family, socket.SOCK_DGRAM)
    try:
        if group.family == socket.AF_INET:
            sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, hops)
            sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
            if local:
                own = socket.inet_aton(local)
                sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, own)
        else:
            sock.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_HOPS, hops)
            if local:
                sock.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_IF, _index(local))
        set_options(sock)
        sock.connect(group.address)
    except BaseException:
        sock.close()
        raise
    return sock


def unicast_socket(own: Place) -> tuple[socket.socket, int]:
    """Bound socket for both directions; the bytes of its receive buffer."""
    sock = socket.socket(own.family, socket.SOCK_DGRAM)
    try:
        size = set_options(sock)
        sock.bind(own.address)
    except BaseException:
        sock.close()
        raise
    return sock, size


def let_go(sock: socket.socket | None) -> None:
    """Close, whatever state it is in."""
    if sock is not None:
        with suppress(OSError):
            sock.close()
