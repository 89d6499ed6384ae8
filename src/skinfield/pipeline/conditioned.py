"""From the readings of a recording to the quantity that a reconstruction takes."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from skinfield.conditioning import (
    Baseline,
    Calibration,
    Convention,
    CySkinCount,
    Filter,
    ICubByte,
    NoFilter,
    estimate_baseline,
    filtered,
    find_faults,
    strain_from_relative_capacitance,
    valid_from_counts,
)
from skinfield.errors import Floats, InputError, check_positive
from skinfield.layout import Patch
from skinfield.mechanics import Layer
from skinfield.observation import BaseStress, Capacitance, Gap, Quantity
from skinfield.reading import Recording

ICUB_GAIN = -171.0  # bytes per unit of ΔC/C₀: 16 pF over 65536 counts, shift 2, a pad of 0.17 pF
CYSKIN_GAIN = 20_000.0  # counts per unit of ΔC/C₀: a firm press reads 20 000; no maker's figure
FEWEST = 16  # readings that tell a noise
UNIT_OF = {"dC/C0": Capacitance, "Pa": BaseStress, "1": Gap}


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
    """

    board: Convention | None = None
    gain: float | None = None
    calibration: Calibration | None = None
    filter: Filter = field(default_factory=NoFilter)
    noise_std: float | None = None

    def __post_init__(self) -> None:
        if self.noise_std is not None:
            check_positive("noise_std", self.noise_std, "no reading is exact")
        if self.gain is not None and not (np.isfinite(self.gain) and self.gain):
            raise InputError(
                f"gain is {self.gain!r}, expected a finite number other than 0: counts per unit "
                "of ΔC/C₀, negative where pressure lowers them"
            )


