"""CySkin's boards on their CAN buses, and the shared memory of its acquisition tool."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from skinfield.acquisition import Blocks
from skinfield.errors import InputError, check_count
from skinfield.protocols.cyskin import (
    CySkinBoard,
    CySkinDecoder,
    CySkinWire,
    SharedMemoryReader,
    port_of,
)
from skinfield.protocols.cyskin.modules import checked_boards
from skinfield.protocols.cyskin.snapshot import HEADER_KEY
from skinfield.sources.buses import BusSettings
from skinfield.sources.live.board_care import CySkinCare
from skinfield.sources.live.cared_stream import CaredStream
from skinfield.sources.live.link import LinkedStream


@dataclass(frozen=True)
class CySkinCan:
    """Boards of CySkin, in their application phase, which are started, and stopped at the end.

    All modules are one port of 12 channels each: `protocols.cyskin.skin_on_boards` gives the skin
    on these channels.

    Parameters
    ----------
    boards : sequence of CySkinBoard
    buses : sequence of BusSettings
        One for each bus that the boards name.
    name : str
        Of the port.
    wire : CySkinWire
        What is not public of the protocol.
    period_ms : int, ms
        Between two readings.
    configure : bool
        False only listens: another host starts the boards.
    """

    boards: Sequence[CySkinBoard]
    buses: Sequence[BusSettings] = (BusSettings(),)
    name: str = "skin"
    wire: CySkinWire = field(default_factory=CySkinWire)
    period_ms: int = 50
    configure: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "boards", checked_boards(self.boards))
        object.__setattr__(self, "buses", tuple(self.buses))
        check_count("period_ms", self.period_ms, 1, 0xFFFF, "ms between two readings")
        needed = 1 + max(board.bus for board in self.boards)
        if len(self.buses) != needed:
            raise InputError(
                f"buses are {[bus.label for bus in self.buses]}, expected {needed}: the boards "
                "are on so many"
            )

    def open(self) -> CaredStream:
        """Open the buses and start the boards.

        Raises
        ------
        InputError
            If a bus cannot be used; see `open_bus`.
        """
        places = range(len(self.buses))
        mine = [[board for board in self.boards if board.bus == place] for place in places]
        return CaredStream(
            (port_of(self.name, self.boards),),
            self.buses,
            [CySkinDecoder(self.boards, place, wire=self.wire) for place in places],
            [CySkinCare(each, self.wire, self.period_ms) for each in mine]
            if self.configure
            else (),
        )


@dataclass(frozen=True)
class CySkinSharedMemory:
    """What CySkin's own acquisition tool writes for other programs on the same machine.

    Parameters
    ----------
    boards : sequence of CySkinBoard
        Whose modules give each uid its channel.
    key : int
        Of the header; 450 is the tool's.
    name : str
        Of the port.
    """

    boards: Sequence[CySkinBoard]
    key: int = HEADER_KEY
    name: str = "skin"

    def __post_init__(self) -> None:
        object.__setattr__(self, "boards", checked_boards(self.boards))

    def open(self) -> "SharedMemoryStream":
        """Look for the memory; the stream is up once the tool has made it."""
        return SharedMemoryStream(self)


class MemoryLink:
    """The memory, which is there while the tool runs."""

    def __init__(self, source: CySkinSharedMemory) -> None:
        self.reader = SharedMemoryReader(source.boards, source.key)
        self.reader.open()

    @property
    def up(self) -> bool:
        """Whether the memory is there."""
        return self.reader.up

    @property
    def fault(self) -> str:
        """Why not."""
        return "" if self.up else f"no shared memory with key {self.reader.key}: no tool runs"

    def reopen(self) -> bool:
        """Look for it."""
        return self.reader.open()

    def filenos(self) -> Sequence[int]:
        """None: memory tells nobody."""
        return ()

    def close(self) -> None:
        """Let go of it."""
        self.reader.close()


class SharedMemoryStream(LinkedStream):
    """See `skinfield.acquisition.Stream`."""

    def __init__(self, source: CySkinSharedMemory) -> None:
        self._memory = MemoryLink(source)
        super().__init__((port_of(source.name, source.boards),), (self._memory,))
        order, nothing = self._memory.reader.order, np.zeros(0, np.uint32)
        order.put(nothing, Blocks(64), 0, self.counters, 0)  # compiles

    def _take(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        if not self._memory.up:
            return 0
        return self._memory.reader.read(blocks, channel, self.counters, now_ns)
