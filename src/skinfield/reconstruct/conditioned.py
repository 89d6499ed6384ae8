"""Conditioned recordings: readings in the quantity that a reconstruction takes."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import Layer, Quantity
from skinfield.errors import Floats, InputError
from skinfield.reconstruct.diagnostics import Conditioning, survey
from skinfield.signal import NoFilter, filtered
from skinfield.skin import Patch
from skinfield.skin.reading import Recording


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
    found = survey(lambda: iter([recording]), patch, layer, quantity, how)
    values, impossible = found.conditioner.counted(recording.counts)
    if not isinstance(how.filter, NoFilter):
        values = filtered(how.filter, values, found.rate)
    notes = (*recording.notes, *found.notes, *impossible_note(impossible, quantity))
    return Conditioned(values, found.noise_std, recording, notes)


def impossible_note(count: int, quantity: Quantity) -> tuple[str, ...]:
    """A sentence on values that no skin reads, if there are some."""
    if not count:
        return ()
    return (
        f"{count} values are {quantity.lowest:g} or less, which no skin reads: "
        "invalid; check gain and baseline",
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
