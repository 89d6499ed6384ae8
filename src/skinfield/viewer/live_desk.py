"""Orders of the page to a skin that runs here."""

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from skinfield.errors import InputError, SkinfieldError, check_choice
from skinfield.live.fit_reader import FitReader
from skinfield.ring import State
from skinfield.viewer.desk import Desk, Press
from skinfield.viewer.feed import Feed
from skinfield.viewer.live_feed import LiveFeed
from skinfield.viewer.presser import NO_VIRTUAL, Presser, Virtual
from skinfield.viewer.recordings import Recordings
from skinfield.viewer.seen_best import seen_best
from skinfield.viewer.tuner import TUNED, tune, tuning_told
from skinfield.viewer.updates import Seen, seen_plainly

FIT = "contact fit"
PATIENCE = 12.0  # times the asked time, after which a baseline is not waited for any more
LIFTS, RESTS = 2.0, 0.1  # s, for a scene to let off, and for its last readings
FIT_STARTS = 60.0  # s, after which a fit that is not there is not waited for


class Solvers(NamedTuple):
    """How the engine may answer.

    Attributes
    ----------
    names : tuple of str
    now : function
        Name of the one in force.
    choose : function of a name
        Takes another; returns when the engine is being made anew.
    """

    names: tuple[str, ...]
    now: Callable[[], str]
    choose: Callable[[str], None]


