"""When what a running skin says is sent."""

import time
from collections.abc import Callable, Mapping

import numpy as np

from skinfield.bridges.ros2.messages import Speaker
from skinfield.live.client import Live, NotRunning
from skinfield.live.fit_reader import FitReader
from skinfield.live.slots import Slot
from skinfield.live.snapshot import Snapshot
from skinfield.live.status import Observer
from skinfield.ring import State
from skinfield.sinks.ros.messages import Outgoing

LOOKS = 0.05  # s between looks whether to stop


class Pace:
    """When each of several things is next due.

    Parameters
    ----------
    rates : mapping of str to float, 1/s
        0: never.
    """

    def __init__(self, rates: Mapping[str, float]) -> None:
        self._every = {what: 1.0 / rate for what, rate in rates.items() if rate > 0}
        self._next = dict.fromkeys(self._every, 0.0)

    def due(self, now: float) -> list[str]:
        """What may be done now."""
        return [what for what, when in self._next.items() if when <= now]

    def done(self, what: str, now: float) -> None:
        """It was done: the next is due on the beat, but what was missed is not made up for."""
        every, when = self._every[what], self._next[what]
        self._next[what] = (when if now < when + every else now) + every

    def wait(self, now: float) -> float:
        """Seconds until something is due, at most `LOOKS`."""
        return min(max(min(self._next.values(), default=now + LOOKS) - now, 0.0), LOOKS)


class Talker:
    """Sends the messages of a running skin, each at its pace and each reading once.

    Parameters
    ----------
    live : Live
    speaker : Speaker
    rates : mapping of str to float, 1/s
        Of `SAID`; 0: never.
    send : function (Outgoing)
    """

    def __init__(
        self,
        live: Live,
        speaker: Speaker,
        rates: Mapping[str, float],
        send: Callable[[Outgoing], None],
    ) -> None:
        self._live, self._speaker, self._send = live, speaker, send
        self.pace = Pace(rates)
        self._health = Observer(live.reader, window=1.0)
        self._fit = FitReader(live.name)
        self._room = live.reader.slot()  # looked at before a cycle is worth a copy of its own
        self._looked = Slot.of(self._room.arrays)
        self._stamps = np.zeros(len(live.skin), np.int64)
        self._seen = 0
        self._newest: Snapshot | None = None

    def close(self) -> None:
        """Let go of the fit; the skin runs on."""
        self._fit.close()

    def step(self, timeout: float = 0.0) -> None:
        """Send what is due, as far as there is a new reading.

        Parameters
        ----------
        timeout : float, s
            How long to wait for one.

        Raises
        ------
        NotRunning
            If another skin took the name.
        """
        now = time.monotonic()
        due = self.pace.due(now)
        if "diagnostics" in due:
            if self._live.reader.replaced():
                raise NotRunning(f"{self._live.name!r} was started anew: connect again")
            self._send(self._speaker.of_status(self._health.look(), time.time_ns()))
            self.pace.done("diagnostics", now)
        wanted = [what for what in due if what != "diagnostics"]
        if self._live.state != State.RUNNING:
            for what in wanted:
                self.pace.done(what, now)
        elif wanted:
            self._look(0.0)
            left = self._say(wanted)
            if left and timeout > 0 and self._look(timeout):
                self._say(left)

    def _look(self, timeout: float) -> bool:
        """Wait for a reading that is newer than the last one."""
        end = time.monotonic() + timeout
        reader = self._live.reader
        while reader.wait(self._seen, max(end - time.monotonic(), 0.0)) > self._seen:
            copied = reader.latest(self._room)
            if copied is None:
                return False
            self._seen, stamps = copied.number, self._looked.patches["stamp_ns"]
            if not np.array_equal(stamps, self._stamps):
                self._stamps[:] = stamps
                self._newest = self._live.latest()
                return True
        return False

    def _say(self, wanted: list[str]) -> list[str]:
        """Send what is new of `wanted`; the rest."""
        if self._newest is None:
            return wanted
        left = []
        for what in wanted:
            if not self._speaker.news(self._newest, what).any():
                left.append(what)
                continue
            for out in self._speaker.of_snapshot(self._newest, (what,), self._fit):
                self._send(out)
            self.pace.done(what, time.monotonic())
        return left
