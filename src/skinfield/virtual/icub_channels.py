"""Which board, triangle and input each taxel of a patch is at, and what its converters count."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Ints
from skinfield.layout import Skin
from skinfield.protocols.icub import configuration_for
from skinfield.protocols.icub.numbers import BOARD_CHANNELS, TAXELS, SkinType
from skinfield.protocols.icub.patches import THERMAL, kind_for
from skinfield.simulate.electronics import ThermalPads
from skinfield.virtual.electronics import Converters, converters_of, joined, manufacture
from skinfield.virtual.settings import VirtualSettings

MIDDLE = 0x8000  # converter counts at rest, about
APART = 2000.0  # converter counts: how far taxels at rest are from there, at most
LOW, HIGH = 1.0, 65534.0  # 0 is a converter that does not answer, 65535 one that is not there


@dataclass(frozen=True)
class Board:
    """One board.

    Attributes
    ----------
    bus, address : int
    patch : int
    channel : int
        Of the patch, at which it begins.
    triangles : tuple of int
        That are there.
    row : int
        Of its first triangle among those of its bus.
    pads : bool
        Whether its triangles have thermal pads.
    """

    bus: int
    address: int
    patch: int
    channel: int
    triangles: tuple[int, ...]
    row: int
    pads: bool

    @property
    def end(self) -> int:
        """Row behind its last triangle."""
        return self.row + len(self.triangles)


def boards_of(skin: Skin) -> list[Board]:
    """Boards of all patches, at the addresses of `protocols.icub.configuration_for`.

    Triangles without a taxel are not there.
    """
    boards: list[Board] = []
    rows: dict[int, int] = {}
    addresses = iter(configuration_for(*skin.patches).boards)
    for number, patch in enumerate(skin):
        pads = kind_for(patch) == SkinType.COMPENSATED
        for first in range(0, patch.n_channels, BOARD_CHANNELS):
            place = next(addresses)
            triangles = tuple(t for t, each in enumerate(place.triangles) if each.enabled)
            row = rows.get(place.bus, 0)
            boards.append(Board(place.bus, place.address, number, first, triangles, row, pads))
            rows[place.bus] = row + len(triangles)
    return boards


def icub_converters(skin: Skin, settings: VirtualSettings, boards: list[Board]) -> Converters:
    """Counts of the taxels of all patches, and then of two thermal pads for each triangle."""
    arrays = manufacture(skin, settings)
    size = 1 << 2  # converter counts per count of a byte, in which the electronics are given
    gain, white = -size * joined(arrays, "gain"), size * joined(arrays, "white_noise")
    drift = -size * joined(arrays, "drift")
    pads = ThermalPads()
    if settings.pads:
        first = 0
        for patch, array in zip(skin, arrays, strict=True):
            if kind_for(patch) == SkinType.COMPENSATED:
                gains = np.array(pads.gains, float)[array.wiring.stage]
                drift[first : first + len(patch)] = pads.per_kelvin * gains / 128.0
            first += len(patch)
    extra = _pads_of(boards)
    rng = np.random.default_rng([settings.seed, 3])
    level = np.rint(MIDDLE + rng.uniform(-APART, APART, len(gain) + extra))
    zeros = np.zeros(extra)
    warm = pads.per_kelvin if settings.pads else 0.0
    converter = converters_of(arrays)
    last = int(converter.max()) + 1
    return Converters(
        level,
        np.concatenate([gain, zeros]),
        np.concatenate([drift, zeros + warm]),
        np.concatenate([white, zeros + pads.noise * settings.noise]),
        np.concatenate([converter, last + np.arange(extra) // len(THERMAL)]),
        common=size * settings.common_noise,
        low=LOW,
        high=HIGH,
        seed=settings.seed,
    )


def _pads_of(boards: list[Board]) -> int:
    return sum(len(THERMAL) * len(board.triangles) for board in boards if board.pads)


def slots_of(skin: Skin, boards: list[Board], bus: int) -> Ints:
    """Where the channels of all converters are among the triangles' inputs of a bus; -1: not there.

    Parameters
    ----------
    skin : Skin
    boards : list of Board
        Of all buses.
    bus : int
    """
    parts: list[Ints] = []
    for number, patch in enumerate(skin):
        slots = np.full(len(patch), -1, np.int64)
        for board in boards:
            if (board.bus, board.patch) == (bus, number):
                slots[:] = np.where(slots < 0, _slots_on(board, patch.channel), slots)
        parts.append(slots)
    for board in boards:
        if board.pads:
            rows = np.arange(board.row, board.end)
            places = (rows[:, None] * TAXELS + np.array(THERMAL)).ravel()
            parts.append(places if board.bus == bus else np.full(len(places), -1, np.int64))
    return np.concatenate(parts).astype(np.int64)


def _slots_on(board: Board, channel: Ints) -> Ints:
    within = channel - board.channel
    triangle = within // TAXELS
    row = np.searchsorted(board.triangles, triangle)
    there = (within >= 0) & (within < BOARD_CHANNELS)
    return np.where(there, (board.row + row) * TAXELS + within % TAXELS, -1)
