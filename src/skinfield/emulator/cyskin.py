"""CySkin's boards: they obey the host's packets, and send SENSOR_DATA of their modules."""

from collections.abc import Sequence

import numpy as np

from skinfield.emulator.can_boards import CanBoards, CanWire, open_buses
from skinfield.emulator.electronics import Converters, manufacture
from skinfield.emulator.settings import VirtualSettings
from skinfield.errors import Ints
from skinfield.skin import Skin
from skinfield.wire.cyskin import (
    CySkinBoard,
    CySkinBoardState,
    CySkinEncoder,
    CySkinWire,
    on_boards,
)
from skinfield.wire.cyskin.modules import SENSORS, PacketPart

TEMPERATURE = 1000.0  # counts of a module's sensor 0 at 25 °C; what real ones send is not public
PER_KELVIN = 20.0  # counts/K of it
PLAIN_NOISE = 20.0  # counts of it, as recordings have


class CySkinBoards(CanBoards[CySkinBoardState]):
    """See `Hardware`. All boards are on one bus."""

    def __init__(self, skin: Skin, settings: VirtualSettings) -> None:
        placed, self.boards = on_boards(skin)
        self.wire = CySkinWire()
        fresh = CySkinBoardState(self.wire, settings.at_once)
        self._channel = _channels(placed, self.boards)
        self._first = np.cumsum([0, *(len(board.modules) for board in self.boards)])
        (bus,) = open_buses(settings, 1)
        self._encoder = CySkinEncoder(self.boards, wire=self.wire)
        self._can = CanWire(bus, self._encoder.messages_per_reading, settings)
        parts = [len(board.modules) for board in self.boards]
        converters = _converters(skin, settings, len(self._channel))
        states = [fresh] * len(parts)
        super().__init__(skin, settings, parts, converters, [self._can], states)
        self._synced: list[int] = []

    def _obey(self, bus: int, identifier: int, data: bytes, warmth: float) -> bool:
        address = identifier ^ self.wire.identifier(0, PacketPart.SINGLE)
        packet = self.wire.unpacked(data)
        if packet is None:
            return False  # damaged, or longer than any command: boards pass it over
        meant = False
        for number, board in enumerate(self.boards):
            if number in self.quiet or address not in (board.number, self.wire.every_board):
                continue
            before = self.states[number]
            self.states[number] = before.after(*packet)
            if self.states[number].syncs != before.syncs:
                self._synced.append(number)
            self.commands += 1
            meant = True
        return meant

    def listen(self, now_ns: int, warmth: float) -> None:
        """See `Hardware`; whoever was asked for one reading sends it at once."""
        super().listen(now_ns, warmth)
        if self._synced:
            self.converters.convert(warmth, now_ns)
            self.send(self._synced, now_ns)
            self._synced = []

    def send(self, members: Sequence[int], now_ns: int) -> None:
        """See `Hardware`."""
        encoder = self._encoder
        encoder.sends[:] = False
        encoder.sends[list(members)] = True
        encoder.counts[self._channel] = self.converters.counts
        for board, part in self.unplugged:
            module = self._first[board] + part
            encoder.counts[module * SENSORS : (module + 1) * SENSORS] = 0
        self.readings += len(members)
        self._can.send(encoder.encode(self._can.made, 0, now_ns))


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
    return Converters(
        manufacture(skin, settings), settings, level, (0.0, 65535.0),
        drift=PER_KELVIN, white=PLAIN_NOISE * settings.noise_times,
    )  # fmt: skip
