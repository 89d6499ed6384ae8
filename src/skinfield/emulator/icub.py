"""Skin boards of an iCub: they obey the host's messages, and send two messages per triangle."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.emulator.can_boards import CanBoards, CanWire, open_buses
from skinfield.emulator.electronics import Converters, manufacture, starts_of
from skinfield.emulator.settings import VirtualSettings
from skinfield.errors import Ints
from skinfield.skin import Skin
from skinfield.wire.icub import ICubBoardSettings, ICubEncoder, configuration_for
from skinfield.wire.icub.codec import GAINS
from skinfield.wire.icub.commands import (
    BOARD_CHANNELS,
    TAXELS,
    TRIANGLES,
    BoardState,
    Firmware,
    SkinType,
    addressed_board,
)
from skinfield.wire.icub.configuration import THERMAL

MIDDLE = 0x8000  # converter counts at rest, about
APART = 2000.0  # converter counts: how far taxels at rest are from there, at most
SIZE = -4.0  # converter counts per count of a byte, in which the electronics are given
LOW, HIGH = 1.0, 65534.0  # 0 is a converter that does not answer, 65535 one that is not there
PAD_DRIFT = 10.0  # converter counts/K of a thermal pad; assumed
PAD_NOISE = 2.0  # converter counts; pads of a real foot had 0.5 to 0.7 of a byte at a shift of 2
UNPLUGGED = 0xFFFF
Shorts = NDArray[np.uint16]


@dataclass(frozen=True)
class EmulatedICubBoard:
    """One board.

    Attributes
    ----------
    place : ICubBoardSettings
        Its bus and address, and how a host will configure it.
    patch : int
    triangles : tuple of int
        That are there: those with a taxel.
    row : int
        Of its first triangle among those of all boards.
    """

    place: ICubBoardSettings
    patch: int
    triangles: tuple[int, ...]
    row: int

    @property
    def rows(self) -> slice:
        """Of its triangles."""
        return slice(self.row, self.row + len(self.triangles))

    @property
    def pads(self) -> bool:
        """Whether its triangles have thermal pads."""
        return self.place.board.kind == SkinType.COMPENSATED


def boards_of(skin: Skin) -> list[EmulatedICubBoard]:
    """Boards of all patches, at the addresses of `wire.icub.configuration_for`."""
    boards: list[EmulatedICubBoard] = []
    places, row = iter(configuration_for(*skin.patches).boards), 0
    for number, patch in enumerate(skin):
        for _ in range(0, patch.n_channels, BOARD_CHANNELS):
            place = next(places)
            triangles = tuple(t for t, each in enumerate(place.triangles) if each.enabled)
            boards.append(EmulatedICubBoard(place, number, triangles, row))
            row += len(triangles)
    return boards


def icub_converters(
    skin: Skin, settings: VirtualSettings, boards: list[EmulatedICubBoard]
) -> Converters:
    """Counts of the taxels of all patches, and then of two thermal pads for each triangle."""
    arrays, starts = manufacture(skin, settings), starts_of(skin)
    extra = sum(len(THERMAL) * len(board.triangles) for board in boards if board.pads)
    rng = np.random.default_rng([settings.seed, 3])
    level = np.rint(MIDDLE + rng.uniform(-APART, APART, int(starts[-1]) + extra))
    made = Converters(
        arrays, settings, level, (LOW, HIGH), size=SIZE,
        drift=PAD_DRIFT, white=PAD_NOISE * settings.noise_times, shared=len(THERMAL),
    )  # fmt: skip
    for number in {board.patch for board in boards if board.pads}:
        gains = np.array(GAINS, float)[arrays[number].wiring.stage]
        made.drift[starts[number] : starts[number + 1]] = PAD_DRIFT * gains / 128.0
    return made


def slots_of(skin: Skin, boards: list[EmulatedICubBoard]) -> Ints:
    """Where the channels of all converters are among the inputs (T, 12) of all triangles."""
    parts: list[Ints] = []
    for number, patch in enumerate(skin):
        rows = np.concatenate([_rows_on(board) for board in boards if board.patch == number])
        parts.append(rows[patch.channel // TAXELS] * TAXELS + patch.channel % TAXELS)
    for board in boards:
        if board.pads:
            rows = np.arange(board.rows.start, board.rows.stop)
            parts.append((rows[:, None] * TAXELS + np.array(THERMAL)).ravel())
    return np.concatenate(parts)


def _rows_on(board: EmulatedICubBoard) -> Ints:
    """Row of each of a board's 16 triangles; -1 of one that is not there."""
    rows = np.full(TRIANGLES, -1, np.int64)
    rows[list(board.triangles)] = np.arange(board.rows.start, board.rows.stop)
    return rows


