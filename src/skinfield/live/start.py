"""How an engine gets from its first readings to its first answer."""

import threading
from collections.abc import Callable

import numpy as np

from skinfield.acquisition import Channels
from skinfield.errors import Floats, Ints
from skinfield.live.binding import Binding
from skinfield.live.cycle import Cycle
from skinfield.live.recipe import Recipe
from skinfield.live.settings import LiveSettings
from skinfield.live.tare import Tare, Tared


class Preparation:
    """Makes a `Cycle` beside the loop, which goes on taking in readings.

    Parameters
    ----------
    make : function that returns a Cycle
    """

    def __init__(self, make: Callable[[], Cycle]) -> None:
        self._make = make
        self._made: Cycle | None = None
        self._failed: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="prepare", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        try:
            self._made = self._make()
        except BaseException as error:
            self._failed = error

    def poll(self) -> Cycle | None:
        """The cycle, when it is ready; raises what making it raised."""
        if self._thread.is_alive():
            return None
        self._thread.join()
        if self._failed is not None:
            raise self._failed
        return self._made


class Start:
    """First the code that must be compiled, then a baseline, then the engine for its noise.

    Parameters
    ----------
    settings : LiveSettings
    binding : Binding
    known : Tared, optional
        Of an engine that ran before on this ring: no new baseline is taken, as something may lie
        on the skin now.
    tracks : (1,) int64 array
        Contacts numbered so far, written in place.

    Attributes
    ----------
    phase : str
        What it does, for people.
    tared : Tared or None
        When there is one.
    """

    def __init__(
        self, settings: LiveSettings, binding: Binding, known: Tared | None, tracks: Ints
    ) -> None:
        self._settings, self._binding, self._tracks = settings, binding, tracks
        self._recipe = Recipe.of(settings, binding.ports)
        self._tare = Tare(settings, binding)  # begun anew once what must be loaded is
        self.tared = known
        self.phase = "loading"
        self._preparation = Preparation(self._rehearsed if known is None else self._final)

    def _rehearsed(self) -> Cycle:
        """With a typical noise: whatever must be compiled, is, before readings are waited for."""
        taxels = len(self._binding.channel)
        table = np.zeros((taxels, 4))
        table[:, 1:] = 1.0
        noise = np.full(taxels, self._settings.quantity.typical_noise)
        return self._cycle(table, noise, 1_000_000_000)

    def _final(self) -> Cycle:
        assert self.tared is not None  # by then it is known
        return self._cycle(self.tared.calibration, self.tared.noise_std, self.tared.stale_ns)

    def _cycle(self, table: Floats, noise: Floats, stale_ns: int) -> Cycle:
        return Cycle(self._recipe, self._binding, table, noise, stale_ns, self._tracks)

    def take(self, channels: Channels, now_ns: int) -> Cycle | None:
        """Take what is new; the cycle when it is ready to answer."""
        if self.phase == "taring":
            if self._tare.take(channels, now_ns):
                self.tared = self._tare.finish()
                self.phase = "preparing"
                self._preparation = Preparation(self._final)
            return None
        made = self._preparation.poll()
        if made is None:
            return None
        if self.tared is None:
            self.phase = "taring"
            self._tare = Tare(self._settings, self._binding)
            self._tare.skip(channels)
            return None
        return made
