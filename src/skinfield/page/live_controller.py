"""Controller of the page of a skin that runs here."""

import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

from skinfield.errors import InputError, SkinfieldError, check_choice
from skinfield.loop import State
from skinfield.loop.client import Live
from skinfield.loop.status_text import read_notes, start_in_words
from skinfield.page.controller import TUNED, Controller
from skinfield.page.presser import NO_VIRTUAL, Presser, Virtual
from skinfield.page.recordings import Recordings
from skinfield.page.source import DataSource, EngineView, LiveSource

MILLI, MICRO = 1e-3, 1e-6
UNITS = {
    "deadline_us": ("deadline", MICRO),
    "smoothing_ms": ("smoothing", MILLI),
    "threshold_N": ("threshold", 1.0),
}


def runtime_parameters(live: Live) -> dict[str, Any]:
    """What is in force, what it may be, and in `off` why something cannot be changed."""
    plain = live.limits.as_dict(live.tuning)
    fields: dict[str, Any] = {"resolution": plain["resolution"], "off": plain["off"]}
    for name, (setting, unit) in UNITS.items():
        numbers = plain[setting]["value"], *plain[setting]["range"]
        value, *ends = (round(each / unit, 6) for each in numbers)
        fields[name] = {"value": value, "range": ends}
    focus = plain["focus"]["value"]
    if focus is not None:
        names = [patch.name for patch in live.skin]
        focus = {**focus, "patch": names.index(focus["patch"])}
    return {**fields, "focus": focus}


def tune(live: Live, what: str, value: Any) -> None:
    """Change one of `TUNED`.

    Raises
    ------
    InputError
        For what the engine cannot be.
    """
    check_choice("what", what, TUNED, "or solver")
    name, unit = UNITS.get(what, (what, 0.0))
    if unit:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"{what} is {value!r:.80}, expected a number")
        value = value * unit
        for limit in live.limits.as_dict(live.tuning)[name]["range"]:
            if math.isclose(value, limit, rel_tol=1e-6):  # whose last bit is lost in its unit
                value = float(limit)
    live.tune(**{name: value})


PATIENCE = 12.0  # times the asked time, after which a baseline is not waited for any more
LIFTS, RESTS = 2.0, 0.1  # s, for a scene to let off, and for its last readings


class LiveController(Controller):
    """See `Controller`.

    Parameters
    ----------
    source : function that returns a LiveSource
        Of the engine; another one after it was made anew.
    virtual : Virtual, optional
        That is pressed from the page.
    recordings : Recordings, optional
    solvers : sequence of str
        Names of those that the engine may answer by.
    solver : str
        The one in force.
    choose : function of a name, optional
        Takes another solver; returns when the engine is being made anew.
    tare_seconds : float, s
        That a baseline takes.
    """

    mode = "live"

    def __init__(
        self,
        source: Callable[[], LiveSource],
        *,
        virtual: Virtual | None = None,
        recordings: Recordings | None = None,
        solvers: Sequence[str] = (),
        solver: str = "",
        choose: Callable[[str], None] = lambda name: None,
        tare_seconds: float = 1.0,
    ) -> None:
        super().__init__()
        self._source, self.recordings, self._choose_solver = source, recordings, choose
        if virtual is not None:
            self.presser = Presser(virtual, self._waits_for, lambda text: self.say("warn", text))
        self._tare_seconds = tare_seconds
        self._taring = -1, 0.0  # baselines before the one that is taken, until when to wait
        self._preparing = ""  # name of a solver
        self._solvers = tuple(solvers)
        self._solver = solver

    # what is seen

    def views(self, sources: Sequence[DataSource]) -> list[EngineView]:
        """See `Controller`."""
        return [
            EngineView(each.latest(), each.old, True, each.fades)
            for each in sources
            if isinstance(each, LiveSource)
        ]

    def truth(self) -> Sequence[Mapping[str, Any]]:
        """See `Controller`."""
        if self.presser is None:
            return ()
        self.presser.do_waiting()
        return self.presser.truth()

    def controls(self) -> dict[str, Any]:
        """See `Controller`."""
        fields: dict[str, Any] = {"off": {}, "busy": self._busy() or None}
        try:
            fields |= runtime_parameters(self._source().live)
        except SkinfieldError as error:
            fields["off"] |= dict.fromkeys(TUNED, str(error))
        if self.presser is None:
            fields["off"]["press"] = NO_VIRTUAL
        else:
            fields["scene"] = self.presser.playing
            with suppress(SkinfieldError):  # a skin that starts anew answers the next time
                fields["tools"] = self.presser.tools()
        if self._solvers:
            value, preparing = self._solver, self._preparing or None
            fields["solver"] = {"value": value, "options": self._solvers, "preparing": preparing}
        fields["recording"] = None if self.recordings is None else self.recordings.state()
        return fields

    def _busy(self) -> str:
        """What is being done, in words; nothing if nothing is."""
        if self._preparing:
            return f"preparing the solver {self._preparing}"
        if waits := self._waits_for():
            return waits
        if self.presser is not None and self.presser.preparing:
            return "the tool is being prepared"
        return ""

    def _waits_for(self) -> str:
        """What has to end before anything may press, in words."""
        try:
            state = self._source().live.state
        except SkinfieldError as error:
            return str(error)
        if state == State.STARTING:
            notes = read_notes(self._source().live.reader.status_view["notes"]) or {}
            return f"the engine starts: {start_in_words(notes)}".removesuffix(": ")
        if state == State.CALIBRATING:
            return "the engine takes its baseline: the skin must not be touched"
        if state != State.RUNNING:
            return f"the engine has {state.name.lower()}"
        before, until = self._taring
        tares = before == self._source().live.tares and time.monotonic() < until
        return "a baseline is being taken: the skin must not be touched" if tares else ""

    # what is ordered

    def set(self, what: str, value: Any) -> dict[str, Any]:
        """See `Controller`."""
        if what == "solver":
            return self._choose(value)
        tune(self._source().live, what, value)
        return {}

    def _choose(self, name: Any) -> dict[str, Any]:
        """Take another solver."""
        if not self._solvers:
            return super().set("solver", name)
        check_choice("solver", name, self._solvers, "how readings become pressure")
        if self._preparing:
            raise InputError(f"{self._preparing} is being prepared, expected one at a time: wait")
        if name == self._solver:
            return {}
        self._preparing = str(name)
        threading.Thread(target=self._change, args=(name,), name="solver", daemon=True).start()
        return {"preparing": name}

    def _change(self, name: str) -> None:
        """Take another solver, which takes seconds to prepare; the skin is answered meanwhile."""
        try:
            self._choose_solver(name)
            self._solver = name
        except SkinfieldError as error:
            self.say("error", f"solver {name}: {error}")
        finally:
            self._preparing = ""

    def tare(self) -> dict[str, Any]:
        """See `Controller`."""
        presser = self.presser
        if presser is not None and presser.placed:
            raise InputError("something presses, expected an untouched skin: lift it off first")
        if presser is not None and not presser.let_off(LIFTS):
            raise InputError("the scene still presses, expected an untouched skin: try again")
        time.sleep(RESTS)  # readings of the touch may be on their way
        live = self._source().live
        before = live.tares
        live.tare()
        self._taring = before, time.monotonic() + PATIENCE * self._tare_seconds
        return {}

    def close(self) -> None:
        """End what was begun."""
        if self.recordings is not None:
            self.recordings.close()
