"""Drift of each taxel's rest, estimated together with what touches: a Kalman filter, compiled.

The rest of a taxel wanders, by temperature and by an elastomer that creeps, slower than a touch
comes. What it reads beside what touches is its rest and noise: the rest is a random walk that is
followed by a Kalman filter (Kalman 1960, Journal of Basic Engineering 82, 35-45), a scalar for each
taxel, as noise is independent. What touches is what contacts explain, as far as their model is
right; and what rests on the skin goes on being read as it is, so that what changes slowly is drift.
A change that is too fast for one is another touch. Jumps are drawn in (Huber 1964, Annals of
Mathematical Statistics 35, 73-101): they move nothing.
"""

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints

FOLLOWED = 5.0  # s in which a drift is followed, at the usual rate
UNDER = 6.0  # times longer, of a taxel that reads what rests on the skin
USUAL = 0.02  # s between readings that have no stamps
LONGEST = 3600.0  # s: after a longer pause, a rest is as uncertain as after this
JUMP = 3.0  # deviations from which on an innovation is drawn in
SETTLED = 25  # readings whose mean is the pattern of what rests
RECENT = 0.1  # weight of a reading in the mean of the recent ones, by which changes are told
CHANGE = 5.0  # deviations of the sum of squares, from which on a pattern has changed
READ = 2.0  # deviations from which on a taxel is one of a pattern
LASTING = 10  # readings after which another number of contacts is believed
LAG = 1.0  # deviations by which rests may be behind their drift

Flags = NDArray[np.bool_]


@njit
def subtract_rest(readings: Floats, rest: Floats, out: Floats) -> None:
    """Write readings (L,) less their rest into `out`."""
    for taxel in range(len(out)):
        out[taxel] = readings[taxel] - rest[taxel]


@inner
def has_changed(
    left: Floats, valid: Flags, noise: Floats, held: Floats, predicted: Floats, recent: Floats
) -> bool:
    """Whether readings (L,) are no more what was held, by this one or by the recent ones.

    By the taxels that read what was held, and those that contacts are now seen by.
    """
    now, lately, read = 0.0, 0.0, 0
    for taxel in range(len(held)):
        if valid[taxel] and max(abs(held[taxel]), abs(predicted[taxel])) > READ * noise[taxel]:
            away = (left[taxel] - held[taxel]) / noise[taxel]
            away = min(max(away, -JUMP - LAG), JUMP + LAG)
            recent[taxel] += RECENT * (away - recent[taxel])
            now += away * away
            lately += recent[taxel] * recent[taxel]
            read += 1
    spread = read + CHANGE * np.sqrt(2.0 * read)
    own = RECENT / (2.0 - RECENT)  # variance of a mean of noise
    return now > (1.0 + LAG * LAG) * spread or lately > own * spread + LAG * LAG * read


@njit
def follow_rest(
    left: Floats,
    valid: Flags,
    noise: Floats,
    predicted: Floats,
    misfit: float,
    contacts: int,
    seconds: float,
    state: tuple[Floats, Floats, Floats, Floats, Ints],
) -> None:
    """Take a reading (L,), less the rest as it was, into the rest and its variance.

    Parameters
    ----------
    left : (L,) array
        In the quantity's unit.
    valid : (L,) bool array
        Taxels that answered.
    noise : (L,) array
        Standard deviation of one reading.
    predicted : (L,) array
        What contacts explain of it.
    misfit : float
        What that may be wrong by, part of the highest.
    contacts : int
        That there are.
    seconds : float
        Since the reading before.
    state : tuple of arrays
        Rest and variance; what is held and how far recent readings are from it; how many readings
        are held, of how many contacts, and for how many readings there were others.
    """
    rest, variance, held, recent, marks = state
    wrong = 0.0
    if contacts == 0:
        marks[0] = 0
    else:
        marks[2] = marks[2] + 1 if marks[1] != contacts else 0
        resting = marks[0] > 0 and marks[2] < LASTING
        if not resting or has_changed(left, valid, noise, held, predicted, recent):
            marks[0], marks[1], marks[2] = 0, contacts, 0
            held[:] = recent[:] = 0.0
        if marks[0] < SETTLED:
            marks[0] += 1
            for taxel in range(len(rest)):
                held[taxel] += (left[taxel] - held[taxel]) / marks[0]
                wrong = max(wrong, abs(predicted[taxel]))
    rests = marks[0] == SETTLED
    walk, wrong = min(seconds, LONGEST) * USUAL / FOLLOWED**2, (misfit * wrong) ** 2
    for taxel in range(len(rest)):
        own = noise[taxel] * noise[taxel]
        variance[taxel] += walk * own
        if not valid[taxel]:
            continue
        expected, unsure = predicted[taxel], own + wrong
        if rests:
            expected = held[taxel]
            unsure *= UNDER**2 if abs(expected) > READ * noise[taxel] else 1.0
        total = variance[taxel] + unsure
        most, gain = JUMP * np.sqrt(variance[taxel] + own + wrong), variance[taxel] / total
        rest[taxel] += gain * min(max(left[taxel] - expected, -most), most)
        variance[taxel] *= 1.0 - gain


class Drift:
    """What is known of the rest of a patch's taxels, reading after reading.

    Parameters
    ----------
    noise_std : (L,) array, in the quantity's unit

    Attributes
    ----------
    rest : (L,) array, in the quantity's unit
        That readings are taken from.
    variance : (L,) array
        Of the rest.
    """

    def __init__(self, noise_std: Floats) -> None:
        self.noise_std = np.array(noise_std, np.float64)
        rows = np.zeros((6, len(self.noise_std)))
        self.rest, self.variance, held, recent, self._left, self._nothing = rows
        self._state = self.rest, self.variance, held, recent, np.zeros(3, np.int64)
        self._stamp_ns = 0

    def reset(self) -> None:
        """Forget all readings: taxels rest at 0."""
        for each in self._state:
            each[...] = 0
        self._stamp_ns = 0

    def take(self, readings: Floats, stamp_ns: int) -> Floats:
        """Readings (L,) less the rest, in memory that the next call writes over.

        A stamp that is older than the one before begins anew.
        """
        if stamp_ns < self._stamp_ns:
            self.reset()
        subtract_rest(readings, self.rest, self._left)
        return self._left

    def learn(
        self,
        valid: Flags,
        stamp_ns: int,
        predicted: Floats | None = None,
        misfit: float = 0.0,
        contacts: int = 0,
    ) -> None:
        """Follow the rest by what was taken last and the contacts in it; see `follow_rest`."""
        past = stamp_ns - self._stamp_ns
        seconds = past * 1e-9 if past and self._stamp_ns else USUAL
        self._stamp_ns = stamp_ns
        explained = self._nothing if predicted is None else predicted
        known = self._left, valid, self.noise_std, explained, misfit, contacts, seconds
        follow_rest(*known, self._state)
