"""Skin boards of an iCub: they obey the host's messages, and send two messages per triangle."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from skinfield.errors import Ints
from skinfield.layout import Skin
from skinfield.protocols.icub import ICubEncoder
from skinfield.protocols.icub.board import BoardState
from skinfield.protocols.icub.commands import addressed_board
from skinfield.protocols.icub.numbers import TAXELS, Firmware, SkinType
from skinfield.sources.buses import Bus
from skinfield.virtual.can_boards import CanBoards, open_buses
from skinfield.virtual.delivery import CanWire
from skinfield.virtual.faults import numbers_of
from skinfield.virtual.icub_channels import Board, boards_of, icub_converters, slots_of
from skinfield.virtual.schedule import Schedule
from skinfield.virtual.settings import VirtualSettings

UNPLUGGED = 0xFFFF


@dataclass
class Playing:
    """A board while it is played.

    Attributes
    ----------
    board : Board
    state : BoardState
    fresh : BoardState
        As after switching on.
    quiet : bool
        While it boots.
    """

    board: Board
    state: BoardState
    fresh: BoardState
    quiet: bool = False


@dataclass
class Line:
    """One bus with its triangles.

    Attributes
    ----------
    wire : CanWire
    encoder : ICubEncoder
    slots : (C,) int64 array
        See `slots_of`.
    unplugged : set of int
        Rows of the encoder.
    """

    wire: CanWire
    encoder: ICubEncoder
    slots: Ints
    unplugged: set[int] = field(default_factory=set)


class ICubBoards(CanBoards):
    """See `hardware.Hardware`.

    Parameters
    ----------
    skin : Skin
    settings : VirtualSettings
    """

    def __init__(self, skin: Skin, settings: VirtualSettings) -> None:
        self.boards = boards_of(skin)
        rng = np.random.default_rng([settings.seed, 2])
        firmware = Firmware.MTB3 if settings.mtb3 else Firmware.MTB4
        fresh = [_fresh(board, firmware, settings) for board in self.boards]
        self._playing = [
            Playing(board, state, state) for board, state in zip(self.boards, fresh, strict=True)
        ]
        converters = icub_converters(skin, settings, self.boards)
        self._lines = [
            self._line(skin, settings, firmware, bus, number, rng)
            for number, bus in enumerate(open_buses(settings, 1 + self.boards[-1].bus))
        ]
        schedule = Schedule(settings.spread, settings.wires.jitter, rng)
        super().__init__(converters, schedule, [line.wire for line in self._lines], settings.rate)
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
        wire = CanWire(bus, 2 * len(triangles), settings.wires, rng)
        encoder = ICubEncoder(triangles, firmware=firmware)
        return Line(wire, encoder, slots_of(skin, self.boards, number))

    def _count(self) -> int:
        return len(self.boards)

    def _periods(self) -> dict[int, float]:
        return {
            number: playing.state.period_ms * 1e-3
            for number, playing in enumerate(self._playing)
            if playing.state.sending and not playing.quiet
        }

    def _told(self, bus: int, identifier: int, data: bytes, warmth: float) -> bool:
        address = addressed_board(identifier)
        for number, playing in enumerate(self._playing):
            if (playing.board.bus, playing.board.address) != (bus, address) or playing.quiet:
                continue
            before = playing.state
            playing.state = before.after(data)
            self.commands += 1
            if playing.state.calibrations != before.calibrations:
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
        playing = self._playing[number]
        state, board = playing.state, playing.board
        encoder = self._lines[board.bus].encoder
        for row, triangle in enumerate(board.triangles, board.row):
            encoder.configure(
                row,
                message_class=state.message_class,
                no_load=state.no_load,
                shift=state.triangles[triangle].shift,
                kind=state.kind,
            )

    def send(self, members: Sequence[int], now_ns: int) -> None:
        """See `Hardware`."""
        for line in self._lines:
            line.encoder.sends[:] = False
        used = set()
        for number in members:
            playing = self._playing[number]
            board = playing.board
            sends = self._lines[board.bus].encoder.sends
            for row, triangle in enumerate(board.triangles, board.row):
                sends[row] = playing.state.triangles[triangle].enabled
            used.add(board.bus)
        self.readings += len(members)
        for bus, count in zip(used, self._encode(used, now_ns), strict=True):
            self._lines[bus].wire.send(count)

    def _encode(self, buses: Iterable[int], now_ns: int) -> list[int]:
        """Write the messages of the boards that send; how many, on each bus."""
        from skinfield.virtual.world_kernel import scatter

        counts = []
        for bus in buses:
            line = self._lines[bus]
            scatter(self.converters.counts, line.slots, line.encoder.raw.reshape(-1))
            for row in line.unplugged:
                line.encoder.raw[row] = UNPLUGGED
            counts.append(line.encoder.encode(line.wire.made, 0, now_ns))
        return counts

    def check(self, kind: str, what: str) -> None:
        """See `Hardware`."""
        if kind == "unplug":
            self._triangles(what)
        elif kind == "bus-off":
            numbers_of(what, len(self._lines), "bus")
        else:
            numbers_of(what, len(self.boards), "board")

    def begin(self, kind: str, what: str, now_ns: int) -> None:
        """See `Hardware`."""
        if kind == "unplug":
            for bus, row in self._triangles(what):
                self._lines[bus].unplugged.add(row)
        elif kind == "bus-off":
            for bus in numbers_of(what, len(self._lines), "bus"):
                self._lines[bus].wire.off = True
        else:
            for number in numbers_of(what, len(self.boards), "board"):
                playing = self._playing[number]
                playing.quiet, playing.state = True, playing.fresh
                self.reboots += 1
            self._reschedule(now_ns)

    def end(self, kind: str, what: str, now_ns: int, warmth: float) -> None:
        """See `Hardware`."""
        if kind == "unplug":
            for bus, row in self._triangles(what):
                self._lines[bus].unplugged.discard(row)
                line = self._lines[bus]
                line.encoder.raw[row] = line.encoder.base[row]
        elif kind == "bus-off":
            for bus in numbers_of(what, len(self._lines), "bus"):
                self._lines[bus].wire.off = False
        else:
            for number in numbers_of(what, len(self.boards), "board"):
                self._playing[number].quiet = False
                self._base(number, warmth)
                self._configure(number)
            self._reschedule(now_ns)

    def _triangles(self, what: str) -> list[tuple[int, int]]:
        """Bus and row of triangles from ``"3"`` or ``"1.3"``: of board 0, or of the named one."""
        first, dot, second = what.partition(".")
        boards = numbers_of(first, len(self.boards), "board") if dot else [0]
        found = []
        for number in boards:
            board = self.boards[number]
            for place in numbers_of(second if dot else first, len(board.triangles), "triangle"):
                found.append((board.bus, board.row + place))
        return found


def _fresh(board: Board, firmware: Firmware, settings: VirtualSettings) -> BoardState:
    """State of a board after switching on."""
    kind = SkinType.COMPENSATED if board.pads else SkinType.UNCOMPENSATED
    fresh = BoardState(firmware=firmware, kind=kind)
    return replace(fresh, sending=True, configured=True) if settings.at_once else fresh
