"""A microcontroller that sends the counts of one patch."""

from dataclasses import dataclass, field
from time import monotonic_ns

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.layout import Patch, Skin
from skinfield.protocols.packet import PacketEncoder
from skinfield.virtual.electronics import Converters, converters_from
from skinfield.virtual.settings import VirtualSettings

REST = 1000.0  # counts of an unloaded taxel
PERIOD = 0.02  # s, where nobody says another


@dataclass
class Device:
    """One microcontroller.

    Attributes
    ----------
    patch : Patch
    number : int
    encoder : PacketEncoder
    values : (n_channels,) array
    period : float, s
    sending, quiet : bool
    """

    patch: Patch
    number: int
    encoder: PacketEncoder
    values: Floats
    period: float = PERIOD
    sending: bool = True
    quiet: bool = False
    unplugged: set[int] = field(default_factory=set)
    booted_ns: int = field(default_factory=monotonic_ns)

    @property
    def clock_us(self) -> int:
        """Of its own clock."""
        return (monotonic_ns() - self.booted_ns) // 1000


def device_of(patch: Patch, number: int) -> Device:
    """A device for a patch."""
    if patch.n_channels > 65535:
        raise InputError(
            f"patch {patch.name!r} has {patch.n_channels} channels, expected up to 65535 for "
            "packets: split it up"
        )
    encoder = PacketEncoder(patch.n_channels, device=number)
    encoder.encode(np.zeros(patch.n_channels), 0)  # compiles before the first reading
    encoder.sequence = encoder.reading = 0
    return Device(patch, number, encoder, np.full(patch.n_channels, REST))


def packet_converters(skin: Skin, settings: VirtualSettings) -> Converters:
    """Counts of the taxels of all patches."""
    return converters_from(skin, settings, REST, 65535.0)
