"""One cycle: newest counts to estimates in a slot. The live engine and a replay run this code."""

import numpy as np
from numpy.typing import ArrayLike

from skinfield.acquisition import Channels
from skinfield.acquisition.recorded import Cycle as Recorded
from skinfield.acquisition.recorded import CycleFlag
from skinfield.conditioning import Convention
from skinfield.engine import Engine
from skinfield.engine.state import Answer
from skinfield.errors import Floats, Ints, check_shape
from skinfield.live.binding import Binding
from skinfield.live.recipe import Recipe
from skinfield.live.slots import PATCH, Head, Sizes, Slot
from skinfield.live.tare import quantity_scale
from skinfield.live.touches import Touches

HALF_INTERVAL = 10  # of a taxel fits so often into the age at which its reading is too old
MOST_PATIENCE_NS = 20_000_000
KEY, LATE = int(CycleFlag.KEY), int(CycleFlag.LATE)
MISSING, IDLE, FEASIBLE = int(Answer.MISSING), int(Answer.IDLE), int(Answer.FEASIBLE)


class Cycle:
    """Prepared arrays of all patches; answers cycle after cycle into slots.

    Parameters
    ----------
    recipe : Recipe
    binding : Binding
    calibration : (L, 4) array
        See `Tared`.
    noise_std : (L,) array
        In the quantity's unit.
    stale_ns : int, ns
        Age at which a reading is left out.
    tracks : (1,) int64 array
        Contacts numbered so far; may lie where others see it.

    Attributes
    ----------
    engine : Engine
    sizes : Sizes
    """

    def __init__(
        self,
        recipe: Recipe,
        binding: Binding,
        calibration: Floats,
        noise_std: Floats,
        stale_ns: int,
        tracks: Ints | None = None,
    ) -> None:
        from skinfield.live.condition_kernel import condition

        self.recipe, self.stale_ns = recipe, stale_ns
        self.engine: Engine = recipe.engine(noise_std)
        self.sizes = Sizes.of(recipe.skin, recipe.rungs, recipe.rows)
        taxels, patches = self.sizes.taxels, self.sizes.patches
        self._binding, self._condition = binding, condition
        self._values, self._valid = np.zeros(taxels), np.zeros(taxels, np.bool_)
        self._given, self._counts = np.zeros(taxels, np.bool_), np.zeros(taxels)
        self._newest, self._arrived = np.zeros((2, patches), np.int64)
        self._mask = np.zeros(patches, np.bool_)
        self._how, self._scale = quantity_scale(recipe.quantity, recipe.layer, binding.unit)
        self._lowest = float(recipe.quantity.lowest)
        board = recipe.board
        self._clamps = (-np.inf, np.inf) if board is None else _clamps(board)
        self._kept = Slot.empty(self.sizes)
        self.tracks: Ints = np.zeros(1, np.int64) if tracks is None else tracks
        self._touches = Touches(recipe.skin, self.engine, recipe.rows, self.tracks)
        self.calibrate(calibration)
        self._rehearse()

    @property
    def newest_ns(self) -> int:
        """Stamp of the newest reading of any patch, ns since the epoch."""
        return int(self._newest.max())

    def calibrate(self, table: Floats) -> None:
        """Take a calibration (L, 4); see `Tared`."""
        check_shape("calibration", table, (self.sizes.taxels, 4), "baseline, gain, noise, alive")
        self._baseline = np.ascontiguousarray(table[:, 0])
        self._alive = np.ascontiguousarray(table[:, 3] > 0)
        gain = np.where(self._alive, table[:, 1], 1.0)
        self._per_gain = 1.0 / gain

    def go_on_from(self, recorded: Recorded) -> None:
        """Take over what a recorded cycle told of patches and contacts, for the key cycle after."""
        kept, start = self._kept, 0
        kept.patches[:] = recorded.patches
        self.tracks[0] = recorded.patches["tracks"][0]
        for patch, count in enumerate(recorded.patches["contacts"].tolist()):
            kept.contacts[patch, :count] = recorded.contacts[start : start + count]
            start += count

    def answer(
        self,
        channels: Channels,
        now_ns: int,
        slot: Slot,
        *,
        key: bool = False,
        budget: float | None = None,
        script: ArrayLike | None = None,
    ) -> bool:
        """Answer the patches that have a new reading; all others keep their answer and its stamp.

        Parameters
        ----------
        channels : Channels
            Their `fresh` is set back.
        now_ns : int, ns
            Since the epoch: decides which readings are too old.
        slot : Slot
            Receives everything but the times and the log's position.
        key : bool
            Whether to forget the readings before first.
        budget : float, s, optional
        script : (S, 5) int64 array, optional
            Of a cycle that is done again.

        Returns
        -------
        bool
            Whether any patch had a new reading.
        """
        if key:
            self.engine.reset()
            self._touches.resume(self._kept)
        fresh = self._take(channels, now_ns)
        head, kept = slot.head, self._kept
        head[Head.FLAGS] = KEY if key else 0
        head[Head.FRESH] = fresh
        head[Head.SCRIPT] = 0
        kept.patches["fresh"] = self._arrived
        if fresh:
            self.engine.run(self._values, self._given, budget=budget, script=script)
            rows = self.engine.script
            head[Head.SCRIPT] = len(rows)
            slot.script[: len(rows)] = rows
            self._keep(now_ns)
        self._forget_stale(now_ns)
        head[Head.CONTACTS] = int(kept.patches["contacts"].sum())
        self._kept.patches["tracks"] = self.tracks
        self._publish(channels, slot)
        return fresh > 0

    def _take(self, channels: Channels, now_ns: int) -> int:
        """Read the newest counts of all taxels; how many patches have new ones."""
        return int(
            self._condition(
                self._binding.channel,
                channels.counts,
                channels.stamp_ns,
                channels.status,
                channels.fresh,
                self._baseline,
                self._per_gain,
                self._alive,
                self._clamps,
                self._lowest,
                self._how,
                self._scale,
                now_ns - self.stale_ns,
                now_ns,
                min(self.stale_ns // HALF_INTERVAL, MOST_PATIENCE_NS),
                self._binding.starts,
                self._values,
                self._valid,
                self._given,
                self._newest,
                self._arrived,
            )
        )

    def _keep(self, now_ns: int) -> None:
        """Take over the answers of the patches that had a new reading."""
        results, patches, mask = self.engine.results, self._kept.patches, self._mask
        np.greater(self._arrived, 0, out=mask)
        for name in ("answer", "iterations", "invalid", "gap"):
            np.copyto(patches[name], getattr(results, name), where=mask, casting="same_kind")
        np.copyto(patches["stamp_ns"], self._newest, where=mask)
        np.copyto(patches["answered_ns"], now_ns, where=mask)
        for patch in np.flatnonzero(mask).tolist():
            answer = int(results.answer[patch])
            rung = int(results.rung[patch])
            patches["rung"][patch] = self.recipe.rungs[rung] if rung >= 0 else 0
            if answer > IDLE:
                self._touched(patch, rung, now_ns)
            else:
                self._untouched(patch)

    def _touched(self, patch: int, rung: int, now_ns: int) -> None:
        """Pressure and contacts of a patch with something on it."""
        kept, pressure = self._kept, self.engine.results.pressure_of(patch)
        kept.pressure[patch, : len(pressure)] = pressure
        rows, row = kept.contacts[patch], kept.patches[patch]
        searched = kept.patches["answer"][patch] == FEASIBLE
        found = self._touches.find(patch, rung, searched, pressure, int(self._newest[patch]), rows)
        found = min(found, len(rows))
        row["contacts"] = found
        row["force"] = rows["normal_force"][:found].sum()
        row["peak_pressure"] = rows["peak_pressure"][:found].max() if found else 0.0

    def _untouched(self, patch: int) -> None:
        row = self._kept.patches[patch]
        if row["contacts"] or row["force"]:
            row["contacts"], row["force"], row["peak_pressure"] = 0, 0.0, 0.0

    def _forget_stale(self, now_ns: int) -> None:
        """What nothing new came of for too long is missing."""
        patches = self._kept.patches
        np.less(patches["stamp_ns"], now_ns - self.stale_ns, out=self._mask)
        np.logical_and(self._mask, patches["answer"] > MISSING, out=self._mask)
        if not self._mask.any():
            return
        for patch in np.flatnonzero(self._mask).tolist():
            row = patches[patch]
            row["answer"], row["rung"], row["gap"] = MISSING, 0, np.nan
            self._untouched(patch)

    def _publish(self, channels: Channels, slot: Slot) -> None:
        """Copy what is kept into the slot."""
        kept = self._kept
        slot.patches[:] = kept.patches
        np.take(channels.counts, self._binding.channel, out=self._counts, mode="clip")
        slot.counts[:] = self._counts
        slot.values[:] = self._values
        slot.valid[:] = self._valid
        for patch in np.flatnonzero(kept.patches["contacts"]).tolist():
            slot.contacts[patch] = kept.contacts[patch]
        for patch in np.flatnonzero(kept.patches["answer"] > IDLE).tolist():
            nodes = int(kept.patches["rung"][patch]) ** 2
            slot.pressure[patch, :nodes] = kept.pressure[patch, :nodes]

    def _rehearse(self) -> None:
        """Load what is compiled, and know nothing afterwards."""
        channels, slot = Channels(self._binding.channels), Slot.empty(self.sizes)
        channels.counts[:] = 0.0
        channels.fresh[:] = 1
        before = int(self.tracks[0])
        self.answer(channels, self.stale_ns, slot, key=True)
        self.answer(channels, self.stale_ns, slot)
        self.engine.reset()
        self._kept.patches[:] = np.zeros(1, PATCH)
        self._touches.resume(self._kept)
        self.tracks[0] = before


def _clamps(board: Convention) -> tuple[float, float]:
    """Counts at or beyond which nothing is told; a scale that starts at rest has none there."""
    lowest = np.array([board.lowest])
    low = board.lowest if board.saturated(lowest)[0] else board.lowest - 1.0
    return float(low), float(board.highest)