class ICubBoards(CanBoards[BoardState]):
    """See `Hardware`."""

    part = "triangle"

    def __init__(self, skin: Skin, settings: VirtualSettings) -> None:
        self.boards = boards_of(skin)
        firmware = Firmware.MTB3 if settings.mtb3 else Firmware.MTB4
        fresh = [
            BoardState(
                firmware=firmware,
                kind=SkinType.COMPENSATED if board.pads else SkinType.UNCOMPENSATED,
                sending=settings.at_once,
                configured=settings.at_once,
            )
            for board in self.boards
        ]
        converters = icub_converters(skin, settings, self.boards)
        buses = open_buses(settings, 1 + self.boards[-1].place.bus)
        mine = [[b for b in self.boards if b.place.bus == bus] for bus in range(len(buses))]
        self._encoders = [
            ICubEncoder([(b.place.address, t) for b in each for t in b.triangles]) for each in mine
        ]
        wires = [
            CanWire(bus, 2 * len(encoder.triangles), settings, number)
            for number, (bus, encoder) in enumerate(zip(buses, self._encoders, strict=True))
        ]
        parts = [len(board.triangles) for board in self.boards]
        super().__init__(skin, settings, parts, converters, wires, fresh)
        self._slots = slots_of(skin, self.boards)
        self._raw: Shorts = np.full((sum(parts), TAXELS), MIDDLE, np.uint16)
        self._base, self._sends = self._raw.copy(), np.zeros(sum(parts), np.bool_)
        cuts = np.cumsum([len(encoder.triangles) for encoder in self._encoders])[:-1]
        views = (np.split(array, cuts) for array in (self._raw, self._base, self._sends))
        for encoder, raw, base, sends in zip(self._encoders, *views, strict=True):
            encoder.raw, encoder.base, encoder.sends = raw, base, sends
        for number in range(len(self.boards)):
            self._awake(number, settings.surroundings.warmth(0.0))

    def _obey(self, bus: int, identifier: int, data: bytes, warmth: float) -> bool:
        address = addressed_board(identifier)
        for number, board in enumerate(self.boards):
            if (board.place.bus, board.place.address) != (bus, address) or number in self.quiet:
                continue
            before = self.states[number]
            self.states[number] = before.after(data)
            self.commands += 1
            if self.states[number].calibrations != before.calibrations:
                self._calibrate(number, warmth)
            self._configure(number)
            return True
        return False

    def _calibrate(self, number: int, warmth: float) -> None:
        """Take the base of a board from what its converters read now: a press is in it."""
        rows, base = self.boards[number].rows, self._base.copy()
        base.reshape(-1)[self._slots] = self.converters.quiet(warmth)
        self._base[rows] = base[rows]

    def _configure(self, number: int) -> None:
        """Put a board's state into the encoder of its bus."""
        place = self.boards[number].place
        self._encoders[place.bus].follow(place.address, self.states[number])

    def send(self, members: Sequence[int], now_ns: int) -> None:
        """See `Hardware`."""
        self._raw.reshape(-1)[self._slots] = self.converters.counts
        for number, part in self.unplugged:
            self._raw[self.boards[number].row + part] = UNPLUGGED
        self._sends[:] = False
        for number in members:
            board, triangles = self.boards[number], self.states[number].triangles
            self._sends[board.rows] = [triangles[t].enabled for t in board.triangles]
        self.readings += len(members)
        for wire, encoder in zip(self._buses, self._encoders, strict=True):
            if encoder.sends.any():
                wire.send(encoder.encode(wire.made, 0, now_ns))

    def end(self, kind: str, what: str, now_ns: int, warmth: float) -> None:
        """See `Hardware`; a triangle that is plugged in again reads its base at first."""
        super().end(kind, what, now_ns, warmth)
        if kind == "unplug":
            for number, part in self.places(kind, what):
                row = self.boards[number].row + part
                self._raw[row] = self._base[row]

    def _awake(self, number: int, warmth: float) -> None:
        self._calibrate(number, warmth)
        self._configure(number)
