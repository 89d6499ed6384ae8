"""One cycle: newest counts to estimates in a slot. The live engine and a replay run this code."""

import numpy as np
from numpy.typing import ArrayLike

from skinfield.acquisition import Channels
from skinfield.acquisition.recorded import Cycle as Recorded
from skinfield.acquisition.recorded import CycleFlag
from skinfield.conditioning import Convention
from skinfield.engine import Engine
from skinfield.errors import Floats, Ints, check_shape
from skinfield.live.binding import Binding
from skinfield.live.lowest import lowest_change
from skinfield.live.recipe import Recipe
from skinfield.live.slots import PATCH, Head, Sizes, Slot
from skinfield.live.tare import quantity_scale
from skinfield.live.touches import Touches
from skinfield.live.tuned import CONTACT_WORDS, Tuned

HALF_INTERVAL = 10  # of a taxel fits so often into the age at which its reading is too old
MOST_PATIENCE_NS = 20_000_000
KEY = int(CycleFlag.KEY)


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
    tuned : Tuned
        What can be changed while it answers.
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
        from skinfield.live.settle_kernel import copy_out, sum_up, take_over

        self.recipe, self.stale_ns = recipe, stale_ns
        self.engine: Engine = recipe.engine(noise_std)
        self.sizes = Sizes.of(recipe.skin, recipe.rungs, recipe.rows)
        taxels, patches = self.sizes.taxels, self.sizes.patches
        self._binding, self._condition = binding, condition
        self._take_over, self._sum_up, self._copy_out = take_over, sum_up, copy_out
        self._values, self._valid = np.zeros(taxels), np.zeros(taxels, np.bool_)
        self._given = np.zeros(taxels, np.bool_)
        self._sides = np.array(recipe.rungs, np.int64)
        self._newest, self._arrived = np.zeros((2, patches), np.int64)
        self._touched = np.zeros(patches, np.int64)
        self._how, self._scale = quantity_scale(recipe.quantity, recipe.layer, binding.unit)
        board = recipe.board
        self._clamps = (-np.inf, np.inf) if board is None else _clamps(board)
        self._kept = Slot.empty(self.sizes)
        self._kept_words = self._kept.contact_words
        self.tracks: Ints = np.zeros(1, np.int64) if tracks is None else tracks
        self._touches = Touches(self.engine, recipe.rows, self.tracks)
        self.tuned = Tuned(self.engine, binding, stale_ns, self._kept)
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
        self._lowest = self._lowest_of(table[self._alive])
        self.tuned.forget()

    def _lowest_of(self, known: Floats) -> float:
        """What no taxel reads, in the quantity's unit, by the calibration (N, 4) of the living."""
        from skinfield.live.condition_kernel import STRAIN

        lowest = float(self.recipe.quantity.lowest)
        if self._binding.unit != "count":
            return lowest
        change = lowest_change(self.recipe.board, known)
        if self._how == STRAIN:
            change = change / (1.0 + change) if change > -1.0 else -np.inf
        return max(lowest, change * self._scale)

    def count_in(self, tracks: Ints) -> None:
        """Number contacts in this array (1,) from now on."""
        self.tracks = self._touches.ids = tracks
        for each in self._touches.patches:
            each.ids = tracks

    def resume(self, slot: Slot) -> None:
        """Take over the newest cycle of an engine before, for the key cycle after."""
        if slot.patches["answered_ns"].any():
            self.go_on_from(slot.recorded(0))
            np.copyto(self._kept.pressure, slot.pressure)

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
        if self.tuned.smoothing:
            self.tuned.smooth(channels.stamp_ns, self._valid, self._given, self._values)
        if fresh:
            if self.tuned.watches:
                self.tuned.attend()
            self.engine.run(self._values, self._given, budget=budget, script=script)
            rows = self.engine.script
            head[Head.SCRIPT] = len(rows)
            slot.script[: len(rows)] = rows
        self._answered(now_ns)
        head[Head.CONTACTS] = self._sum_up(kept.patches, kept.contacts, int(self.tracks[0]))
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

    def _answered(self, now_ns: int) -> None:
        """Keep the answers of the patches with a new reading, and drop what is too old."""
        results, kept = self.engine.results, self._kept
        count = self._take_over(
            self._arrived,
            self._newest,
            results.answer,
            results.rung,
            results.gap,
            results.iterations,
            results.invalid,
            self._sides,
            now_ns,
            now_ns - self.stale_ns,
            kept.patches,
            self._touched,
        )
        for patch in self._touched[:count].tolist():
            pressure, rows = results.pressure_of(patch), kept.contacts[patch]
            kept.pressure[patch, : len(pressure)] = pressure
            found = self._touches.find(patch, int(self._newest[patch]), rows)
            count = min(found, len(rows))
            if self.tuned.threshold:
                count = self.tuned.told(patch, rows, self._kept_words, count)
            kept.patches["contacts"][patch] = count

    def _publish(self, channels: Channels, slot: Slot) -> None:
        """Copy what is kept into the slot."""
        kept = self._kept
        self._copy_out(
            kept.patches,
            self._kept_words,
            kept.pressure,
            CONTACT_WORDS,
            self._binding.channel,
            channels.counts,
            self._values,
            self._valid,
            slot.patches,
            slot.contact_words,
            slot.pressure,
            slot.counts,
            slot.values,
            slot.valid,
        )

    def _rehearse(self) -> None:
        """Load what is compiled, and know nothing afterwards."""
        channels, slot = Channels(self._binding.channels), Slot.empty(self.sizes)
        channels.counts[:] = 0.0
        channels.fresh[:] = 1
        before = int(self.tracks[0])
        self.answer(channels, self.stale_ns, slot, key=True)
        self.answer(channels, self.stale_ns, slot)
        self.tuned.load()
        self.forget()
        self.tracks[0] = before

    def forget(self) -> None:
        """Know of no reading and no contact."""
        self.engine.reset()
        self.tuned.forget()
        self._kept.patches[:] = np.zeros(1, PATCH)
        self._touches.resume(self._kept)
        self.tracks[0] = 0


def _clamps(board: Convention) -> tuple[float, float]:
    """Counts at or beyond which nothing is told; a scale that starts at rest has none there."""
    lowest = np.array([board.lowest])
    low = board.lowest if board.saturated(lowest)[0] else board.lowest - 1.0
    return float(low), float(board.highest)
