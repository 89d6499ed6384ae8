"""Controller of the page of a skin that runs here."""

import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from skinfield.errors import InputError, SkinfieldError, check_choice
from skinfield.loop.client import Live
from skinfield.loop.fit_ring import FitReader
from skinfield.loop.status_text import read_notes, start_in_words
from skinfield.page.controller import Controller, Press
from skinfield.page.presser import NO_VIRTUAL, Presser, Virtual
from skinfield.page.recordings import Recordings
from skinfield.page.source import DataSource, EngineView, LiveSource, merged_view, plain_view
from skinfield.ring import State

MILLI, MICRO = 1e-3, 1e-6
UNITS = {
    "deadline_us": ("deadline", MICRO),
    "smoothing_ms": ("smoothing", MILLI),
    "threshold_N": ("threshold", 1.0),
}
TUNED = ("resolution", "focus", *UNITS)


def runtime_parameters(live: Live) -> dict[str, Any]:
    """What is in force, what it may be, and in `off` why something cannot be changed."""
    plain = live.limits.as_dict(live.tuning)
    fields: dict[str, Any] = {"resolution": plain["resolution"], "off": plain["off"]}
    for name, (setting, unit) in UNITS.items():
        entry = plain[setting]
        low, high = entry["range"]
        fields[name] = {
            "value": round(entry["value"] / unit, 6),
            "range": [round(low / unit, 6), round(high / unit, 6)],
        }
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
    changes: dict[str, Any]
    if what in UNITS:
        name, unit = UNITS[what]
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"{what} is {value!r:.80}, expected a number")
        changes = {name: _within(live, name, value * unit)}
    elif what in ("resolution", "focus"):
        changes = {what: value}
    else:
        raise InputError(f"what is {what[:40]!r}, expected solver or one of {', '.join(TUNED)}")
    live.tune(**changes)


def _within(live: Live, name: str, value: float) -> float:
    """A value in SI; a limit of the page is the engine's, whose last bit is lost in its unit."""
    for limit in live.limits.as_dict(live.tuning)[name]["range"]:
        if math.isclose(value, limit, rel_tol=1e-6):
            return float(limit)
    return value


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


class LiveController(Controller):
    """See `Controller`.

    Parameters
    ----------
    source : function that returns a LiveSource
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
        source: Callable[[], LiveSource],
        *,
        virtual: Virtual | None = None,
        tool: tuple[float, float] = (1.0, 10e-3),
        recordings: Recordings | None = None,
        solvers: Solvers | None = None,
        fit: FitReader | None = None,
        tare_seconds: float = 1.0,
    ) -> None:
        super().__init__()
        self._source, self._recordings, self._solvers = source, recordings, solvers
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

    def views(self, sources: Sequence[DataSource]) -> list[EngineView]:
        """See `Controller`."""
        return [self._view(source) for source in sources]

    def _view(self, source: DataSource) -> EngineView:
        snapshot, fit = source.latest(), self._fit
        old = isinstance(source, LiveSource) and source.old
        if snapshot is None or fit is None or not self._fitting:
            return plain_view(snapshot)._replace(old=old)
        with self._fit_lock:
            return merged_view(snapshot, fit.latest())._replace(old=old)

    def truth(self) -> Sequence[Mapping[str, Any]]:
        """See `Controller`."""
        if self._presser is None:
            return ()
        self._presser.do_waiting()
        return self._presser.truth()

    def hello(self) -> dict[str, Any]:
        """See `Controller`."""
        recordings = self._recordings
        return {
            "press": None if self._presser is None else self._presser.offer(),
            "record": recordings is not None,
            "recordings": [] if recordings is None else recordings.names,
        }

    def controls(self) -> dict[str, Any]:
        """See `Controller`."""
        fields: dict[str, Any] = {"off": {}, "busy": self._busy() or None}
        try:
            fields |= runtime_parameters(self._source().live)
        except SkinfieldError as error:
            fields["off"] |= dict.fromkeys(TUNED, str(error))
        if self._presser is None:
            fields["off"]["press"] = NO_VIRTUAL
        else:
            fields["scene"] = self._presser.playing
        if self._solvers is not None:
            names = ([FIT] if self._fit is not None else []) + list(self._solvers.names)
            preparing = self._preparing or None
            fields["solver"] = {"value": self._solver(), "options": names, "preparing": preparing}
        fields["recording"] = None if self._recordings is None else self._recordings.state()
        return fields

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
            state = self._source().live.state
        except SkinfieldError as error:
            return str(error)
        if state == State.STARTING:
            notes = read_notes(self._source().live.reader.status_view["notes"]) or {}
            return f"the engine starts: {start_in_words(notes)}".removesuffix(": ")
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
        taken = int(self._source().live.reader.status_view["tares"][0])
        if taken != before or time.monotonic() > until:
            self._taring = None
        return self._taring is not None

    def notices(self) -> list[tuple[str, str]]:
        """See `Controller`."""
        if self._recordings is not None:
            for text in self._recordings.notices():
                self.say("error", text)
        return super().notices()

    # what is ordered

    def set(self, what: str, value: Any) -> dict[str, Any]:
        """See `Controller`."""
        if what == "solver":
            return self._choose(value)
        tune(self._source().live, what, value)
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
        """See `Controller`."""
        presser = self._presser
        if presser is not None and presser.placed:
            raise InputError("something presses, expected an untouched skin: lift it off first")
        if presser is not None and not presser.let_off(LIFTS):
            raise InputError("the scene still presses, expected an untouched skin: try again")
        time.sleep(RESTS)  # readings of the touch may be on their way
        live = self._source().live
        before = int(live.reader.status_view["tares"][0])
        live.tare()
        self._taring = before, time.monotonic() + PATIENCE * self._tare_seconds
        return {}

    def come(self) -> None:
        """See `Controller`."""
        if self._recordings is not None:
            self._recordings.prepare()

    def record(self, on: bool) -> dict[str, Any]:
        """See `Controller`."""
        if self._recordings is None:
            return super().record(on)
        return self._recordings.begin() if on else self._recordings.end()

    def recording(self, name: str) -> DataSource:
        """See `Controller`."""
        return super().recording(name) if self._recordings is None else self._recordings.open(name)

    def press(self, press: Press) -> dict[str, Any]:
        """See `Controller`."""
        return super().press(press) if self._presser is None else self._presser.press(press)

    def lift(self, id: str | None) -> dict[str, Any]:
        """See `Controller`."""
        return super().lift(id) if self._presser is None else self._presser.lift(id)

    def leave(self, browser: str) -> None:
        """See `Controller`."""
        if self._presser is not None:
            self._presser.leave(browser)

    def scene(self, name: str) -> dict[str, Any]:
        """See `Controller`."""
        return super().scene(name) if self._presser is None else self._presser.scene(name)

    def begin(self, scene: str) -> None:
        """Play a scene, unless somebody presses by hand already."""
        if self._presser is not None:
            self._presser.begin(scene)

    def close(self) -> None:
        """End what was begun."""
        if self._recordings is not None:
            self._recordings.close()
