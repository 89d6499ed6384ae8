"""Update of a live skin: newest counts to estimates in a slot, by the parameters in force."""

from collections.abc import Callable
from typing import Any

import numpy as np

from skinfield.errors import Floats, Ints, check_shape
from skinfield.estimate.live_contacts import CONTACT
from skinfield.loop.baseline import TareBaseline
from skinfield.loop.model_config import ModelConfig
from skinfield.loop.runtime_parameters import AUTO, Tuning
from skinfield.loop.slots import PATCH, CycleHead, CycleSlot, Sizes
from skinfield.loop.stationary_mean import StationaryMeans, rounding_of
from skinfield.reconstruct.diagnostics import quantity_scale
from skinfield.reconstruct.engine import Engine, SkinContacts
from skinfield.reconstruct.engine.engine import prefer
from skinfield.reconstruct.engine.state import Answer
from skinfield.signal import Channels, Convention
from skinfield.signal.creep import CreepCompensation
from skinfield.signal.drift import Drift

RISEN = 0.1  # of the capacitance: more than a layer rises beside the hardest press of a finger
SURE = 6.0  # standard deviations, of boards that are noisier


def lowest_change(board: Convention | None, calibration: Floats) -> float:
    """Least ΔC/C₀ of counts that is believed.

    A taxel that reads less was touched when its baseline was taken, or its baseline has gone.
    Pressure cannot push it there: to explain it by what rises beside a press takes ten times the
    force that was let go. So it is left out, as at the end of a board's scale: an iCub's ends 15
    bytes beyond its rest. Boards that clip at their rest never read less.

    Parameters
    ----------
    board : Convention or None
        None where nobody says what a count means.
    calibration : (N, 4) array
        Of the taxels that live, see `TareBaseline`.
    """
    if not len(calibration):
        return -np.inf
    beyond = np.nan  # counts from the rest to the end of the scale on the unloaded side
    if board is not None:
        unloaded = board.highest if board.direction < 0 else board.lowest
        beyond = -board.direction * (unloaded - board.rest)
    if beyond == 0.0:
        return -np.inf
    gain = np.abs(calibration[:, 1])
    if np.isfinite(beyond):
        return -beyond / float(gain.min())
    return -max(RISEN, SURE * float(np.median(calibration[:, 2] / gain)))


def go_on_from(slot: CycleSlot, contacts: SkinContacts) -> None:
    """Have contacts go on from a cycle as it was published, and know nothing else.

    A replay that begins in the middle has no more than that.
    """
    for row, its, each in zip(slot.patches, slot.contacts, contacts.patches, strict=True):
        each.begin_from(its[: row["contacts"]], int(row["stamp_ns"]))


CONTACT_WORDS = CONTACT.itemsize // 8
MISSING, IDLE, FOUND = int(Answer.MISSING), int(Answer.IDLE), int(Answer.CONTACTS)


DOUBT = 2.0  # times less noise there may be than was found: it is what smooths rounding
KEEPS = 3  # times the age at which a reading is too old: an answer outlives a short pause
HALF_INTERVAL = 10  # of a taxel fits so often into the age at which its reading is too old
MOST_PATIENCE_NS = 20_000_000
LONG = 1.0  # s, of a search that is said to last


