"""Skin boards of an iCub: they obey the host's messages, and send two messages per triangle."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from skinfield.acquisition import CanMessages
from skinfield.errors import InputError, Ints
from skinfield.layout import Skin
from skinfield.protocols.icub import ICubEncoder
from skinfield.protocols.icub.board import BoardState
from skinfield.protocols.icub.commands import addressed_board
from skinfield.protocols.icub.numbers import TAXELS, Firmware, SkinType
from skinfield.sources.buses import open_bus
from skinfield.virtual.buses import address_of, bus_settings
from skinfield.virtual.delivery import FAULTS, CanWire, chances_of
from skinfield.virtual.electronics import Converters
from skinfield.virtual.faults import numbers_of
from skinfield.virtual.icub_channels import Board, boards_of, icub_converters, slots_of
from skinfield.virtual.schedule import Schedule
from skinfield.virtual.settings import VirtualSettings

UNPLUGGED = 0xFFFF
HEARD = 256  # messages of hosts in one poll


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
    """One bus with its triangles."""

    wire: CanWire
    encoder: ICubEncoder
    slots: Ints
    unplugged: set[int] = field(default_factory=set)
    heard: CanMessages = field(default_factory=lambda: CanMessages(HEARD))


class ICubBoards:
    """See `hardware.Hardware`.

    Parameters
    ----------
    skin : Skin
    settings : VirtualSettings
    """

    def __init__(self, skin: Skin, settings: VirtualSettings) -> None:
        self.boards = boards_of(skin)
        self.converters: Converters = icub_converters(skin, settings, self.boards)
        rng = np.random.default_rng([settings.seed, 2])
        self.schedule = Schedule(settings.spread, settings.wires.jitter, rng)
        self._rate, self._at_once = settings.rate, settings.at_once
        firmware = Firmware.MTB3 if settings.mtb3 else Firmware.MTB4
        self._playing = [Playing(b, *_states(b, firmware, settings)) for b in self.boards]
        self._lines = self._open(skin, settings, firmware, rng)
        self.readings = self.reboots = self.commands = self.silent = 0
        for board in range(len(self.boards)):
            self._base(board, 0.0)
            self._configure(board)

    def _open(
        self,
        skin: Skin,
        settings: VirtualSettings,
        firmware: Firmware,
        rng: np.random.Generator,
    ) -> list[Line]:
        buses = max(board.bus for board in self.boards) + 1
        lines: list[Line] = []
        try:
            for number, where in enumerate(bus_settings(settings, buses)):
                triangles = [
                    (board.address, triangle)
                    for board in self.boards
                    if board.bus == number
                    for triangle in board.triangles
                ]
                bus = open_bus(where)
                if not bus.up:
                    raise InputError(
                        f"bus cannot be opened: {bus.fault}, expected one that is free: choose "
                        "another with --channel"
                    )
                wire = CanWire(bus, 2 * len(triangles), settings.wires, rng)
                encoder = ICubEncoder(triangles, firmware=firmware)
                lines.append(Line(wire, encoder, slots_of(skin, self.boards, number)))
        except BaseException:
            for line in lines:
                line.wire.bus.close()
            raise
        return lines

    @property
    def addresses(self) -> list[str]:
        """See `Hardware`."""
        return [address_of(line.wire.bus) for line in self._lines]

    @property
    def chances(self) -> Mapping[str, float]:
        """See `Hardware`."""
        return chances_of(self._lines[0].wire.fates)

    def filenos(self) -> list[int]:
        """See `Hardware`."""
        return [n for line in self._lines for n in line.wire.bus.filenos()]

    def listen(self, now_ns: int, warmth: float) -> None:
        """See `Hardware`."""
        changed = False
        for number, line in enumerate(self._lines):
            heard = line.heard
            for row in range(line.wire.bus.receive(heard)):
                address = addressed_board(int(heard.ids[row]))
                if address is None or line.wire.off:
                    continue
                data = heard.data[row, : int(heard.lengths[row])].tobytes()
                changed |= self._told(number, address, data, warmth)
        if changed:
            self._reschedule(now_ns)

    def _told(self, bus: int, address: int, data: bytes, warmth: float) -> bool:
        """Obey one message; whether a board of ours was meant."""
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

    def _reschedule(self, now_ns: int) -> None:
        periods = {}
        for number, playing in enumerate(self._playing):
            if playing.state.sending and not playing.quiet:
                period = 1e9 / self._rate if self._rate else playing.state.period_ms * 1e6
                periods[number] = round(period)
        self.schedule.set(periods, len(self.boards), now_ns)

    def start(self, now_ns: int) -> None:
        """Send from now on what sends without being told."""
        self._reschedule(now_ns)

    def send(self, members: Sequence[int], now_ns: int) -> None:
        """See `Hardware`."""
        from skinfield.virtual.world_kernel import scatter

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
        for bus in used:
            line = self._lines[bus]
            scatter(self.converters.counts, line.slots, line.encoder.raw.reshape(-1))
            for row in line.unplugged:
                line.encoder.raw[row] = UNPLUGGED
            line.wire.send(line.encoder.encode(line.wire.made, 0, now_ns))

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

    def set_chances(self, lose: float, duplicate: float, swap: float) -> None:
        """See `Hardware`."""
        for line in self._lines:
            line.wire.fates.chances[:] = lose, duplicate, swap

    def counts(self) -> dict[str, Any]:
        """See `Hardware`."""
        wires = [line.wire for line in self._lines]
        found = {
            name: int(sum(wire.fates.counts[i] for wire in wires)) for i, name in enumerate(FAULTS)
        }
        return {
            "messages": sum(wire.sent for wire in wires),
            **found,
            "refused": sum(wire.refused for wire in wires),
            "withheld": sum(wire.withheld for wire in wires),
            "commands": self.commands,
            "reboots": self.reboots,
        }

    def close(self) -> None:
        """See `Hardware`."""
        for line in self._lines:
            line.wire.close()


def _states(
    board: Board, firmware: Firmware, settings: VirtualSettings
) -> tuple[BoardState, BoardState]:
    """States at the beginning and after a reboot."""
    kind = SkinType.COMPENSATED if board.pads else SkinType.UNCOMPENSATED
    fresh = BoardState(firmware=firmware, kind=kind)
    if not settings.at_once:
        return fresh, fresh
    return replace(fresh, sending=True, configured=True), fresh
