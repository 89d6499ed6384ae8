"""The pace at which a recording is played."""

import math
import time

SPEEDS = 0.1, 10.0
LATE = 0.25  # s behind, from which on time is not made up for


class Clock:
    """When a cycle is due.

    Where answers take longer than the asked pace allows, time goes on as fast as they come.

    Parameters
    ----------
    playing : bool

    Attributes
    ----------
    speed : float
        Times its own pace.
    behind : bool
        Whether it goes slower than was asked.
    """

    def __init__(self, playing: bool) -> None:
        self.playing, self.speed, self.behind = playing, 1.0, False
        self._since: tuple[float, int] | None = None  # a moment, and the time that was shown then

    def play(self) -> None:
        """Let time go on."""
        self.playing, self._since = True, None

    def pause(self) -> None:
        """Stop time."""
        self.playing = self.behind = False

    def set_speed(self, speed: float) -> None:
        """Go on so many times as fast as it was."""
        self.speed, self.behind, self._since = speed, False, None

    def begin(self, time_ns: int) -> None:
        """It is this time now."""
        self.behind, self._since = False, (time.monotonic(), time_ns)

    def left(self, time_ns: int) -> float:
        """Seconds until it is this time, at most 0 if it is; infinite as long as it stands."""
        if not self.playing:
            return math.inf
        now = time.monotonic()
        if self._since is None:
            self._since = now, time_ns
        moment, shown = self._since
        left = moment + (time_ns - shown) * 1e-9 / self.speed - now
        if left > 0.0:
            self.behind = False
        elif left < -LATE:
            self.behind, self._since = True, (now, time_ns)
        return left