@dataclass(frozen=True, eq=False)
class Conditioned:
    """Readings of a patch in a quantity's unit.

    Attributes
    ----------
    values : (T, L) array
        NaN where invalid.
    noise_std : (L,) array
        Of one reading, after the filter.
    recording : Recording
        Counts in the order of the taxels.
    notes : tuple of str
        What was assumed, found and left out.
    """

    values: Floats
    noise_std: Floats
    recording: Recording
    notes: tuple[str, ...]

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Which values are there, (T, L)."""
        return np.asarray(~np.isnan(self.values))


def condition(
    recording: Recording, patch: Patch, layer: Layer, quantity: Quantity, how: Conditioning
) -> Conditioned:
    """Turn the readings of a recording, in the order of the patch's taxels, into a quantity.

    Parameters
    ----------
    recording : Recording
        Of (T, L) counts, or of values in a unit of their own.
    patch, layer : Patch, Layer
    quantity : Quantity
        What the reconstruction takes; a recording with a unit must hold that quantity.
    how : Conditioning

    Raises
    ------
    InputError
        If recording and quantity do not go together, or there is too little to tell the noise.
    """
    if recording.unit != "count":
        expected = UNIT_OF[recording.unit]
        if not isinstance(quantity, expected):
            raise InputError(
                f"{recording.source} is in {recording.unit!r}, expected a quantity of "
                f"{expected.__name__}(), got {type(quantity).__name__}(): a reading means what "
                "its file says"
            )
        change, (noise, _, notes) = recording.counts, _noise(recording, None)
        if how.board is not None or how.gain is not None or how.calibration is not None:
            notes += (f"in {recording.unit} already: board, gain and calibration are not used",)
    else:
        change, noise, notes = _change_from_counts(recording, patch, how)
        change, noise = _in_quantity(change, noise, layer, quantity)
    impossible = change <= quantity.lowest
    if impossible.any():
        change = np.where(impossible, np.nan, change)
        notes += (
            f"{int(impossible.sum())} values are {quantity.lowest:g} or less, which no skin reads: "
            "invalid; check gain and baseline",
        )
    if how.noise_std is not None:
        noise = np.full(len(patch), how.noise_std)
    rate = recording.rate if np.isfinite(recording.rate) else 50.0
    if not isinstance(how.filter, NoFilter):
        change = filtered(how.filter, change, rate)
        noise = noise * how.filter.noise_factor(rate)
        notes += (f"filtered, {how.filter.delay(rate) * 1e3:.0f} ms behind",)
    measured = noise[np.isfinite(noise) & (noise > 0)]
    typical = float(np.median(measured)) if len(measured) else quantity.typical_noise
    if len(recording) >= FEWEST and not len(measured):
        notes += (f"the readings hold no noise: a typical one, {typical:g}, is taken",)
    noise = np.where(np.isfinite(noise) & (noise > 0.2 * typical), noise, typical)
    return Conditioned(change, noise, recording, recording.notes + notes)


def _change_from_counts(
    recording: Recording, patch: Patch, how: Conditioning
) -> tuple[Floats, Floats, tuple[str, ...]]:
    board, notes = (how.board, ()) if how.board is not None else _board_of(recording.counts)
    faults = find_faults(recording.counts, board, calibration=how.calibration)
    notes += faults.sentences
    calibration = how.calibration
    if calibration is None:
        gain = how.gain
        if gain is None:
            gain = ICUB_GAIN if isinstance(board, ICubByte) else CYSKIN_GAIN
            notes += (
                f"gain not given: {gain:g} counts per unit of ΔC/C₀ is a guess, and every force "
                "scales with it; loads that are known give the true one",
            )
        noise, baseline, said = _noise(recording, board)
        notes += said
        if baseline is not None and baseline.quiet and not isinstance(board, CySkinCount):
            calibration = Calibration.from_baseline(patch, baseline, gain=gain, alive=faults.usable)
        else:
            step = np.maximum(np.nan_to_num(noise), 12**-0.5)  # at least a count's own
            calibration = Calibration.from_convention(
                patch, board, gain=gain, noise_std=step, alive=faults.usable
            )
    else:
        calibration = calibration.without(~faults.usable)
    change = calibration.relative_capacitance_from_counts(recording.counts)
    valid = valid_from_counts(recording.counts, board, alive=calibration.alive)
    return np.where(valid, change, np.nan), calibration.quantity_std(), notes


def _noise(
    recording: Recording, board: Convention | None
) -> tuple[Floats, Baseline | None, tuple[str, ...]]:
    """Noise of one reading (L,), NaN where it cannot be told; the baseline it belongs to; notes."""
    if len(recording) < FEWEST:
        note = (
            f"{len(recording)} readings are too few to measure their noise: a typical one is taken"
        )
        return np.full(recording.counts.shape[1], np.nan), None, (note,)
    rate = recording.rate if np.isfinite(recording.rate) else 50.0
    baseline = estimate_baseline(recording.counts, rate, convention=board, source=recording.source)
    return baseline.noise_std, baseline, baseline.notes


def _board_of(counts: Floats) -> tuple[Convention, tuple[str, ...]]:
    """Guess the board by the range of its counts, and say so."""
    lowest, highest = float(np.nanmin(counts)), float(np.nanmax(counts))
    if lowest >= 0 and highest <= 255:
        said = f"counts from {lowest:g} to {highest:g}: taken as iCub bytes that rest at 240"
        return ICubByte(), (said,)
    if lowest >= 0 and highest <= 65535:
        said = f"counts from {lowest:g} to {highest:g}: taken as CySkin counts that rest at 0"
        return CySkinCount(), (said,)
    raise InputError(
        f"counts range from {lowest:g} to {highest:g}, expected 0 to 255 (iCub) or 0 to 65535 "
        "(CySkin): say which board sent them (--board), or give a calibration (--calibration)"
    )


def _in_quantity(
    change: Floats, noise: Floats, layer: Layer, quantity: Quantity
) -> tuple[Floats, Floats]:
    """ΔC/C₀ as the quantity, each taxel by itself."""
    if isinstance(quantity, Capacitance):
        return change, noise
    strain = strain_from_relative_capacitance(change)
    if isinstance(quantity, Gap):
        return strain, noise
    if isinstance(quantity, BaseStress):
        return strain * layer.young_modulus, noise * layer.young_modulus
    raise InputError(
        f"quantity is {type(quantity).__name__}, expected Capacitance(), Gap() or BaseStress(): "
        "give a recording in the quantity's own unit"
    )


def without_empty(conditioned: Conditioned) -> Conditioned:
    """Drop the readings in which no taxel is valid, and say how many there were."""
    kept = np.asarray(conditioned.valid.any(axis=1))
    if kept.all():
        return conditioned
    if not kept.any():
        raise InputError(
            f"{conditioned.recording.source} has no reading with a valid taxel, expected some: "
            "check the layout, the board's convention and the calibration"
        )
    recording = conditioned.recording
    shorter = replace(recording, stamp_ns=recording.stamp_ns[kept], counts=recording.counts[kept])
    note = f"{int((~kept).sum())} of {len(kept)} readings have no valid taxel: left out"
    return replace(
        conditioned,
        values=conditioned.values[kept],
        recording=shorter,
        notes=(*conditioned.notes, note),
    )
