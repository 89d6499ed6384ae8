"""A tuning at work: what a cycle does beside what its recipe says."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.acquisition.block import PAYLOAD, Kind
from skinfield.contacts.live import CONTACT
from skinfield.engine import Engine
from skinfield.engine.preference import prefer
from skinfield.errors import Floats, InputError, Ints
from skinfield.live.binding import Binding
from skinfield.live.slots import Slot
from skinfield.live.tuning import AUTO, Tuning

CONTACT_WORDS = CONTACT.itemsize // 8
SMOOTHED = PAYLOAD[Kind.SMOOTHED]


class Tuned:
    """Low-pass, threshold and focus of a cycle; nothing is allocated between changes.

    Parameters
    ----------
    engine : Engine
    binding : Binding
    stale_ns : int, ns
        Age at which a reading is left out.
    kept : Slot
        Of the newest answers.

    Attributes
    ----------
    smoothing, threshold : float, s, N
        0: none.
    watches : bool
        Whether there is a focus.
    """

    def __init__(self, engine: Engine, binding: Binding, stale_ns: int, kept: Slot) -> None:
        from skinfield.live.smooth_kernel import drop_weak, presses_within, smooth

        self._engine, self._stale_ns, self._kept = engine, stale_ns, kept
        self._channel = binding.channel
        self._smooth, self._drop_weak, self._within = smooth, drop_weak, presses_within
        self._state: Floats = np.zeros(len(binding.channel))
        self._at_ns: Ints = np.zeros(len(binding.channel), np.int64)
        self._rows: NDArray[np.void] = np.zeros(len(binding.channel), SMOOTHED)
        self.smoothing = self.threshold = 0.0
        self._finest: int | None = None
        self._window: tuple[int, float, float, float, float] | None = None
        self._first: int | None = None
        self.watches = False

    def tune(self, tuning: Tuning) -> None:
        """Go by this from now on.

        Raises
        ------
        InputError
            If there is no such grid or patch.
        """
        engine, focus, window = self._engine, tuning.focus, None
        if tuning.resolution != AUTO and tuning.resolution not in engine.rungs:
            raise InputError(f"resolution is {tuning.resolution}, expected one of {engine.rungs}")
        if focus is not None:
            if focus.patch not in engine.names:
                raise InputError(f"focus is on {focus.patch!r}, expected one of {engine.names}")
            window = (engine.names.index(focus.patch), *focus.low, *focus.high)
        if tuning.smoothing == 0.0:
            self.forget()
        self.smoothing, self.threshold = tuning.smoothing, tuning.threshold
        auto = tuning.resolution == AUTO
        self._finest = None if auto else engine.rungs.index(int(tuning.resolution))
        self._window, self._first, self.watches = window, None, window is not None
        prefer(engine, self._finest, None)

    def forget(self) -> None:
        """Know of no reading."""
        self._at_ns[:] = 0

    def smooth(
        self, stamps: Ints, valid: NDArray[np.bool_], given: NDArray[np.bool_], values: Floats
    ) -> None:
        """Low-pass of what was read; see `smooth_kernel.smooth`."""
        self._smooth(
            self._channel,
            stamps,
            valid,
            given,
            self._stale_ns,
            self.smoothing,
            values,
            self._state,
            self._at_ns,
        )

    def told(self, patch: int, rows: NDArray[Any], words: NDArray[np.int64], count: int) -> int:
        """Drop a patch's contacts below the threshold; how many are left."""
        return int(self._drop_weak(rows, words[patch], CONTACT_WORDS, count, self.threshold))

    def attend(self) -> None:
        """Have what presses in the window come first, by the contacts of the newest answers."""
        assert self._window is not None  # whoever calls has looked
        patch, *corners = self._window
        count = min(int(self._kept.patches["contacts"][patch]), self._kept.contacts.shape[1])
        first = patch if self._within(self._kept.contacts[patch], count, *corners) else None
        if first != self._first:
            self._first = first
            prefer(self._engine, self._finest, first)

    @property
    def smoothed(self) -> NDArray[np.void]:
        """Where the low-pass stands, (L,) records of `Kind.SMOOTHED`, until it is asked again."""
        rows = self._rows
        rows["value"], rows["stamp_ns"] = self._state, self._at_ns
        return rows

    def go_on_smoothing(self, rows: NDArray[np.void]) -> None:
        """Go on from where a low-pass stood."""
        self._state[:], self._at_ns[:] = rows["value"], rows["stamp_ns"]

    def load(self) -> None:
        """Load what is compiled; nothing changes."""
        rows = self._kept.contacts[0].copy()
        self._drop_weak(rows, rows.view(np.int64).reshape(-1), CONTACT_WORDS, 0, 0.0)
        self._within(rows, 0, 0.0, 0.0, 0.0, 0.0)
        nothing = np.zeros(len(self._state), np.bool_)
        self.smooth(self._at_ns, nothing, nothing, self._state)
