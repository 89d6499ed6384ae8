"""CySkin's boards: they obey the host's packets, and send SENSOR_DATA of their modules."""

from collections.abc import Sequence

import numpy as np

from skinfield.emulator.can_boards import CanBoards, CanWire, open_buses
from skinfield.emulator.electronics import Converters, Others, converters_for, manufacture
from skinfield.emulator.hardware import Fates, Schedule
from skinfield.emulator.settings import VirtualSettings
from skinfield.errors import InputError, Ints
from skinfield.skin import Skin
from skinfield.wire.cyskin import (
    Assembler,
    CySkinBoard,
    CySkinBoardState,
    CySkinEncoder,
    CySkinWire,
    on_boards,
)
from skinfield.wire.cyskin.modules import SENSORS

TEMPERATURE = 1000.0  # counts of a module's sensor 0 at 25 °C; what real ones send is not public
PER_KELVIN = 20.0  # counts/K of it
PLAIN_NOISE = 20.0  # counts of it, as recordings have


class CySkinBoards(CanBoards[CySkinBoardState]):
    """See `Hardware`. All boards are on one bus."""

    def __init__(self, skin: Skin, settings: VirtualSettings) -> None:
        placed, self.boards = on_boards(skin)
        self.wire = CySkinWire()
        rng = np.random.default_rng([settings.seed, 2])
        fresh = [
            CySkinBoardState(board=board, wire=self.wire, sending=settings.at_once)
            for board in self.boards
        ]
        self._channel = _channels(placed, self.boards)
        self._first = np.cumsum([0, *(len(board.modules) for board in self.boards)])
        self._assembler = Assembler(self.wire)
        converters = _converters(skin, settings, len(self._channel))
        (bus,) = open_buses(settings, 1)
        self._encoder = CySkinEncoder(self.boards, wire=self.wire)
        room = self._encoder.messages_per_reading
        self._can = CanWire(bus, room, Fates(settings.wires, rng))
        schedule = Schedule(settings.spread, settings.wires.jitter, rng)
        parts = [len(board.modules) for board in self.boards]
        super().__init__(fresh, parts, converters, schedule, [self._can], settings.rate)
        self._synced: list[int] = []
        self._encode(0)  # compiles before the first reading

    def _obey(self, bus: int, identifier: int, data: bytes, warmth: float) -> bool:
        whole = self._assembler.take(identifier, data)
        if whole is None:
            return False
        address, octets = whole
        try:
            command, arguments = self.wire.unpacked(octets)
        except InputError:
            return False  # damaged: boards pass it over
        meant = False
        for number, board in enumerate(self.boards):
            if number in self.quiet or address not in (board.number, self.wire.every_board):
                continue
            before = self.states[number]
            self.states[number], answers = before.after(command, arguments)
            for answer, content in answers:
                packet = self.wire.packet(answer, content)
                for message in self.wire.messages(board.number, packet):
                    self._can.bus.send(*message)
            if self.states[number].syncs != before.syncs:
                self._synced.append(number)
            self.commands += 1
            meant = True
        return meant

    def listen(self, now_ns: int, warmth: float) -> None:
        """See `Hardware`; whoever was asked for one reading sends it at once."""
        super().listen(now_ns, warmth)
        if self._synced:
            self.converters.convert(warmth)
            self.send(self._synced, now_ns)
            self._synced = []

    def send(self, members: Sequence[int], now_ns: int) -> None:
        """See `Hardware`."""
        self._encoder.sends[:] = False
        self._encoder.sends[list(members)] = True
        self.readings += len(members)
        self._can.send(self._encode(now_ns))

    def _encode(self, now_ns: int) -> int:
        """Write the messages of the boards that send; how many."""
        from skinfield.emulator.kernels import scatter

        encoder = self._encoder
        scatter(self.converters.counts, self._channel, encoder.counts)
        for board, part in self.unplugged:
            module = self._first[board] + part
            encoder.counts[module * SENSORS : (module + 1) * SENSORS] = 0
        return encoder.encode(self._can.made, 0, now_ns)


def _channels(placed: Skin, boards: Sequence[CySkinBoard]) -> Ints:
    """Channel of each taxel, and then of each module's temperature where it sends one."""
    taxels = np.concatenate([patch.channel for patch in placed])
    modules = [module for board in boards for module in board.modules]
    plain = [SENSORS * place for place, module in enumerate(modules) if 0 in module.sensors]
    return np.concatenate([taxels, np.setdiff1d(plain, taxels)]).astype(np.int64)


def _converters(skin: Skin, settings: VirtualSettings, channels: int) -> Converters:
    """Responses of all taxels, clipped at 0 as the boards do, and the temperatures."""
    level = np.full(channels, TEMPERATURE)
    level[: sum(len(patch) for patch in skin)] = 0.0
    others = Others(PER_KELVIN, PLAIN_NOISE * settings.noise)
    arrays = manufacture(skin, settings)
    return converters_for(arrays, settings, level, (0.0, 65535.0), others=others)
