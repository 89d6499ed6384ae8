"""Preparation of an engine beside its loop: code, baseline, and the solver that was asked for."""

import os
import threading
import time
from concurrent.futures import Future
from dataclasses import replace
from functools import cache

import numpy as np

from skinfield.compile_progress import CompileProgress
from skinfield.errors import Ints
from skinfield.loop.baseline import BaselineCollector, TareBaseline
from skinfield.loop.model_config import ModelConfig
from skinfield.loop.realtime.system import SOON_OVER
from skinfield.loop.settings import LiveSettings
from skinfield.loop.update import Updater
from skinfield.signal import Channels
from skinfield.solve import Auto, ContactFit, GaussianField, Solver


@cache
def processors() -> frozenset[int]:
    """Those that this process may use; asked first before the loop is pinned to one of them."""
    allowed = getattr(os, "sched_getaffinity", lambda _: ())  # not on macOS
    return frozenset(allowed(0))


class Preparation:
    """Updater that is prepared beside the loop, which goes on taking in readings.

    Its thread uses any processor of the process: that of the loop may have no time for it.

    Parameters
    ----------
    model_config : ModelConfig
    baseline : TareBaseline
    tracks : (1,) int64 array, optional
        See `Updater`.
    after : Preparation, optional
        Whose end is waited for: it loads the same code.
    compiling : CompileProgress, optional
        Of the process.

    Attributes
    ----------
    progress : dict
        `patches` that are ready, `of` how many, and `left_s`, how long the others take, s, where
        that can be said; once functions are compiled, `compiled` is the share of that work that is
        done and `compile_left_s` how long the rest takes, s. Empty before the first.
    """

    def __init__(
        self,
        model_config: ModelConfig,
        baseline: TareBaseline,
        tracks: Ints | None = None,
        after: "Preparation | None" = None,
        compiling: CompileProgress | None = None,
    ) -> None:
        self._compiling, self._patches = compiling, dict[str, float]()
        self._processors, self._after = processors(), after
        self._arguments, self._began = (model_config, baseline, tracks), time.monotonic()
        self._made: Future[Updater] = Future()
        threading.Thread(target=self._run, name=SOON_OVER, daemon=True).start()

    @property
    def updater(self) -> Updater | None:
        """When it is there; raises what went wrong."""
        return self._made.result() if self._made.done() else None

    @property
    def has_ended(self) -> bool:
        """Whether it is made, or has failed."""
        return self._made.done()

    def _run(self) -> None:
        try:
            if self._processors:
                os.sched_setaffinity(0, self._processors)  # of this thread
            before, self._after = self._after, None
            if before is not None:
                before._made.exception()
            self._made.set_result(Updater(*self._arguments, self._advance))
        except BaseException as error:
            self._made.set_exception(error)

    @property
    def progress(self) -> dict[str, float]:
        """How far it is, see above."""
        its = self._compiling
        if its is None or not its.count:
            return self._patches
        left = float(round(its.seconds_left))
        return {**self._patches, "compiled": round(its.share, 2), "compile_left_s": left}

    def _advance(self, ready: int, patches: int) -> None:
        """So many patches are ready."""
        now = time.monotonic()
        if ready == 0:
            self._began = now
        progress: dict[str, float] = {"patches": ready, "of": patches}
        if ready:
            progress["left_s"] = round((now - self._began) / ready * (patches - ready), 1)
        self._patches = progress


class Start:
    """First the code that must be compiled, then a baseline, then an engine for its noise.

    What takes long to compile is loaded while the baseline is taken. Where that has ended by then,
    the engine is one of the solver that was asked for, else of one that is quick to load.

    Parameters
    ----------
    known : TareBaseline, optional
        Of an engine that ran before on this ring: no new baseline is taken, as something may lie
        on the skin now.
    tracks : (1,) int64 array
        Contacts numbered so far, written in place.

    Attributes
    ----------
    phase : str
        What it does, for people: "loading", "taring" or "preparing".
    baseline : TareBaseline or None
        When there is one.
    rehearsal : Preparation or None
        Of the solver that was asked for, by a typical noise, from when the quick one is loaded.
    """

    def __init__(
        self,
        settings: LiveSettings,
        model_config: ModelConfig,
        known: TareBaseline | None,
        tracks: Ints,
        compiling: CompileProgress | None = None,
    ) -> None:
        self._settings, self._model_config, self._tracks = settings, model_config, tracks
        self._compiling = compiling
        self._quick = replace(model_config, solver=quick(model_config.solver))
        self.rehearsal: Preparation | None = None
        self._tare = BaselineCollector(settings, model_config.binding)  # begun anew once it can be
        self.baseline = known
        self.phase = "loading"
        self._preparation = self._prepared(self._quick, known or self._typical(), tracks)

    def _prepared(
        self, model_config: ModelConfig, baseline: TareBaseline, tracks: Ints | None = None
    ) -> Preparation:
        return Preparation(model_config, baseline, tracks, compiling=self._compiling)

    @property
    def progress(self) -> dict[str, float]:
        """Of what is being prepared, see `Preparation`."""
        return {} if self.phase == "taring" else self._preparation.progress

    def _typical(self) -> TareBaseline:
        """Of a typical noise, by which all is compiled before readings are waited for."""
        binding, quantity = self._model_config.binding, self._model_config.quantity
        noise = np.full(len(binding.channel), quantity.typical_noise)
        return TareBaseline(np.tile([0.0, 1.0, 1.0, 1.0], (len(noise), 1)), noise, 1_000_000_000)

    def take(self, channels: Channels, now_ns: int) -> Updater | None:
        """Take what is new; the updater when it is ready to answer."""
        if self.phase == "taring":
            if self._tare.take(channels, now_ns):
                self.phase, self.baseline = "preparing", self._tare.finish()
                loaded = self.rehearsal is not None and self.rehearsal.has_ended
                by = self._model_config if loaded else self._quick
                self._preparation = self._prepared(by, self.baseline, self._tracks)
            return None
        made = self._preparation.updater
        if made is not None and self.baseline is None:
            self.phase = "taring"
            if self._quick.solver != self._model_config.solver:
                self.rehearsal = self._prepared(self._model_config, self._typical())
            self._tare = BaselineCollector(self._settings, self._model_config.binding)
            self._tare.skip(channels)
            return None
        return made


def quick(solver: Solver) -> Solver:
    """Solver that answers until another one is compiled and prepared: itself, where that is soon.

    Fits of contacts take half a minute to compile, once for a machine; linear answers do not.
    """
    return GaussianField() if isinstance(solver, Auto | ContactFit) else solver
