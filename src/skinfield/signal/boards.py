"""Boards: what counts mean, the 8-bit iCub convention and the 16-bit CySkin one."""

from dataclasses import dataclass
from typing import Annotated, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, as_floats, check_count, check_positive
from skinfield.settings import Positive, Section

Bools = NDArray[np.bool_]


class Convention(Protocol):
    """How a maker's board codes what a taxel feels. `ICubByte`, `CySkinCount`, one's own."""

    @property
    def lowest(self) -> float:
        """Least count that can be sent."""
        ...

    @property
    def highest(self) -> float:
        """Largest count that can be sent."""
        ...

    @property
    def rest(self) -> float:
        """Count of an unloaded taxel by convention; NaN where there is none."""
        ...

    @property
    def direction(self) -> int:
        """Sign of the change of a count under pressure: -1 or +1."""
        ...

    @property
    def usual_gain(self) -> float:
        """Guess of the counts per unit of ΔC/C₀, where nothing was measured."""
        ...

    def saturated(self, counts: Floats) -> Bools:
        """Where a count is at a clamp and says only that the load is off the scale."""
        ...


@dataclass(frozen=True, kw_only=True)
class ICubByte:
    """One byte per taxel, about 240 at rest, lower under pressure, clamped at 0 and 255.

    Parameters
    ----------
    no_load : int, counts
        Byte of an unloaded taxel. A setting of the board: 240 on robots, 245 in the firmware's
        default, 244 in the viewer, 235 in older boards.
    shift : int
        The board drops so many low bits of the difference; 2 on robots.

    Notes
    -----
    With v = raw - base - drift, as the firmware of robotology computes it:
    255 if v <= -((255 - no_load) << shift); 0 if v >= no_load << shift;
    else no_load - (v >> shift), where >> rounds towards minus infinity.
    """

    no_load: int = 240
    shift: int = 2

    lowest = 0.0  # the clamp under high load
    highest = 255.0  # the clamp under far less load than at rest
    direction = -1  # pressure lowers the byte

    def __post_init__(self) -> None:
        why = "the byte of an unloaded taxel, 240 on most robots"
        check_count("no_load", self.no_load, 1, 254, why)
        check_count("shift", self.shift, 0, 15, "bits that the board drops, 2 on most robots")

    @property
    def rest(self) -> float:
        """The byte of an unloaded taxel."""
        return float(self.no_load)

    @property
    def usual_gain(self) -> float:
        """That of the pads of the paper: `gain` of 0.167 pF and 16 pF over 65536 counts."""
        return -171.0 * 2.0 ** (2 - self.shift)

    def saturated(self, counts: Floats) -> Bools:
        """Where a byte is at either clamp."""
        return np.asarray((counts <= self.lowest) | (counts >= self.highest))

    def counts_from_difference(self, difference: ArrayLike) -> Floats:
        """Bytes from the converter's differences v, whole converter counts; bit-exact."""
        v = as_floats("difference", difference)
        dropped = self.no_load - np.floor(v / (1 << self.shift))
        low_load, high_load = -((255 - self.no_load) << self.shift), self.no_load << self.shift
        byte = np.where(v <= low_load, 255.0, np.where(v >= high_load, 0.0, dropped))
        return np.asarray(np.where(np.isnan(v), np.nan, byte))

    def gain(self, rest_capacitance: float, farads_per_count: float) -> float:
        """Bytes per unit of ΔC/C₀, negative, for a pad of `rest_capacitance`, F.

        A first guess where nothing was measured: the converter of these boards (AD7147) spans
        about 16 pF with 65536 counts, 0.244 fF each and 20-25 % uncertain by its maker's word,
        so a pad of 0.167 pF moves -171 bytes per unit at shift 2. Known loads give the true one.
        """
        check_positive("rest_capacitance", rest_capacitance, "C₀ of the pad in farads")
        check_positive("farads_per_count", farads_per_count, "of the converter, before the shift")
        return -rest_capacitance / farads_per_count / (1 << self.shift)


USUAL_GAIN = 20_000.0  # counts: a firm press reads so many; no maker's figure


@dataclass(frozen=True, kw_only=True)
class _Word(Section):
    """An unsigned word per taxel."""

    highest: Annotated[float, Positive("the largest word, 65535 for 16 bits")] = 65535.0

    lowest = 0.0


@dataclass(frozen=True, kw_only=True)
class CySkinCount(_Word):
    """An unsigned word per taxel, baseline already taken off, higher under pressure.

    The board clips at 0, so about half of the readings of an unloaded taxel are exactly 0:
    that is the floor of the scale, not a fault, and it stays valid. Only the top is a clamp.

    Parameters
    ----------
    highest : float, counts
        The largest word that is sent, 65535 for 16 bits.
    """

    rest = 0.0  # the board takes the baseline off
    direction = 1
    usual_gain = USUAL_GAIN

    def saturated(self, counts: Floats) -> Bools:
        """Where a word is the largest one."""
        return np.asarray(counts >= self.highest)

    def counts_from_difference(self, difference: ArrayLike) -> Floats:
        """Words from differences, counts: rounded, clipped at 0 and at the largest."""
        return np.clip(np.rint(as_floats("difference", difference)), 0.0, self.highest)


@dataclass(frozen=True, kw_only=True)
class PlainCount(_Word):
    """A word per taxel that rests wherever it does: a converter's own count.

    What a board of one's own sends that takes no baseline off. A baseline must be measured.

    Parameters
    ----------
    highest : float, counts
        The largest word that is sent, 65535 for 16 bits.
    falls : bool
        Whether pressure lowers it, as of a resistive taxel below its pull-up.
    """

    falls: bool = False

    rest = float("nan")  # each taxel's own

    @property
    def direction(self) -> int:
        """Sign of the change of a count under pressure."""
        return -1 if self.falls else 1

    @property
    def usual_gain(self) -> float:
        """Guess of the counts per unit of ΔC/C₀."""
        return self.direction * USUAL_GAIN

    def saturated(self, counts: Floats) -> Bools:
        """Where a word is the least or the largest one: nothing is connected, or off the scale."""
        return np.asarray((counts <= self.lowest) | (counts >= self.highest))


def valid_from_counts(
    counts: ArrayLike, convention: Convention | None = None, *, alive: Bools | None = None
) -> Bools:
    """Validity of each count of a reading (L,) or of readings (T, L), same shape.

    Invalid are NaN and infinities, values that the convention cannot send, values at its clamp
    (the load is off the scale in this reading; the taxel lives), and taxels that are not alive.
    An invalid taxel is to be left out, or to be NaN for a filter, never to be set to zero.

    Parameters
    ----------
    counts : array, counts
    convention : Convention, optional
        Knows range and clamps.
    alive : (L,) bool array, optional
        As a calibration has it.

    Raises
    ------
    InputError
        If the length is another, or no count is a number.
    """
    array = as_floats("counts", counts)
    if array.ndim not in (1, 2) or (alive is not None and array.shape[-1] != len(alive)):
        width = "taxels" if alive is None else len(alive)
        raise InputError(
            f"counts has shape {array.shape}, expected ({width},) or (readings, {width}): "
            "one column per taxel"
        )
    valid = np.isfinite(array)
    if not valid.any():
        raise InputError(
            f"counts of shape {array.shape} hold no number, expected a reading: "
            "the board does not answer, or this is another port"
        )
    if convention is not None:
        valid &= (array >= convention.lowest) & (array <= convention.highest)
        valid &= ~convention.saturated(array)
    if alive is not None:
        valid &= alive
    return valid