class LiveDesk(Desk):
    """See `Desk`.

    Parameters
    ----------
    feed : function that returns a LiveFeed
        Of the engine; another one after it was made anew.
    virtual : Virtual, optional
        That is pressed from the page.
    tool : (force N, radius m)
        That the page begins with.
    recordings : Recordings, optional
    solvers : Solvers, optional
    fit : FitReader, optional
        Of the fit beside the engine.
    tare_seconds : float, s
        That a baseline takes.
    """

    mode = "live"

    def __init__(
        self,
        feed: Callable[[], LiveFeed],
        *,
        virtual: Virtual | None = None,
        tool: tuple[float, float] = (1.0, 10e-3),
        recordings: Recordings | None = None,
        solvers: Solvers | None = None,
        fit: FitReader | None = None,
        tare_seconds: float = 1.0,
    ) -> None:
        super().__init__()
        self._feed, self._recordings, self._solvers = feed, recordings, solvers
        self._presser = (
            None
            if virtual is None
            else Presser(virtual, self._waits_for, lambda text: self.say("warn", text), tool)
        )
        self._fit, self._fit_lock, self._fitting = fit, threading.Lock(), fit is not None
        self._tare_seconds = tare_seconds
        self._fit_seen, self._fit_lost = time.monotonic(), False
        self._taring: tuple[int, float] | None = None  # baselines before, and until when to wait
        self._preparing = ""  # name of a solver
        self._first = "" if solvers is None else solvers.now()  # that the fit goes with

    # what is seen

    def seen(self, feeds: Sequence[Feed]) -> list[Seen]:
        """See `Desk`."""
        return [self._seen(feed) for feed in feeds]

    def _seen(self, feed: Feed) -> Seen:
        snapshot, fit = feed.latest(), self._fit
        if snapshot is None or fit is None or not self._fitting:
            return seen_plainly(snapshot)
        with self._fit_lock:
            return seen_best(snapshot, fit.latest())

    def truth(self) -> Sequence[Mapping[str, Any]]:
        """See `Desk`."""
        if self._presser is None:
            return ()
        self._presser.do_waiting()
        return self._presser.truth()

    def hello(self) -> dict[str, Any]:
        """See `Desk`."""
        recordings = self._recordings
        return {
            "press": None if self._presser is None else self._presser.told(),
            "record": recordings is not None,
            "recordings": [] if recordings is None else recordings.names,
        }

    def controls(self) -> dict[str, Any]:
        """See `Desk`."""
        told: dict[str, Any] = {"off": {}, "busy": self._busy() or None}
        try:
            told |= tuning_told(self._feed().live)
        except SkinfieldError as error:
            told["off"] |= dict.fromkeys(TUNED, str(error))
        if self._presser is None:
            told["off"]["press"] = NO_VIRTUAL
        else:
            told["scene"] = self._presser.playing
        if self._solvers is not None:
            names = ([FIT] if self._fit is not None else []) + list(self._solvers.names)
            preparing = self._preparing or None
            told["solver"] = {"value": self._solver(), "options": names, "preparing": preparing}
        told["recording"] = None if self._recordings is None else self._recordings.told()
        return told

    def _busy(self) -> str:
        """What is being done, in words; nothing if nothing is."""
        if self._preparing:
            return f"preparing the solver {self._preparing}"
        if waits := self._waits_for():
            return waits
        if self._presser is not None and self._presser.preparing:
            return "the tool is being prepared"
        if self._fit is None or not self._fitting:
            return ""
        with self._fit_lock:
            phase = self._fit.status().get("phase")
        if phase is not None:
            self._fit_seen, self._fit_lost = time.monotonic(), False
        elif time.monotonic() - self._fit_seen > FIT_STARTS and not self._fit_lost:
            self._fit_lost = True
            self.say("warn", "the contact fit has ended: the engine's own contacts are shown")
        waits_for_fit = phase == "preparing" or (phase is None and not self._fit_lost)
        return "forces rough until the fit is ready" if waits_for_fit else ""

    def _waits_for(self) -> str:
        """What has to end before anything may press, in words."""
        try:
            state = self._feed().live.state
        except SkinfieldError as error:
            return str(error)
        if state == State.STARTING:
            return "the engine starts"
        if state == State.CALIBRATING:
            return "the engine takes its baseline: the skin must not be touched"
        if state != State.RUNNING:
            return f"the engine is {state.name.lower()}"
        return "a baseline is being taken: the skin must not be touched" if self._tares() else ""

    def _tares(self) -> bool:
        """Whether a baseline that was asked for is still being taken."""
        if self._taring is None:
            return False
        before, until = self._taring
        taken = int(self._feed().live.reader.status_view["tares"][0])
        if taken != before or time.monotonic() > until:
            self._taring = None
        return self._taring is not None

    def notices(self) -> list[tuple[str, str]]:
        """See `Desk`."""
        if self._recordings is not None:
            for text in self._recordings.notices():
                self.say("error", text)
        return super().notices()

    # what is ordered

    def set(self, what: str, value: Any) -> dict[str, Any]:
        """See `Desk`."""
        if what == "solver":
            return self._choose(value)
        tune(self._feed().live, what, value)
        return {}

    def _solver(self) -> str:
        assert self._solvers is not None  # whoever asks has looked
        return FIT if self._fitting else self._solvers.now()

    def _choose(self, name: Any) -> dict[str, Any]:
        """Take another solver, or the fit beside the engine."""
        solvers = self._solvers
        if solvers is None:
            return super().set("solver", name)
        options = (*((FIT,) if self._fit is not None else ()), *solvers.names)
        check_choice("solver", name, options, "how readings become pressure")
        if self._preparing:
            raise InputError(f"{self._preparing} is being prepared, expected one at a time: wait")
        engine = self._first if name == FIT else name
        if engine == solvers.now():
            self._fitting = name == FIT
            return {}
        self._preparing = str(name)
        words = str(name), str(engine)
        threading.Thread(target=self._change, args=words, name="solver", daemon=True).start()
        return {"preparing": name}

    def _change(self, name: str, engine: str) -> None:
        """Take another solver, which takes seconds to prepare; the skin is answered meanwhile."""
        assert self._solvers is not None  # whoever calls has looked
        try:
            self._solvers.choose(engine)
            self._fitting = name == FIT
        except SkinfieldError as error:
            self.say("error", f"solver {name}: {error}")
        finally:
            self._preparing = ""

    def tare(self) -> dict[str, Any]:
        """See `Desk`."""
        presser = self._presser
        if presser is not None and presser.standing:
            raise InputError("something presses, expected an untouched skin: lift it off first")
        if presser is not None and not presser.let_off(LIFTS):
            raise InputError("the scene still presses, expected an untouched skin: try again")
        time.sleep(RESTS)  # readings of the touch may be on their way
        live = self._feed().live
        before = int(live.reader.status_view["tares"][0])
        live.tare()
        self._taring = before, time.monotonic() + PATIENCE * self._tare_seconds
        return {}

    def come(self) -> None:
        """See `Desk`."""
        if self._recordings is not None:
            self._recordings.prepare()

    def record(self, on: bool) -> dict[str, Any]:
        """See `Desk`."""
        if self._recordings is None:
            return super().record(on)
        return self._recordings.begin() if on else self._recordings.end()

    def recording(self, name: str) -> Feed:
        """See `Desk`."""
        return super().recording(name) if self._recordings is None else self._recordings.open(name)

    def press(self, press: Press) -> dict[str, Any]:
        """See `Desk`."""
        return super().press(press) if self._presser is None else self._presser.press(press)

    def lift(self, id: str | None) -> dict[str, Any]:
        """See `Desk`."""
        return super().lift(id) if self._presser is None else self._presser.lift(id)

    def leave(self, browser: str) -> None:
        """See `Desk`."""
        if self._presser is not None:
            self._presser.leave(browser)

    def scene(self, name: str) -> dict[str, Any]:
        """See `Desk`."""
        return super().scene(name) if self._presser is None else self._presser.scene(name)

    def begin(self, scene: str) -> None:
        """Play a scene, unless somebody presses by hand already."""
        if self._presser is not None:
            self._presser.begin(scene)

    def close(self) -> None:
        """End what was begun."""
        if self._recordings is not None:
            self._recordings.close()
