"""A board's settings, and what a host's messages make of them."""

from dataclasses import dataclass, replace

from skinfield.errors import check_count, check_type
from skinfield.protocols.icub.commands import (
    CDC_OFFSET,
    Command,
    SetBoard,
    SetOldBoard,
    SetOldSkin,
    SetTriangles,
    Transmit,
    command_from,
)
from skinfield.protocols.icub.numbers import TRIANGLES, Firmware, MessageClass, SkinType

OLD_PERIOD_MS = 40
TIMER_STEPS = 312.5  # of the old setup's timer, per millisecond


@dataclass(frozen=True)
class TriangleState:
    """How a board treats one triangle; see `SetTriangles`."""

    enabled: bool = True
    shift: int = 2
    cdc_offset: int = CDC_OFFSET


@dataclass(frozen=True, kw_only=True)
class BoardState:
    """A board as it is after what it was told; `after` gives the next one.

    A board that boots again is a new `BoardState(firmware=...)`: silent, as nobody configured it.
    Defaults are those that the robots' software sends where a file says nothing; the firmware's own
    are 50 ms and 245.

    Parameters
    ----------
    firmware : Firmware
    kind : SkinType
        Numbers that the firmware does not know switch the correction of drift off.
    period_ms : int, ms
    no_load : int
    triangles : tuple of 16 TriangleState
    configured : bool
        Whether a 4D, a 50 or a start came. Boards of the mtb3 send class 3 until then.
    sending : bool
    calibrations : int
        How often it took its base anew. Whoever plays the converters sets base to raw when this
        has changed.
    ignored : int
        Messages that meant nothing to it.
    """

    firmware: Firmware = Firmware.MTB4
    kind: SkinType = SkinType.COMPENSATED
    period_ms: int = 40
    no_load: int = 240
    triangles: tuple[TriangleState, ...] = (TriangleState(),) * TRIANGLES
    configured: bool = False
    sending: bool = False
    calibrations: int = 0
    ignored: int = 0

    def __post_init__(self) -> None:
        check_type("firmware", self.firmware, Firmware, "MTB3 or MTB4")
        check_count("period_ms", self.period_ms, 1, 255, "milliseconds between readings")
        check_count("no_load", self.no_load, 0, 255, "the byte of an unloaded taxel")
        check_count("triangles", len(self.triangles), TRIANGLES, TRIANGLES, "one state for each")

    @property
    def message_class(self) -> MessageClass:
        """Class of its readings."""
        old = self.firmware == Firmware.MTB3 and not self.configured
        return MessageClass.ANALOG if old else MessageClass.SKIN

    def after(self, data: bytes) -> "BoardState":
        """State after a message of the host with such data; unknown ones are counted and ignored.

        ======= ========================================================================
        message what follows
        ======= ========================================================================
        4D      kind, period, rest; mtb4 also switches all triangles off until a 50 comes
        50      settings of triangles; new calibration; mtb4 stops to send
        07      sends, or stops
        4C      new calibration; sends; mtb4 also takes its defaults
        4E      shift, rest, correction, mask of triangles
        ======= ========================================================================
        """
        command = command_from(data)
        if command is None:
            return replace(self, ignored=self.ignored + 1)
        return self._obeyed(command)

    def _obeyed(self, command: Command) -> "BoardState":
        match command:
            case SetBoard():
                return self._as_board(command)
            case SetTriangles():
                return self._as_triangles(command)
            case Transmit():
                configured = self.configured or command.on
                return replace(self, sending=command.on, configured=configured)
            case SetOldBoard():
                return self._as_old_board(command)
            case SetOldSkin():
                return self._as_old_skin(command)

    def _as_board(self, command: SetBoard) -> "BoardState":
        triangles = self.triangles
        if self.firmware == Firmware.MTB4:
            triangles = tuple(replace(each, enabled=False) for each in triangles)
        return replace(
            self,
            kind=_kind(command.kind),
            period_ms=command.period_ms,
            no_load=command.no_load,
            triangles=triangles,
            configured=True,
        )

    def _as_triangles(self, command: SetTriangles) -> "BoardState":
        new = TriangleState(command.enabled, command.shift, command.cdc_offset)
        run = range(command.first, command.last + 1)
        return replace(
            self,
            triangles=tuple(new if t in run else old for t, old in enumerate(self.triangles)),
            configured=True,
            sending=self.sending and self.firmware == Firmware.MTB3,
            calibrations=self.calibrations + 1,
        )

    def _as_old_board(self, command: SetOldBoard) -> "BoardState":
        period = OLD_PERIOD_MS
        if command.timer & 15 == 3 and self.firmware == Firmware.MTB3:
            period = min(max(round(command.time / TIMER_STEPS), 1), 255)
        start = BoardState() if self.firmware == Firmware.MTB4 else self
        return replace(
            self,
            kind=start.kind,
            no_load=start.no_load,
            period_ms=period,
            triangles=tuple(
                replace(each, cdc_offset=command.cdc_offset) for each in start.triangles
            ),
            sending=True,
            calibrations=self.calibrations + 1,
        )

    def _as_old_skin(self, command: SetOldSkin) -> "BoardState":
        corrected = command.param >> 3 & 1
        return replace(
            self,
            kind=_kind(command.param & 3) if corrected else SkinType.UNCOMPENSATED,
            no_load=command.no_load,
            triangles=tuple(
                TriangleState(bool(command.mask >> t & 1), command.shift, each.cdc_offset)
                for t, each in enumerate(self.triangles)
            ),
        )


def _kind(number: int) -> SkinType:
    known = {int(each): each for each in SkinType}
    return known.get(number, SkinType.UNCOMPENSATED)
