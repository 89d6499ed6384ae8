"""Configuration of skin boards: from a robot's files, or for patches of a skin."""

from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from skinfield.errors import FileError, InputError, check_count, check_type
from skinfield.skin import Patch
from skinfield.wire.icub.codec import checked_boards
from skinfield.wire.icub.commands import (
    BOARD_CHANNELS,
    TAXELS,
    TRIANGLES,
    Message,
    SetBoard,
    SetTriangles,
    SkinType,
    Transmit,
    TriangleState,
    host_message,
)
from skinfield.wire.icub.robot_files import (
    WHERE,
    PortRun,
    named,
    patches_of,
    ports_of,
    read_tree,
    settings_of,
)

USUAL = SetBoard(period_ms=50)  # of robots
THERMAL = (6, 10)  # channels of a triangle that feel warmth alone
FIRST_ADDRESS, ADDRESSES = 1, 14  # that the robots' Ethernet boards take for skin
HEADS = {  # tags and names of elements, any of which a file of that kind has
    "skin": (("group", "patches"), ("param", "skinCanIds")),
    "skinSpec": (("group", "defaultCfgBoard"), ("group", "defaultCfgTriangle")),
    "wrapper": (("paramlist", "ports"),),
}


@dataclass(frozen=True)
class ICubBoardSettings:
    """One board, as it shall be.

    Parameters
    ----------
    bus : int
        Index into the configuration's buses.
    address : int
    board : SetBoard
    triangles : tuple of 16 TriangleState
    """

    bus: int
    address: int
    board: SetBoard = USUAL
    triangles: tuple[TriangleState, ...] = (TriangleState(),) * TRIANGLES

    def __post_init__(self) -> None:
        check_type("board", self.board, SetBoard, "its kind, period and rest")
        check_count("triangles", len(self.triangles), TRIANGLES, TRIANGLES, "one state for each")

    @property
    def messages(self) -> tuple[Message, ...]:
        """What sets the board up: one 4D, and a 50 for each run of equal triangles."""
        commands = [self.board.data]
        for state, run in groupby(range(TRIANGLES), key=lambda t: self.triangles[t]):
            numbers = list(run)
            commands.append(SetTriangles(first=numbers[0], last=numbers[-1], **vars(state)).data)
        identifier = host_message(self.address, self.board)[0]
        return tuple((identifier, data) for data in commands)


@dataclass(frozen=True)
class ICubConfiguration:
    """Boards of one skin device, in the order of its channels.

    Parameters
    ----------
    boards : tuple of ICubBoardSettings
        Each (bus, address) once.
    buses : tuple of int
        The robot's number of each bus: of the patch, or of the CAN device.
    name : str
        Of the device.
    ports : tuple of PortRun
        Which channels go to which port; empty if no wrapper was given.
    """

    boards: tuple[ICubBoardSettings, ...]
    buses: tuple[int, ...] = (0,)
    name: str = "skin"
    ports: tuple[PortRun, ...] = ()

    def __post_init__(self) -> None:
        pairs = checked_boards(self.addresses)
        for bus, _ in pairs:
            check_count("bus", bus, 0, len(self.buses) - 1, "index into the buses")
        for run in self.ports:
            if run.first + run.count > self.channels:
                raise InputError(
                    f"port {run.port!r} ends at channel {run.first + run.count - 1}, expected at "
                    f"most {self.channels - 1}: {len(pairs)} boards have {self.channels} channels"
                )

    @property
    def addresses(self) -> tuple[tuple[int, int], ...]:
        """(bus, address) of each board, for `ICubDecoder`."""
        return tuple((board.bus, board.address) for board in self.boards)

    @property
    def channels(self) -> int:
        """Of the device: 192 per board."""
        return BOARD_CHANNELS * len(self.boards)

    @property
    def period(self) -> float:
        """The shortest of the boards' periods, s."""
        return min(board.board.period_ms for board in self.boards) * 1e-3

    def messages(self, bus: int = 0) -> tuple[Message, ...]:
        """What to send on a bus (index) at the beginning: settings of each board, then start."""
        boards = self._on(bus)
        setup = tuple(message for board in boards for message in board.messages)
        return setup + tuple(host_message(board.address, Transmit(True)) for board in boards)

    def stop_messages(self, bus: int = 0) -> tuple[Message, ...]:
        """What to send on a bus at the end."""
        return tuple(host_message(board.address, Transmit(False)) for board in self._on(bus))

    def _on(self, bus: int) -> list[ICubBoardSettings]:
        check_count("bus", bus, 0, len(self.buses) - 1, "index into the buses")
        return [board for board in self.boards if board.bus == bus]


