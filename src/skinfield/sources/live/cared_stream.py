"""Buses whose boards are told what to do."""

from collections.abc import Sequence
from time import time_ns

from skinfield.acquisition import Blocks, CanMessages, Port
from skinfield.sources.buses import Bus, BusSettings, open_bus
from skinfield.sources.live.board_care import AT_ONCE, BoardCare
from skinfield.sources.live.can_stream import CanDecoder, CanStream


class CaredStream(CanStream):
    """See `CanStream`, and `board_care` for when boards are told something.

    Parameters
    ----------
    ports : sequence of Port
    buses : sequence of BusSettings
        They are opened.
    decoders : sequence of CanDecoder
        One for each bus.
    care : sequence of BoardCare
        One for each bus; empty if another host tells the boards what to do.

    Attributes
    ----------
    told_again : int
        Times that a board was told its settings after the first.

    Raises
    ------
    InputError
        If a bus cannot be used; see `open_bus`.
    """

    def __init__(
        self,
        ports: Sequence[Port],
        buses: Sequence[BusSettings],
        decoders: Sequence[CanDecoder],
        care: Sequence[BoardCare],
    ) -> None:
        self._care = tuple(care)
        opened: list[Bus] = []
        try:
            for settings in buses:
                opened.append(open_bus(settings))
            super().__init__(ports, opened, decoders)
        except BaseException:
            for bus in opened:
                bus.close()
            raise
        self._told = self._leaves = False
        for one in self._care:
            one.begin(time_ns())

    @property
    def told_again(self) -> int:
        """See above."""
        return sum(one.told_again for one in self._care)

    def resume(self) -> None:
        """See `Lasting`."""
        for one in self._care:
            one.resume(time_ns())

    def leave(self) -> None:
        """See `Lasting`."""
        self._leaves = True

    def _take(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        taken = super()._take(blocks, channel, now_ns)
        for one, bus in zip(self._care, self.buses, strict=False):
            if bus.up:
                one.attend(bus, now_ns, AT_ONCE if self._told else max(one.waiting, AT_ONCE))
        self._told = True
        return taken

    def _heard(self, place: int, rows: CanMessages, count: int) -> None:
        if self._care:
            self._care[place].heard(rows, count)

    def _came_back(self, place: int, now_ns: int) -> None:
        if self._care:
            care = self._care[place]
            (care.begin if care.waiting else care.resume)(now_ns)

    def _stop(self) -> None:
        if not self._leaves:
            for one, bus in zip(self._care, self.buses, strict=False):
                one.stop(bus)
