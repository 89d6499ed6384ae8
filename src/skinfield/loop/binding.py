"""Binding of taxels to channels: which channel each taxel of a skin is read from."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skinfield.errors import InputError, Ints
from skinfield.signal import Port
from skinfield.skin import Skin


@dataclass(frozen=True, eq=False)
class Binding:
    """Taxels of all patches, in the skin's order, and their channels among all ports.

    Attributes
    ----------
    channel : (L,) array
    starts : (P + 1,) array
        Where each patch's taxels begin.
    channels : int
        Of all ports together.
    first : tuple of int
        Channel at which each port begins.
    ports : tuple of Port
    port_of : tuple of int
        Port of each patch.
    """

    channel: Ints
    starts: Ints
    channels: int
    first: tuple[int, ...]
    ports: tuple[Port, ...]
    port_of: tuple[int, ...]

    @property
    def unit(self) -> str:
        """Of the readings: that of the ports, which must have one in common."""
        return self.ports[self.port_of[0]].unit


def bind(skin: Skin, ports: Sequence[Port]) -> Binding:
    """Find the port of each patch: that of its name, or the only one.

    Raises
    ------
    InputError
        If a patch has no port, one that is too short, or ports deliver different units.
    """
    ports = tuple(ports)
    if not ports:
        raise InputError("there is no port, expected a source with at least one")
    first = tuple(np.cumsum([0, *(port.channels for port in ports)]).tolist())
    rows, starts, port_of = [], [0], []
    for patch in skin:
        place = _port_of((patch.name, skin.name) if len(skin) == 1 else (patch.name,), ports)
        port = ports[place]
        highest = int(patch.channel.max())
        if highest >= port.channels:
            raise InputError(
                f"patch {patch.name!r} reads channel {highest}, expected channels below "
                f"{port.channels}: port {port.name!r} has no more; is this the layout of that "
                "skin, and are all its boards listed?"
            )
        rows.append(patch.channel + first[place])
        starts.append(starts[-1] + len(patch))
        port_of.append(place)
    units = {ports[place].unit for place in port_of}
    if len(units) > 1:
        raise InputError(
            f"ports deliver {', '.join(sorted(units))}, expected one unit for all patches of an "
            "engine: run two engines"
        )
    return Binding(
        np.concatenate(rows).astype(np.int64),
        np.array(starts, np.int64),
        first[-1],
        first[:-1],
        ports,
        tuple(port_of),
    )


def _port_of(wanted: Sequence[str], ports: Sequence[Port]) -> int:
    """Port of the first of these names that there is; a skin of one patch may name it itself."""
    names = [port.name for port in ports]
    for name in wanted:
        if name in names:
            return names.index(name)
    if len(ports) == 1:
        return 0
    raise InputError(
        f"patch {wanted[0]!r} has no port, expected one of its name among {', '.join(names)}: "
        "name the port after the patch"
    )
