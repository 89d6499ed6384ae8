"""Diagnostics of a recording: whose counts, which faults, how much noise; counts to readings."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from skinfield.elastic import BaseStress, Capacitance, Gap, Layer, Quantity
from skinfield.errors import Floats, InputError, check_positive
from skinfield.signal import (
    Baseline,
    Calibration,
    Convention,
    CySkinCount,
    Faults,
    Filter,
    ICubByte,
    NoFilter,
    PlainCount,
    estimate_baseline,
    filtered,
    find_faults,
    strain_from_relative_capacitance,
    valid_from_counts,
)
from skinfield.signal.faults import merged_faults, rows_text, taxel_rows
from skinfield.signal.noise import Neighbours, draw_in_jumps
from skinfield.skin import Patch
from skinfield.skin.reading import Recording


@dataclass(frozen=True, kw_only=True)
class Conditioning:
    """How counts become a quantity.

    Parameters
    ----------
    board : Convention, optional
        What a count means; default by the range of the counts.
    gain : float, counts per unit of ΔC/C₀, optional
        Default a guess for the board.
    calibration : Calibration, optional
        Per taxel; takes the place of both.
    filter : Filter
        Over time, before the reconstruction.
    noise_std : float, in the quantity's unit, optional
        Default as measured in the recording's quietest stretch.
    tare : pair of float, s, optional
        From when to when after the first reading nothing touched: rest is what taxels read then.
    keep, without : tuple of int
        Rows of taxels to use, or to leave out, whatever is found faulty.
    """

    board: Convention | None = None
    gain: float | None = None
    calibration: Calibration | None = None
    filter: Filter = field(default_factory=NoFilter)
    noise_std: float | None = None
    tare: tuple[float, float] | None = None
    keep: tuple[int, ...] = ()
    without: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if self.noise_std is not None:
            check_positive("noise_std", self.noise_std, "no reading is exact")
        if self.gain is not None and not (np.isfinite(self.gain) and self.gain):
            raise InputError(
                f"gain is {self.gain!r}, expected a finite number other than 0: counts per unit "
                "of ΔC/C₀, negative where pressure lowers them"
            )


@dataclass(frozen=True, eq=False)
class Conditioner:
    """What turns recorded numbers into readings in a quantity's unit.

    Attributes
    ----------
    quantity : Quantity
    layer : Layer
    calibration : Calibration, optional
        Of counts; without it the numbers are in the quantity's unit already.
    board : Convention, optional
        That sent the counts.
    without : tuple of int
        Taxels without a calibration that are left out.
    neighbours : (P, 2) int array, optional
        Pairs of taxels, by which those of boards that clip at rest are known to jump.
    """

    quantity: Quantity
    layer: Layer
    calibration: Calibration | None = None
    board: Convention | None = None
    without: tuple[int, ...] = ()
    neighbours: Neighbours | None = None

    def __call__(self, counts: Floats) -> Floats:
        """Readings (T, L) from counts (T, L); NaN where invalid."""
        return self.counted(counts)[0]

    def counted(self, counts: Floats) -> tuple[Floats, int]:
        """Readings, and how many of them no skin reads: those are invalid, too."""
        values = self._values(counts)
        if self.neighbours is not None and self.calibration is not None:
            noise = self.noise_in_quantity(self.calibration.quantity_std())
            draw_in_jumps(values, noise, self.neighbours)
        impossible = (values <= self.quantity.lowest) | (values >= self.quantity.highest)
        count = int(impossible.sum())
        return (np.where(impossible, np.nan, values) if count else values), count

    def _values(self, counts: Floats) -> Floats:
        if self.calibration is None:
            if self.without:
                counts = counts.copy()
                counts[:, self.without] = np.nan
            return counts
        if not np.isfinite(counts).any():
            return np.full(counts.shape, np.nan)
        change = self.calibration.relative_capacitance_from_counts(counts)
        valid = valid_from_counts(counts, self.board, alive=self.calibration.alive)
        return self.in_quantity(np.where(valid, change, np.nan))

    def in_quantity(self, change: Floats) -> Floats:
        """ΔC/C₀ as the quantity, each taxel by itself."""
        strains, factor = quantity_scale(self.quantity, self.layer)
        return strain_from_relative_capacitance(change) * factor if strains else change

    def noise_in_quantity(self, noise: Floats) -> Floats:
        """Noise of ΔC/C₀ as that of the quantity, for small readings."""
        return noise * quantity_scale(self.quantity, self.layer)[1]


def quantity_scale(quantity: Quantity, layer: Layer, unit: str = "dC/C0") -> tuple[bool, float]:
    """Whether a quantity is of the strain that ΔC/C₀ is of, and how many times that.

    Readings in a unit of their own, which must be the quantity's, are taken as they are.

    Raises
    ------
    InputError
        For another quantity.
    """
    if unit in ("count", "dC/C0"):
        if isinstance(quantity, Capacitance):
            return False, 1.0
        if isinstance(quantity, Gap | BaseStress):
            return True, layer.young_modulus if isinstance(quantity, BaseStress) else 1.0
    elif isinstance(quantity, UNIT_OF[unit]):
        return False, 1.0
    raise InputError(
        f"quantity is {type(quantity).__name__}(), readings are in {unit!r}: expected "
        "Capacitance(), Gap() or BaseStress() for counts, or the quantity of the readings' own unit"
    )


Blocks = Callable[[], Iterator[Recording]]  # anew at each call
USUAL_RATE = 50.0  # 1/s, of recordings that do not tell theirs
SLOWEST = 0.25  # 1/s: slower ones have their times in another unit
FEWEST = 16  # readings that tell a noise
UNIT_OF = {"dC/C0": Capacitance, "Pa": BaseStress, "1": Gap}


@dataclass(frozen=True, eq=False)
class Survey:
    """What is known of a recording before any of its readings is conditioned.

    Attributes
    ----------
    conditioner : Conditioner
    noise_std : (L,) array
        Of one reading in the quantity's unit, after the filter.
    rate : float, 1/s
    notes : tuple of str
    """

    conditioner: Conditioner
    noise_std: Floats
    rate: float
    notes: tuple[str, ...]


def survey(
    blocks: Blocks, patch: Patch, layer: Layer, quantity: Quantity, how: Conditioning
) -> Survey:
    """Look at all readings, block by block.

    What needs many readings at once (the quietest stretch, faults) is found in each block and put
    together; a recording of one block is looked at as a whole.

    Parameters
    ----------
    blocks : callable
        Each call gives an iterator over the blocks of the recording, in the order of the taxels.
    patch, layer, quantity, how
        See `condition`.

    Raises
    ------
    InputError
        If recording and quantity do not go together.
    """
    first = next(blocks())
    rates = [block.rate for block in blocks() if np.isfinite(block.rate)]
    rate = float(np.median(rates)) if rates else USUAL_RATE
    if rate < SLOWEST:
        raise InputError(
            f"readings of {first.source} are {1.0 / rate:g} s apart, expected {1.0 / SLOWEST:g} s "
            "at most, as of a skin: if these are milliseconds, name their column time_ms"
        )
    readings = sum(map(len, blocks()))
    if first.unit != "count":
        _check_unit(first, quantity)
        out = tuple(int(row) for row in taxel_rows("without", how.without, len(patch)))
        own = how.calibration if first.unit == "dC/C0" else None
        if how.calibration is not None and (own is None or own.unit == "count"):
            raise InputError(
                f"{first.source} holds {first.unit} already and the calibration is of "
                f"{how.calibration.unit}, expected counts, or a calibration of ΔC/C₀ such as "
                "skinfield calibrate touch makes of such a recording"
            )
        noise, _, notes = _noise(blocks, None, rate, patch)
        if out:
            notes += (f"left out as asked: {rows_text(np.array(out))}",)
        if own is not None:
            own = own.without(np.isin(np.arange(len(patch)), out))
            noise = own.quantity_std()
        elif how.board is not None or how.gain is not None:
            notes += (f"in {first.unit} already: board and gain are not used",)
        conditioner = Conditioner(quantity, layer, own, without=out)
    else:
        conditioner, noise, notes = _of_counts(blocks, patch, layer, quantity, how, rate)
    notes += order_note(first.counts, patch)
    if how.noise_std is not None:
        noise = np.full(len(patch), how.noise_std)
    if not isinstance(how.filter, NoFilter):
        noise = noise * how.filter.noise_factor(rate)
        notes += (f"filtered, {how.filter.delay(rate) * 1e3:.0f} ms behind",)
    measured = noise[np.isfinite(noise) & (noise > 0)]
    typical = float(np.median(measured)) if len(measured) else quantity.typical_noise
    if readings >= FEWEST and not len(measured):
        notes += (f"the readings hold no noise: a typical one, {typical:g}, is taken",)
    noise = np.where(np.isfinite(noise) & (noise > 0.2 * typical), noise, typical)
    return Survey(conditioner, noise, rate, notes)


def condition(
    recording: Recording, patch: Patch, layer: Layer, quantity: Quantity, how: Conditioning
) -> tuple[Floats, Survey]:
    """Readings (T, L) of a recording in a quantity's unit, NaN where invalid; what is known of it.

    Parameters
    ----------
    recording : Recording
        Of (T, L) counts in the order of the patch's taxels, or of values in a unit of their own.
    patch, layer : Patch, Layer
    quantity : Quantity
        What the reconstruction takes; a recording with a unit must hold that quantity.
    how : Conditioning

    Raises
    ------
    InputError
        If recording and quantity do not go together.
    """
    found = survey(lambda: iter([recording]), patch, layer, quantity, how)
    values, impossible = found.conditioner.counted(recording.counts)
    if not isinstance(how.filter, NoFilter):
        values = filtered(how.filter, values, found.rate)
    notes = (*recording.notes, *found.notes, *impossible_note(impossible, quantity))
    return values, replace(found, notes=notes)


def impossible_note(count: int, quantity: Quantity) -> tuple[str, ...]:
    """A sentence on values that no skin reads, if there are some."""
    if not count:
        return ()
    return (
        f"{count} values are not between {quantity.lowest:g} and {quantity.highest:g}, which no "
        "skin reads: invalid; check gain and baseline",
    )


def untouched(recording: Recording, how: Conditioning) -> bool:
    """Whether some stretch of a recording makes a baseline, as far as its board tells.

    It does where nothing moves and no taxel rests on the pressed side of the board's rest, but for
    those at the clamp, which are not heard. Where no baseline is measured (a calibration is there,
    the board takes it off, or the numbers are no counts) there is nothing to wait for.
    """
    if recording.unit != "count" or (how.calibration is not None and how.tare is None):
        return True
    board = how.board if how.board is not None else _board_of(lambda: iter([recording]))[0]
    if isinstance(board, CySkinCount) or len(recording) < FEWEST:
        return True
    rate = recording.rate if np.isfinite(recording.rate) else USUAL_RATE
    found = estimate_baseline(recording.counts, rate, convention=board)
    with np.errstate(invalid="ignore"):
        heard = ~board.saturated(np.rint(found.baseline))
    return found.stretch.still and not (found.loaded & heard).any()


def _check_unit(recording: Recording, quantity: Quantity) -> None:
    expected = UNIT_OF[recording.unit]
    if not isinstance(quantity, expected):
        raise InputError(
            f"{recording.source} is in {recording.unit!r}, expected a quantity of "
            f"{expected.__name__}(), got {type(quantity).__name__}(): a reading means what "
            "its file says"
        )


def _of_counts(
    blocks: Blocks, patch: Patch, layer: Layer, quantity: Quantity, how: Conditioning, rate: float
) -> tuple[Conditioner, Floats, tuple[str, ...]]:
    if how.calibration is not None and how.calibration.unit != "count":
        raise InputError(
            f"calibration is of readings ({how.calibration.basis}), the recording is of counts, "
            "expected one of counts: make it of a recording in counts of the same boards"
        )
    board, notes = (how.board, ()) if how.board is not None else _board_of(blocks)
    faults = _faults(blocks, patch, board, how.calibration).chosen(how.keep, how.without)
    notes += faults.sentences
    calibration = how.calibration
    if calibration is None:
        gain = how.gain
        if gain is None:
            gain = board.usual_gain
            notes += (
                f"gain not given: {gain:g} counts per unit of ΔC/C₀ is a guess, and every force "
                "scales with it; loads that are known give the true one",
            )
        resting = blocks if how.tare is None else _stretch(blocks, *how.tare)
        noise, baseline, said = _noise(resting, board, rate, patch)
        notes += said
        if baseline is not None and (how.tare is not None or _measures(board, baseline)):
            calibration = Calibration.from_baseline(
                patch, baseline, gain=gain, alive=faults.usable, even_if_loaded=True
            )
        else:
            step = np.maximum(np.nan_to_num(noise), 12**-0.5)  # at least a count's own
            calibration = Calibration.from_convention(
                patch, board, gain=gain, noise_std=step, alive=faults.usable
            )
    else:
        calibration = calibration.without(~faults.usable)
        if how.tare is not None:
            _, found, said = _noise(_stretch(blocks, *how.tare), board, rate, patch)
            notes += said
            if found is not None:
                rest = np.where(found.measured, found.baseline, calibration.baseline)
                calibration = replace(calibration, baseline=rest)
    near = patch.neighbours if isinstance(board, CySkinCount) else None
    conditioner = Conditioner(quantity, layer, calibration, board, neighbours=near)
    return conditioner, conditioner.noise_in_quantity(calibration.quantity_std()), notes


def _stretch(blocks: Blocks, begin: float, end: float) -> Blocks:
    """The readings from one time to another, s after the first."""
    origin = int(next(blocks()).stamp_ns[0])

    def parts() -> Iterator[Recording]:
        none = True
        for block in blocks():
            seconds = (block.stamp_ns - origin) * 1e-9
            inside = (seconds >= begin) & (seconds <= end)
            if inside.any():
                none = False
                yield replace(block, stamp_ns=block.stamp_ns[inside], counts=block.counts[inside])
        if none:
            raise InputError(
                f"tare is {begin:g},{end:g} s, expected a part of the recording: no reading lies "
                "between"
            )

    return parts


def _measures(board: Convention, baseline: Baseline) -> bool:
    """Whether a baseline is better than the rest by convention, if there is one."""
    if not np.isfinite(board.rest):
        return True
    return baseline.quiet or isinstance(board, CySkinCount)


def _faults(
    blocks: Blocks, patch: Patch, board: Convention, calibration: Calibration | None
) -> Faults:
    """Of every block with a number in it, put together."""
    found: list[Faults] = []
    lengths: list[int] = []
    for block in blocks():
        if len(block) < FEWEST and found:  # the rest of a long recording tells nothing
            continue
        if np.isnan(block.counts).all() and (found or len(block) < FEWEST):
            continue
        found.append(find_faults(block.counts, patch, board, calibration=calibration))
        lengths.append(len(block))
    if not found:  # whatever there is, or a word on what there is not
        return find_faults(next(blocks()).counts, patch, board, calibration=calibration)
    return merged_faults(found, lengths)


def _noise(
    blocks: Blocks, board: Convention | None, rate: float, patch: Patch
) -> tuple[Floats, Baseline | None, tuple[str, ...]]:
    """Noise of one reading (L,), NaN where it cannot be told; the baseline it belongs to; notes."""
    best: tuple[Baseline, int] | None = None
    before, first = 0, next(blocks())
    for block in blocks():
        enough = len(block) >= FEWEST and not (before and np.isnan(block.counts).all())
        if enough:
            on = f", {before} readings on" if before else ""
            found = estimate_baseline(
                block.counts,
                rate,
                convention=board,
                source=block.source + on,
                neighbours=patch.neighbours,
            )
            if best is None or _rank(found, board) < _rank(best[0], board):
                best = found, before
        before += len(block)
    if best is None:
        note = f"{before} readings are too few to measure their noise: a typical one is taken"
        return np.full(first.counts.shape[1], np.nan), None, (note,)
    baseline, start = best
    notes = baseline.notes
    if start:
        notes = tuple(f"from reading {start} on: {note}" for note in notes)
    return baseline.noise_std, baseline, notes


def _rank(baseline: Baseline, board: Convention | None) -> tuple[bool, float, float]:
    """By which the best of many stretches is chosen: still, then least loaded, then stillest."""
    stretch = baseline.stretch
    if stretch.still and board is not None:
        load = board.direction * float(np.nanmean(baseline.baseline))
        return False, load, stretch.ratio
    return not stretch.still, float(stretch.moving.sum()), stretch.ratio


def _board_of(blocks: Blocks) -> tuple[Convention, tuple[str, ...]]:
    """Guess the board by the range of its counts, and say so.

    CySkin's boards clip at their rest, so that taxels which nothing touches read 0 again and again.
    Words of which most taxels never read 0 are of a board that rests elsewhere; too few readings
    do not tell.
    """
    least, highest, readings = np.full(next(blocks()).counts.shape[1], np.inf), -np.inf, 0
    for block in blocks():
        there = ~np.isnan(block.counts)
        np.fmin(least, np.min(block.counts, axis=0, initial=np.inf, where=there), out=least)
        highest = max(highest, float(np.max(block.counts, initial=-np.inf, where=there)))
        readings += len(block)
    lowest = float(least.min())
    if lowest >= 0 and highest <= 255:
        said = f"counts from {lowest:g} to {highest:g}: taken as iCub bytes that rest at 240"
        return ICubByte(), (said,)
    words = lowest >= 0 and highest <= 65535
    if words and readings >= FEWEST and np.median(least[np.isfinite(least)]) > 0.0:
        said = f"counts from {lowest:g} to {highest:g}, most never 0: each taxel has its own rest"
        return PlainCount(), (said,)
    if words:
        said = f"counts from {lowest:g} to {highest:g}: taken as CySkin counts that rest at 0"
        return CySkinCount(), (said,)
    raise InputError(
        f"counts range from {lowest:g} to {highest:g}, expected 0 to 255 (iCub) or 0 to 65535 "
        "(16 bits): say which board sent them (--board), or give a calibration (--calibration)"
    )


READINGS = 1000  # that are looked at: those in which most is read
PART = 0.34  # of the taxels: readings in which more are touched tell no order
TOGETHER = 0.7  # correlation of taxels that read together
TELL_ORDER = 30  # taxels that read together with another, and readings, by which an order is judged
NEAR = 2.5  # distances of taxels, within which they are read side by side
LEAST = 2.5  # times more partners side by side than in any order


def partners(counts: Floats, patch: Patch) -> tuple[int, float, float]:
    """Taxels with a partner, and the share of these nearby, as it is and in any order.

    A partner is the taxel that reads most alike, of the same touches.

    Parameters
    ----------
    counts : (T, L) array
        NaN where a taxel did not answer.
    patch : Patch
    """
    from scipy.spatial import cKDTree

    known = np.where(np.isnan(counts).all(axis=0), 0.0, counts)
    apart = np.nan_to_num(np.abs(known - np.nanmedian(known, axis=0)))
    most = apart[np.argsort(-apart.sum(axis=1), kind="stable")[:READINGS]]
    noise = 1.4826 * np.median(apart, axis=0) + 0.05 * float(np.max(most, initial=0.0))
    stands = most > 5.0 * noise
    part = stands.mean(axis=1)
    most = most[(part > 0.0) & (part < PART)]
    touched = np.flatnonzero(stands[(part > 0.0) & (part < PART)].any(axis=0))
    if min(touched.size, len(most)) < TELL_ORDER:
        return 0, 0.0, 0.0
    values = most[:, touched] - most[:, touched].mean(axis=0)
    left, sizes, right = np.linalg.svd(values, full_matrices=False)
    values = values - sizes[0] * np.outer(left[:, 0], right[0])  # what all read together
    spread = np.maximum(np.linalg.norm(values, axis=0), 1e-12)
    alike = (values.T @ values) / np.outer(spread, spread)
    np.fill_diagonal(alike, -1.0)
    other, sure = alike.argmax(axis=1), alike.max(axis=1) > TOGETHER
    places = patch.positions[touched]
    near = np.linalg.norm(places - places[other], axis=1)[sure] < NEAR * patch.pitch
    pairs = len(cKDTree(places).query_pairs(NEAR * patch.pitch))
    chance = pairs / (0.5 * len(touched) * (len(touched) - 1))
    return int(sure.sum()), float(near.mean()) if sure.any() else 0.0, chance


def order_note(counts: Floats, patch: Patch) -> tuple[str, ...]:
    """A sentence where taxels that read together lie anywhere on the patch.

    What touches a skin is read by taxels side by side. Where the taxels that go up and down
    together lie anywhere, the layout is another skin's, or the columns are in another order.
    """
    count, near, chance = partners(counts, patch)
    if not (count >= TELL_ORDER and near < LEAST * chance < 0.5):
        return ()
    return (
        f"of {count} taxels that read together with another, {100 * near:.0f} % lie side by side "
        f"on {patch.name!r}, as {100 * chance:.0f} % do in any order: is it the layout of the "
        "recording's skin, with its taxels in the recording's order?",
    )
