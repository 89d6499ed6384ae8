"""Skin boards of an iCub: they obey the host's messages, and send two messages per triangle."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from skinfield.emulator.can_boards import CanBoards, CanWire, open_buses
from skinfield.emulator.electronics import Converters, Others, converters_for, manufacture
from skinfield.emulator.hardware import Fates, Schedule
from skinfield.emulator.settings import VirtualSettings
from skinfield.errors import Ints
from skinfield.simulate.electronics import ThermalPads
from skinfield.skin import Skin
from skinfield.wire.can import Bus
from skinfield.wire.icub import ICubEncoder, configuration_for
from skinfield.wire.icub.commands import (
    BOARD_CHANNELS,
    TAXELS,
    BoardState,
    Firmware,
    SkinType,
    addressed_board,
)
from skinfield.wire.icub.configuration import THERMAL, kind_for

MIDDLE = 0x8000  # converter counts at rest, about
APART = 2000.0  # converter counts: how far taxels at rest are from there, at most
LOW, HIGH = 1.0, 65534.0  # 0 is a converter that does not answer, 65535 one that is not there
UNPLUGGED = 0xFFFF


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
    """Boards of all patches, at the addresses of `wire.icub.configuration_for`.

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
    arrays, pads = manufacture(skin, settings), ThermalPads()
    size = -4.0  # converter counts per count of a byte, in which the electronics are given
    drift = size * np.concatenate([array.drift for array in arrays])
    first = 0
    for patch, array in zip(skin, arrays, strict=True):
        if kind_for(patch) == SkinType.COMPENSATED:
            gains = np.array(pads.gains, float)[array.wiring.stage]
            drift[first : first + len(patch)] = pads.per_kelvin * gains / 128.0
        first += len(patch)
    extra = sum(len(THERMAL) * len(board.triangles) for board in boards if board.pads)
    rng = np.random.default_rng([settings.seed, 3])
    level = np.rint(MIDDLE + rng.uniform(-APART, APART, len(drift) + extra))
    others = Others(pads.per_kelvin, pads.noise * settings.noise, len(THERMAL))
    return converters_for(
        arrays, settings, level, (LOW, HIGH), size=size, drift=drift, others=others
    )


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


@dataclass
class Line:
    """One bus with its triangles.

    Attributes
    ----------
    wire : CanWire
    encoder : ICubEncoder
    slots : (C,) int64 array
        See `slots_of`.
    """

    wire: CanWire
    encoder: ICubEncoder
    slots: Ints


class ICubBoards(CanBoards[BoardState]):
    """See `Hardware`."""

    part = "triangle"

    def __init__(self, skin: Skin, settings: VirtualSettings) -> None:
        self.boards = boards_of(skin)
        rng = np.random.default_rng([settings.seed, 2])
        firmware = Firmware.MTB3 if settings.mtb3 else Firmware.MTB4
        fresh = [_fresh(board, firmware, settings) for board in self.boards]
        converters = icub_converters(skin, settings, self.boards)
        self._lines = [
            self._line(skin, settings, firmware, bus, number, rng)
            for number, bus in enumerate(open_buses(settings, 1 + self.boards[-1].bus))
        ]
        schedule = Schedule(settings.spread, settings.wires.jitter, rng)
        wires = [line.wire for line in self._lines]
        parts = [len(board.triangles) for board in self.boards]
        super().__init__(fresh, parts, converters, schedule, wires, settings.rate)
        for board in range(len(self.boards)):
            self._base(board, settings.temperature.warmth(0.0))
            self._configure(board)
        self._encode(range(len(self._lines)), 0)  # compiles before the first reading

    def _line(
        self,
        skin: Skin,
        settings: VirtualSettings,
        firmware: Firmware,
        bus: Bus,
        number: int,
        rng: np.random.Generator,
    ) -> Line:
        triangles = [
            (board.address, triangle)
            for board in self.boards
            if board.bus == number
            for triangle in board.triangles
        ]
        wire = CanWire(bus, 2 * len(triangles), Fates(settings.wires, rng))
        encoder = ICubEncoder(triangles, BoardState(firmware=firmware))
        return Line(wire, encoder, slots_of(skin, self.boards, number))

    def _obey(self, bus: int, identifier: int, data: bytes, warmth: float) -> bool:
        address = addressed_board(identifier)
        for number, board in enumerate(self.boards):
            if (board.bus, board.address) != (bus, address) or number in self.quiet:
                continue
            before = self.states[number]
            self.states[number] = before.after(data)
            self.commands += 1
            if self.states[number].calibrations != before.calibrations:
                self._base(number, warmth)
            self._configure(number)
            return True
        return False

    def _base(self, number: int, warmth: float) -> None:
        """Take the base of a board from what its converters read now: a press is in it."""
        board = self.boards[number]
        quiet = self.converters.quiet(warmth)
        encoder = self._lines[board.bus].encoder
        slots = self._lines[board.bus].slots
        base = encoder.base.reshape(-1)
        mine = np.flatnonzero((slots >= board.row * TAXELS) & (slots < board.end * TAXELS))
        base[slots[mine]] = quiet[mine]

    def _configure(self, number: int) -> None:
        """Put a board's state into the encoder of its bus."""
        board = self.boards[number]
        self._lines[board.bus].encoder.follow(board.address, self.states[number])

    def send(self, members: Sequence[int], now_ns: int) -> None:
        """See `Hardware`."""
        for line in self._lines:
            line.encoder.sends[:] = False
        used = set()
        for number in members:
            board, state = self.boards[number], self.states[number]
            sends = self._lines[board.bus].encoder.sends
            for row, triangle in enumerate(board.triangles, board.row):
                sends[row] = state.triangles[triangle].enabled
            used.add(board.bus)
        self.readings += len(members)
        for bus, count in zip(used, self._encode(used, now_ns), strict=True):
            self._lines[bus].wire.send(count)

    def _encode(self, buses: Iterable[int], now_ns: int) -> list[int]:
        """Write the messages of the boards that send; how many, on each bus."""
        from skinfield.emulator.kernels import scatter

        counts = []
        for bus in buses:
            line = self._lines[bus]
            scatter(self.converters.counts, line.slots, line.encoder.raw.reshape(-1))
            for board, part in self.unplugged:
                if self.boards[board].bus == bus:
                    line.encoder.raw[self.boards[board].row + part] = UNPLUGGED
            counts.append(line.encoder.encode(line.wire.made, 0, now_ns))
        return counts

    def end(self, kind: str, what: str, now_ns: int, warmth: float) -> None:
        """See `Hardware`; a triangle that is plugged in again reads its base at first."""
        super().end(kind, what, now_ns, warmth)
        if kind == "unplug":
            for number, part in self.places(kind, what):
                board = self.boards[number]
                encoder = self._lines[board.bus].encoder
                encoder.raw[board.row + part] = encoder.base[board.row + part]

    def _awake(self, number: int, warmth: float) -> None:
        self._base(number, warmth)
        self._configure(number)


def _fresh(board: Board, firmware: Firmware, settings: VirtualSettings) -> BoardState:
    """State of a board after switching on."""
    kind = SkinType.COMPENSATED if board.pads else SkinType.UNCOMPENSATED
    fresh = BoardState(firmware=firmware, kind=kind)
    return replace(fresh, sending=True, configured=True) if settings.at_once else fresh
