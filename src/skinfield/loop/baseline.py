"""Baseline and noise of all taxels, from the first readings of an untouched skin."""

import time
import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, Ints
from skinfield.loop.model_config import Binding
from skinfield.loop.settings import LiveSettings
from skinfield.reconstruct.diagnostics import Conditioning, survey, untouched
from skinfield.signal import Calibration, Channels
from skinfield.skin import Patch
from skinfield.skin.reading import Recording

LEAST = 100  # readings that make a baseline
MOST = 2000  # that are kept
SHARE = 0.9  # of the channels that ever answered: so many new ones make a further reading
SLOWEST = 0.2  # s after which whatever came is taken for a reading
PATIENCE = 10.0  # times the asked time, after which fewer readings, or touched ones, must do
LOOK = 0.2  # s between looks whether the skin is untouched
SHARE_OF_LOOKS = 0.1  # of the time, at most, that they may take
USUAL = 5.0  # times the longest usual interval of a taxel: its reading is then too old
TOGETHER = 50  # readings of the median taxel that go into the noise of each
TOUCHED, FEWEST = 8.0, 30  # deviations of what a touch reads; readings without that are enough
OUTLIER = 3.0  # standard deviations beyond which a count is drawn in
YOUNGEST = 0.05  # s, at which no reading is too old


@dataclass(frozen=True, eq=False)
class TareBaseline:
    """What a tare found, for the taxels of all patches in the skin's order.

    Attributes
    ----------
    calibration : (L, 4) array
        Baseline and gain (counts, counts per unit of ΔC/C₀), noise_std (counts), alive (0 or 1);
        of readings that are no counts: 0, 1 or a calibration's gain, the noise, and alive.
    noise_std : (L,) array
        In the quantity's unit.
    stale_ns : int, ns
        Age at which a reading is too old.
    notes : tuple of str
        What was assumed and found, in sentences.
    """

    calibration: Floats
    noise_std: Floats
    stale_ns: int
    notes: tuple[str, ...] = ()


class BaselineCollector:
    """Collects readings until they make a baseline.

    Something that lies on the skin meanwhile would be part of it: a taxel that is let go later
    reads less than nothing then, which only ten times the force around it would explain. So it goes
    on for up to `PATIENCE` times the asked time, until there is a stretch without. The rest of a
    calibration stays, unless it is to be measured `anew`.
    """

    def __init__(self, settings: LiveSettings, binding: Binding, *, anew: bool = False) -> None:
        self._settings, self._binding = settings, binding
        starts = binding.starts.tolist()
        self._how = [
            _how(patch, settings, start, anew)
            for patch, start in zip(settings.skin, starts, strict=False)
        ]
        self._rows: Floats = np.full((MOST, len(binding.channel)), np.nan)
        self._stamps: Ints = np.zeros(MOST, np.int64)
        self._seen = np.zeros(binding.channels, np.bool_)
        self._ever = np.zeros(binding.channels, np.bool_)
        self._newest: Ints = np.zeros(binding.channels, np.int64)
        self._began = self._last = self._filled = 0
        self._look = 0  # ns: when to look again

    def skip(self, channels: Channels) -> None:
        """Leave out what is there already."""
        np.copyto(self._newest, channels.stamp_ns)

    def take(self, channels: Channels, now_ns: int) -> bool:
        """Take what is new; whether there is enough, of an untouched skin."""
        settings, fresh = self._settings, channels.stamp_ns > self._newest
        np.copyto(self._newest, channels.stamp_ns)
        self._seen |= fresh
        self._ever |= fresh
        if not self._ever.any():
            return False
        self._began = self._began or now_ns
        self._last = self._last or now_ns
        whole = self._seen.sum() >= SHARE * self._ever.sum()
        if (whole or now_ns - self._last > SLOWEST * 1e9) and self._seen.any():
            row = np.where(self._seen, channels.counts, np.nan)[self._binding.channel]
            place = self._filled % MOST
            self._rows[place], self._stamps[place] = row, now_ns
            self._filled += 1
            self._seen[:] = False
            self._last = now_ns
        seconds = (now_ns - self._began) * 1e-9
        if seconds < settings.tare_seconds:
            return False
        if seconds > PATIENCE * settings.tare_seconds:
            return True
        return self._filled >= LEAST and now_ns >= self._look and self._untouched(now_ns)

    def _untouched(self, now_ns: int) -> bool:
        """Whether every patch was untouched for a while; sets when to look again."""
        began = time.monotonic()
        stamps, rows = self._collected()
        found = all(
            np.isnan(its.counts).all() or untouched(its, how)
            for its, how in zip(self._parts(stamps, rows), self._how, strict=True)
        )
        pause = max(LOOK, (time.monotonic() - began) / SHARE_OF_LOOKS)
        self._look = now_ns + int(pause * 1e9)
        return found

    def _collected(self) -> tuple[Ints, Floats]:
        """Stamps (T,) and readings (T, L), the oldest first."""
        order = np.argsort(self._stamps[: min(self._filled, MOST)], kind="stable")
        return self._stamps[order], self._rows[order]

    def _parts(self, stamps: Ints, rows: Floats) -> list[Recording]:
        """Of each patch."""
        starts = self._binding.starts.tolist()
        return [
            Recording(stamps, rows[:, a:b], unit=self._binding.unit, source=patch.name)
            for patch, a, b in zip(self._settings.skin, starts, starts[1:], strict=False)
        ]

    def finish(self) -> TareBaseline:
        """Baseline, noise and the age at which a reading is too old.

        Raises
        ------
        InputError
            If nothing came, or the counts are none that are known.
        """
        settings, binding = self._settings, self._binding
        stamps, rows = self._collected()
        if not len(rows):
            raise InputError("no reading came while the baseline was taken, expected some")
        table, noise = np.zeros((len(binding.channel), 4)), np.zeros(len(binding.channel))
        notes: list[str] = []
        parts = zip(settings.skin, self._parts(stamps, rows), self._how, strict=True)
        for place, (patch, recording, how) in enumerate(parts):
            its = slice(int(binding.starts[place]), int(binding.starts[place + 1]))
            table[its], noise[its], said = _patch_baseline(patch, recording, settings, how)
            notes += [f"{patch.name}: {note}" for note in said]
        return TareBaseline(table, noise, self._stale_ns(stamps), tuple(notes))

    def _stale_ns(self, stamps: Ints) -> int:
        if self._settings.stale_after is not None:
            return int(self._settings.stale_after * 1e9)
        usual = float(np.percentile(np.diff(stamps), 95)) if len(stamps) > 1 else 1e9
        return int(max(USUAL * usual, YOUNGEST * 1e9))


