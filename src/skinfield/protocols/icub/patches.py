"""Patches laid out on boards, for skins that no robot's files describe."""

import numpy as np

from skinfield.errors import InputError, check_count
from skinfield.layout import Patch
from skinfield.protocols.icub.board import TriangleState
from skinfield.protocols.icub.commands import SetBoard
from skinfield.protocols.icub.configuration import BoardSettings, ICubConfiguration
from skinfield.protocols.icub.numbers import BOARD_CHANNELS, TAXELS, TRIANGLES, SkinType
from skinfield.protocols.icub.robot_wrapper import PortRun

THERMAL = (6, 10)  # channels of a triangle that feel warmth alone
FIRST_ADDRESS, ADDRESSES = 1, 14  # that the robots' Ethernet boards take for skin


def kind_for(patch: Patch) -> SkinType:
    """Kind of skin that boards of a patch are told.

    The correction of drift goes by pad 6 of each triangle, so it is on only where no taxel of the
    patch is at a thermal pad: with a taxel there, a press would count as warmth.
    """
    channel = np.asarray(patch.channel) % TAXELS
    whole = patch.n_channels % TAXELS == 0
    return (
        SkinType.COMPENSATED
        if whole and not np.isin(channel, THERMAL).any()
        else SkinType.UNCOMPENSATED
    )


def configuration_for(
    *patches: Patch, period_ms: int = 50, no_load: int = 240, shift: int = 2
) -> ICubConfiguration:
    """Boards for patches, as many as each one's channels need, one patch after the other.

    Channel c of a patch is taxel c % 12 of triangle c // 12 of its boards, 16 triangles to a board,
    so that the channels of its port are those of the patch. Boards have addresses 1 to 14 of the
    first bus, then of the next. Triangles without a taxel are switched off.

    Parameters
    ----------
    patches : Patch
        Of distinct names, which become those of the ports.
    period_ms, no_load, shift : int
        Of all boards; see `SetBoard` and `SetTriangles`.

    Returns
    -------
    ICubConfiguration
        With a port for each patch.
    """
    names = [patch.name for patch in patches]
    if not names or len(set(names)) < len(names):
        raise InputError(f"patches are named {names}, expected one or more, each name once")
    boards: list[BoardSettings] = []
    ports: list[PortRun] = []
    for patch in patches:
        used = set((np.asarray(patch.channel) // TAXELS).tolist())
        count = -(-patch.n_channels // BOARD_CHANNELS)
        check_count("boards", len(boards) + count, 1, 256 * ADDRESSES, "192 channels each")
        ports.append(PortRun(patch.name, len(boards) * BOARD_CHANNELS, count * BOARD_CHANNELS, 0))
        settings = SetBoard(kind=kind_for(patch), period_ms=period_ms, no_load=no_load)
        for board in range(count):
            bus, address = divmod(len(boards), ADDRESSES)
            triangles = tuple(
                TriangleState(enabled=board * TRIANGLES + t in used, shift=shift)
                for t in range(TRIANGLES)
            )
            boards.append(BoardSettings(bus, FIRST_ADDRESS + address, settings, triangles))
    buses = tuple(range(1 + boards[-1].bus))
    return ICubConfiguration(tuple(boards), buses, "+".join(names), tuple(ports))


def boards_for(*patches: Patch) -> tuple[tuple[int, int], ...]:
    """(bus, address) of the boards of `configuration_for`, in the order of the channels."""
    return configuration_for(*patches).addresses