class Updater:
    """Prepared arrays of all patches; answers cycle after cycle into slots.

    Parameters
    ----------
    model_config : ModelConfig
    baseline : TareBaseline
    tracks : (1,) int64 array
        Contacts numbered so far; may lie where others see it.
    progress : function of two ints
        Called while it is prepared: patches that are ready, and how many there are.
    """

    def __init__(
        self,
        model_config: ModelConfig,
        baseline: TareBaseline,
        tracks: Ints | None = None,
        progress: Callable[[int, int], None] = lambda ready, patches: None,
    ) -> None:
        from skinfield.loop import update_kernel

        self.model_config, self.stale_ns = model_config, baseline.stale_ns
        self._binding, self._kernel = model_config.binding, update_kernel
        self.engine: Engine = model_config.engine(baseline.noise_std, progress)
        self.sizes = Sizes.of(model_config.skin, model_config.rungs, model_config.rows)
        taxels, patches = self.sizes.taxels, self.sizes.patches
        self._values, self._valid = np.zeros(taxels), np.zeros(taxels, np.bool_)
        self._given, self._lacking = np.zeros(taxels, np.bool_), np.zeros(taxels)
        self._plane = np.concatenate([patch.plane for patch in model_config.skin])
        self._sides = np.array(model_config.rungs, np.int64)
        self._newest, self._arrived, self._searched = np.zeros((3, patches), np.int64)
        self._conditioned: tuple[Any, ...] = (
            *(self._binding.starts, self._values, self._valid, self._given),
            *(self._lacking, self._newest, self._arrived),
        )
        self._touched, self._hot = np.zeros(patches, np.int64), np.zeros(patches, np.bool_)
        solids, quantity = [model_config.layer.relaxation] * patches, model_config.quantity
        self._creep = CreepCompensation(solids, self._binding.starts, quantity, standing=True)
        self._noise_std = baseline.noise_std * self._creep.noise_factor
        self._means = StationaryMeans(self._binding.starts)
        self._drift = Drift(self._noise_std, self._binding.starts)
        self._idle, self._follows = np.zeros(patches, np.bool_), self.engine.finds_contacts
        self._unended_ns = np.zeros(patches, np.int64)
        known = model_config.quantity, model_config.layer, self._binding.unit
        strains, self._scale = quantity_scale(*known)
        self._how = int(update_kernel.STRAIN if strains else update_kernel.CHANGE)
        board = model_config.board
        self._clamps = (-np.inf, np.inf) if board is None else _clamps(board)
        self._kept = CycleSlot.empty(self.sizes)
        self._kept_words = self._kept.contact_words
        self.tracks: Ints = np.zeros(1, np.int64) if tracks is None else tracks
        self._contacts = SkinContacts(self.engine, rows=model_config.rows, ids=self.tracks)
        self._smoothed, self._smoothed_ns = np.zeros(taxels), np.zeros(taxels, np.int64)
        self._smoothing = self._threshold = 0.0  # s, N; 0: none
        self._finest: int | None = None
        self._window: tuple[int, float, float, float, float] | None = None
        self._first: int | None = None
        self.calibrate(baseline.calibration)
        self._rehearse()

    @property
    def newest_ns(self) -> int:
        """Stamp of the newest reading of any patch, ns since the epoch."""
        return int(self._newest.max())

    def unfinished(self, now_ns: int) -> dict[str, int]:
        """Whole seconds for which searches of touched patches have not ended, of those that last.

        Each reading begins a search anew where the one before had no time to end.
        """
        if not self._follows:
            return {}
        since = self._unended_ns
        seconds = np.where(since > 0, now_ns - since, 0) * 1e-9
        names = zip(self.engine.names, seconds.tolist(), strict=True)
        return {name: int(lasts) for name, lasts in names if lasts >= LONG}

    def calibrate(self, table: Floats) -> None:
        """Take a calibration (L, 4); see `TareBaseline`."""
        check_shape("calibration", table, (self.sizes.taxels, 4), "baseline, gain, noise, alive")
        baseline, alive = table[:, 0].copy(), table[:, 3] > 0
        per_gain = 1.0 / np.where(alive, table[:, 1], 1.0)
        limits = self._clamps, self._limits_of(table[alive])
        how = self._how, self._scale
        self._calibrated: tuple[Any, ...] = baseline, per_gain, alive, *limits, *how
        noise, least = self._noise_std, table.copy()
        least[:, 2] /= DOUBT
        counted = self._binding.unit == "count"
        rounding = rounding_of(least, noise / DOUBT) if counted else np.zeros_like(noise)
        self._means.calibrate(noise, rounding)
        self._drift.reset()
        self._creep.reset()
        self._smoothed_ns[:] = 0

    def _limits_of(self, known: Floats) -> tuple[float, float]:
        """What no taxel reads, in the quantity's unit, by the calibration (N, 4) of the living."""
        quantity = self.model_config.quantity
        lowest, highest = float(quantity.lowest), float(quantity.highest)
        if self._binding.unit != "count":
            return lowest, highest
        change = lowest_change(self.model_config.board, known)
        if self._how == self._kernel.STRAIN:
            change = change / (1.0 + change) if change > -1.0 else -np.inf
        return max(lowest, change * self._scale), highest

    def tune(self, tuning: Tuning) -> None:
        """Go by this, which `Limits.check` has passed, from now on."""
        engine, focus, auto = self.engine, tuning.focus, tuning.resolution == AUTO
        if tuning.smoothing == 0.0:
            self._smoothed_ns[:] = 0
        self._smoothing, self._threshold = tuning.smoothing, tuning.threshold
        self._finest = None if auto else engine.rungs.index(int(tuning.resolution))
        self._window, self._first = None, None
        if focus is not None:
            self._window = (engine.names.index(focus.patch), *focus.low, *focus.high)
        prefer(engine, self._finest, None)

    def count_in(self, tracks: Ints) -> None:
        """Number contacts in this array (1,) from now on."""
        self.tracks = tracks
        self._contacts.count_in(tracks)

    def take_over(self, before: "Updater", calibration: Floats) -> None:
        """Go on from what another updater of this skin published last."""
        self.calibrate(calibration)
        self._kept.copy_from(before._kept)
        self.count_in(before.tracks)

    def resume(self, slot: CycleSlot) -> None:
        """Take over the newest cycle of an engine before, for the reset after."""
        if slot.patches["answered_ns"].any():
            kept = self._kept
            for name in ("patches", "contacts", "pressure"):
                np.copyto(getattr(kept, name), getattr(slot, name))
            self.tracks[0] = max(self.tracks[0], slot.patches["tracks"][0])

    def recall(self, slot: CycleSlot) -> None:
        """Have contacts of another engine's cycle go on, which coarser answers followed since.

        Those of the same numbers stand in their place: nearer to what this solver finds. What
        those answers did not tell apart goes on beside them, as long as there is room.
        """
        kept = self._kept
        known = kept.patches, kept.contacts, slot.patches, slot.contacts
        for row, rows, then, its in zip(*known, strict=True):
            count = min(int(row["contacts"]), len(rows))
            since = 1e-9 * int(row["stamp_ns"] - then["stamp_ns"])
            for contact in its[: then["contacts"]]:
                same = np.flatnonzero(rows["track"][:count] == contact["track"])
                place = int(same[0]) if len(same) else count
                if place < len(rows):
                    rows[place], count = contact, max(count, place + 1)
                    rows[place]["age"] += since
            row["contacts"] = count

    def answer(
        self,
        channels: Channels,
        now_ns: int,
        slot: CycleSlot,
        *,
        reset: bool = False,
        budget: float | None = None,
    ) -> bool:
        """Answer the patches that have a new reading; all others keep their answer and its stamp.

        Where no patch has one, the search goes on in the last readings that it was not done with.

        Parameters
        ----------
        channels : Channels
            Their `fresh` is set back.
        now_ns : int, ns
            Since the epoch: decides which readings are too old.
        slot : CycleSlot
            Receives everything but the times and the log's position.
        reset : bool
            Whether to forget the readings before first.
        budget : float, s, optional

        Returns
        -------
        bool
            Whether any patch had a new reading.
        """
        if reset:
            self.engine.reset()
            self._means.reset()
            self._drift.reset()
            self._creep.reset()
            go_on_from(self._kept, self._contacts)
        fresh = self._take(channels, now_ns)
        head, kept = slot.head, self._kept
        head[CycleHead.FLAGS] = 0
        head[CycleHead.FRESH] = fresh
        self._creep.take(self._values, self._valid, self._arrived, self._newest)
        if self._smoothing:
            self._smooth(channels)
        if fresh:
            if self._window is not None:
                self._attend(*self._window)
            self._run(budget)
            np.copyto(self._searched, self._newest, where=self._arrived > 0)
        else:
            self._search_further(budget)
        self._take_answers(now_ns, fresh > 0)
        head[CycleHead.CONTACTS] = self._kernel.sum_up(
            kept.patches, kept.contacts, int(self.tracks[0])
        )
        self._publish(channels, slot)
        return fresh > 0

    def repeat(self, channels: Channels, slot: CycleSlot) -> None:
        """Write what was answered last into a slot; new readings wait for the next answer."""
        head, kept = slot.head, self._kept
        head[CycleHead.FLAGS] = head[CycleHead.FRESH] = kept.patches["fresh"] = 0
        head[CycleHead.CONTACTS] = int(kept.patches["contacts"].sum())
        self._publish(channels, slot)

    def _run(self, budget: float | None) -> None:
        """Answer what was taken in, less where taxels rest, which is followed."""
        if not self._follows:
            self.engine.run(self._values, self._given, budget=budget)
            return
        left = self._drift.take(self._values)
        if self._smoothing:
            self.engine.run(left, self._given, budget=budget)
        else:
            self._run_by_means(left, budget)
        np.equal(self.engine.results.answer, IDLE, out=self._idle)
        self._drift.learn_idle(self._given, self._idle, self._newest)

    def _search_further(self, budget: float | None) -> None:
        """Spend a cycle without a reading on answers of the last ones that want for time.

        They are kept when they are done: a track takes no reading for many.
        """
        if self.engine.go_on(budget=budget):
            np.greater(self.engine.results.answer, MISSING, out=self._idle)
            np.logical_and(self._idle, self.engine.results.settled, out=self._idle)
            np.copyto(self._arrived, self._idle)
            np.copyto(self._newest, self._searched, where=self._idle)

    def _run_by_means(self, left: Floats, budget: float | None) -> None:
        """Answer readings less their rest; of what rests, by their mean."""
        means = self._means
        np.greater(self._kept.patches["answer"], IDLE, out=self._hot)
        means.take(left, self._given, self._arrived, self._newest, self._hot)
        self._kernel.doubt_neighbours(
            self._lacking,
            self._arrived,
            self._plane,
            self._binding.starts,
            self.model_config.layer.thickness,
            means.noise_std,
        )
        self.engine.run(means.values, self._given, means.noise_std, budget=budget)

    def _take(self, channels: Channels, now_ns: int) -> int:
        """Read the newest counts of all taxels; how many patches have new ones."""
        read = channels.counts, channels.stamp_ns, channels.status, channels.fresh
        patience = min(self.stale_ns // HALF_INTERVAL, MOST_PATIENCE_NS)
        when = now_ns - self.stale_ns, now_ns, patience
        known: tuple[Any, ...] = (*read, *self._calibrated, *when, *self._conditioned)
        return int(self._kernel.condition(self._binding.channel, *known))

    def _smooth(self, channels: Channels) -> None:
        """Low-pass of what was read; see `update_kernel.smooth`."""
        read = self._binding.channel, channels.stamp_ns, self._valid, self._given
        memory = self._values, self._smoothed, self._smoothed_ns
        self._kernel.smooth(*read, self.stale_ns, self._smoothing, *memory)

    def _attend(self, patch: int, *corners: float) -> None:
        """Have what presses in a window come first, by the contacts of the newest answers."""
        rows = self._kept.contacts[patch]
        count = min(int(self._kept.patches["contacts"][patch]), len(rows))
        first = patch if self._kernel.presses_within(rows, count, *corners) else None
        if first != self._first:
            self._first = first
            prefer(self.engine, self._finest, first)

    def _take_answers(self, now_ns: int, fresh: bool) -> None:
        """Keep answers of new readings, or those that are done now, and drop what is too old."""
        results, kept = self.engine.results, self._kept
        answers = results.answer, results.rung, results.gap, results.iterations, results.invalid
        when = now_ns, now_ns - KEEPS * self.stale_ns
        count = self._kernel.take_over(
            self._arrived,
            self._newest,
            *answers,
            results.settled,
            self._sides,
            self._means.readings,
            self.engine.searches,
            *when,
            kept.patches,
            self._contacts.followed,
            self._touched,
            self._unended_ns,
        )
        for patch in self._touched[:count].tolist():
            rows = kept.contacts[patch]
            if results.answer[patch] > IDLE:
                pressure = results.pressure_of(patch)
                kept.pressure[patch, : len(pressure)] = pressure
            ended = results.settled[patch]  # else what was not found yet would be drift
            if self._follows and fresh and ended and results.answer[patch] == FOUND:
                its = slice(*self._binding.starts[patch : patch + 2])
                known = self._given[its], int(self._newest[patch]), *results.explained_of(patch)
                self._drift.learn(*known, patch)
            found = self._contacts.find(patch, int(self._newest[patch]), rows)
            count = min(found, len(rows))
            if self._threshold:
                words = self._kept_words[patch], CONTACT_WORDS
                count = int(self._kernel.drop_weak(rows, *words, count, self._threshold))
            kept.patches["contacts"][patch] = count

    def _publish(self, channels: Channels, slot: CycleSlot) -> None:
        """Copy what is kept into the slot."""
        kept = self._kept
        known = kept.patches, self._kept_words, kept.pressure, CONTACT_WORDS
        read = self._binding.channel, channels.counts, self._values, self._valid
        rows = slot.patches, slot.contact_words, slot.pressure
        self._kernel.copy_out(*known, *read, *rows, slot.counts, slot.values, slot.valid)

    def _rehearse(self) -> None:
        """Load what is compiled, and know nothing afterwards."""
        channels, slot = Channels(self._binding.channels), CycleSlot.empty(self.sizes)
        channels.counts[:] = 0.0
        channels.fresh[:] = 1
        before = int(self.tracks[0])
        self.answer(channels, self.stale_ns, slot, reset=True)
        self.answer(channels, self.stale_ns, slot)
        self._smooth(channels)
        rows, words = self._kept.contacts[0], self._kept_words[0]
        self._kernel.drop_weak(rows, words, CONTACT_WORDS, 0, 0.0)
        self._kernel.presses_within(rows, 0, 0.0, 0.0, 0.0, 0.0)
        self.forget()
        self.tracks[0] = before

    def forget(self) -> None:
        """Know of no reading and no contact."""
        self.engine.reset()
        self._means.reset()
        self._drift.reset()
        self._creep.reset()
        self._smoothed_ns[:] = 0
        self._unended_ns[:] = 0
        self._kept.patches[:] = np.zeros(1, PATCH)
        go_on_from(self._kept, self._contacts)
        self.tracks[0] = 0


def _clamps(board: Convention) -> tuple[float, float]:
    """Counts at or beyond which nothing is told; a scale that starts at rest has none there."""
    lowest = np.array([board.lowest])
    low = board.lowest if board.saturated(lowest)[0] else board.lowest - 1.0
    return float(low), float(board.highest)