def _how(patch: Patch, settings: LiveSettings, start: int, anew: bool) -> Conditioning:
    """How counts of a patch are taken, whose taxels begin at `start`."""
    keep, without = (
        tuple(row - start for row in rows if 0 <= row - start < len(patch))
        for rows in (settings.keep, settings.without)
    )
    known = settings.calibration.get(patch.name)
    return Conditioning(
        board=settings.board,
        gain=settings.gain,
        calibration=known,
        keep=keep,
        without=without,
        tare=(0.0, np.inf) if anew and known is not None else None,
    )


def _patch_baseline(
    patch: Patch, recording: Recording, settings: LiveSettings, how: Conditioning
) -> tuple[Floats, Floats, tuple[str, ...]]:
    """Calibration (L, 4) and noise (L,) of one patch, and notes."""
    table = np.zeros((len(patch), 4))
    table[:, 1] = 1.0
    answered = ~np.isnan(recording.counts).all(axis=0)
    if not answered.any():
        table[:, 2] = 1.0
        noise = np.full(len(patch), settings.quantity.typical_noise)
        return table, noise, ("no taxel answered while the baseline was taken: all are left out",)
    found = survey(lambda: iter([recording]), patch, settings.layer, settings.quantity, how)
    known = found.conditioner.calibration
    if known is None:
        table[:, 2], table[:, 3] = found.noise_std, answered
        table[list(how.without), 3] = 0.0
        return table, found.noise_std, found.notes
    baseline, noise = known.baseline, known.noise_std
    if how.calibration is None or how.tare is not None:
        baseline, noise = unrounded(recording.counts, known)
    columns = np.column_stack([baseline, known.gain, noise, known.alive])
    table[known.alive] = columns[known.alive]
    wider = np.divide(noise, known.noise_std, out=np.ones_like(noise), where=known.alive)
    return table, found.noise_std * wider, found.notes


def unrounded(counts: Floats, known: Calibration) -> tuple[Floats, Floats]:
    """Mean and noise (L,) of counts that a board rounds, from about their median.

    Where a taxel rests between two counts, the median is up to half a count off, and always to the
    same side: neighbours that are off alike would be taken for a light touch. Only where the mean
    is within a count of the baseline; elsewhere something else is the matter. Readings in which any
    taxel is touched do not count, as its neighbours read a little less then.
    """
    with np.errstate(invalid="ignore"):
        off = np.abs(counts - known.baseline) > 1.0 + TOUCHED * known.noise_std
    untouched_rows = ~(off & known.alive).any(axis=1)
    if np.count_nonzero(untouched_rows) >= FEWEST:
        counts = counts[untouched_rows]
    with np.errstate(invalid="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of taxels that never answered
        reach = 1.0 + OUTLIER * known.noise_std
        near = np.clip(counts, known.baseline - reach, known.baseline + reach)
        mean, spread = np.nanmean(near, axis=0), np.nanstd(near, axis=0)
        close = known.alive & (np.abs(mean - known.baseline) <= 1.0)
    baseline = np.where(close, mean, known.baseline)
    noise = np.where(close, np.fmax(spread, known.noise_std), known.noise_std)
    return baseline, drawn_together(noise, known.alive, len(counts))


def drawn_together(noise: Floats, alive: NDArray[np.bool_], readings: int) -> Floats:
    """Noise of taxels of one kind from few readings: some would be too small by chance alone.

    The mean of the variances of one's own readings and of `TOGETHER` such as the median taxel has.
    """
    if not alive.any():
        return noise
    common = float(np.median(noise[alive]))
    weight = TOGETHER / (TOGETHER + readings)
    drawn = np.sqrt((1.0 - weight) * noise**2 + weight * max(common, 0.0) ** 2)
    return np.where(alive, drawn, noise)