def load_configuration(*paths: str | Path, last_patch_first: bool = True) -> ICubConfiguration:
    """Configuration from a robot's XML files, in any order.

    Parameters
    ----------
    paths : str or Path
        One ``*-skin.xml`` with the addresses; usually its ``*-skinSpec.xml`` too, without which
        boards keep the usual settings; and a ``*-skin_wrapper.xml`` for the ports.
    last_patch_first : bool
        Whether the channels of an Ethernet board begin with the boards of its second CAN bus, as
        the wrappers of robots-configuration take it. Newer robot software begins with the first.

    Raises
    ------
    FileError
        If a file cannot be read or used, or they do not go together.
    """
    files: dict[str, Element] = {}
    for root in (read_tree(Path(path)) for path in paths):
        parts = [
            part
            for part, heads in HEADS.items()
            if any(named(root, *head) is not None for head in heads)
        ]
        if not parts:
            raise FileError(
                f"{root.get(WHERE)}: {root.tag} {root.get('name', '')!r} says nothing of a "
                "skin, expected defaultCfgBoard, patches, skinCanIds or ports"
            )
        for part in parts:
            if part in files:
                raise FileError(
                    f"{root.get(WHERE)}: is a second {part} beside {files[part].get(WHERE)}, "
                    "expected one skin, one skinSpec, one wrapper"
                )
            files[part] = root
    if "skin" not in files:
        raise FileError(
            f"{', '.join(str(path) for path in paths) or 'no file'}: no addresses of boards, "
            "expected a *-skin.xml with skinCanAddrsPatch1 or skinCanIds"
        )
    patches = patches_of(files["skin"])
    settings = settings_of(files["skinSpec"], patches) if "skinSpec" in files else {}
    usual = USUAL, [TriangleState()] * TRIANGLES
    boards = []
    for bus, (patch, addresses) in enumerate(patches.items()):
        for address in addresses:
            board, triangles = settings.get((patch, address), usual)
            boards.append(ICubBoardSettings(bus, address, board, tuple(triangles)))
    if last_patch_first:
        boards.sort(key=lambda board: -board.bus)
    name = next(files["skin"].iter("device"), files["skin"]).get("name", "")
    wrapper = files.get("wrapper")
    ports = () if wrapper is None else ports_of(wrapper)
    try:
        return ICubConfiguration(tuple(boards), tuple(patches), name, ports)
    except InputError as error:
        where = files["skin"] if wrapper is None else wrapper
        raise FileError(f"{where.get(WHERE)}: {error}") from error


def kind_for(patch: Patch) -> SkinType:
    """Kind of skin that boards of a patch are told.

    The correction of drift goes by pad 6 of each triangle, so it is on only where no taxel of the
    patch is at a thermal pad: with a taxel there, a press would count as warmth.
    """
    channel = np.asarray(patch.channel) % TAXELS
    warm = patch.n_channels % TAXELS == 0 and not np.isin(channel, THERMAL).any()
    return SkinType.COMPENSATED if warm else SkinType.UNCOMPENSATED


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
    boards: list[ICubBoardSettings] = []
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
            boards.append(ICubBoardSettings(bus, FIRST_ADDRESS + address, settings, triangles))
    buses = tuple(range(1 + boards[-1].bus))
    return ICubConfiguration(tuple(boards), buses, "+".join(names), tuple(ports))
