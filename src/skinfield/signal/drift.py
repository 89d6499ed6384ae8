"""Drift of each taxel's rest, estimated together with what touches: a Kalman filter, compiled.

The rest of a taxel wanders, by temperature and by an elastomer that creeps, slower than a touch
comes. What it reads beside what touches is its rest and noise: the rest is a random walk that is
followed by a Kalman filter (Kalman 1960, Journal of Basic Engineering 82, 35-45), one for each
taxel, as noise is independent. What touches is what contacts explain, as far as their model is
right; and what rests on the skin goes on being read as it is, so that what changes slowly is drift.
What it is read as is then a constant of the same filter: it is known ever better, and its error
does not become one of the rest.
A change that is too fast for one is another touch. Jumps are drawn in (Huber 1964, Annals of
Mathematical Statistics 35, 73-101): they move nothing.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints

FOLLOWED = 5.0  # s in which a drift is followed, at the usual rate
UNDER = 6.0  # times longer, of a taxel that reads what rests on the skin
USUAL = 0.02  # s between readings that have no stamps
BACK_NS = 1_000_000_000  # by which a stamp must be older for all to begin anew
LONGEST = 3600.0  # s: after a longer pause, a rest is as uncertain as after this
JUMP = 3.0  # deviations from which on an innovation is drawn in
SETTLED = 25  # readings whose mean is the pattern of what rests, at first
RECENT = 0.1  # weight of a reading in the mean of the recent ones, by which changes are told
CHANGE = 5.0  # deviations of the sum of squares, from which on a pattern has changed
READ = 2.0  # deviations from which on a taxel is one of a pattern
LASTING = 10  # readings after which another number of contacts is believed
UNSEEN = 1e6  # variance over the noise's, of what a taxel that was not read yet holds
LAG = 1.0  # deviations by which rests may be behind their drift

Flags = NDArray[np.bool_]
State = tuple[Floats, Floats, Floats, Floats, Floats, Floats, Ints]


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
    most = own * spread + LAG * LAG * read
    return bool(now > (1.0 + LAG * LAG) * spread or lately > most)


@inner
def seconds_since(before_ns: int, stamp_ns: int) -> float:
    """From one reading to the next; as usual, where there is none before or no stamp."""
    return 1e-9 * (stamp_ns - before_ns) if before_ns and stamp_ns else USUAL


@inner
def draw_near(value: float, gain: float, step: float, most: float) -> float:
    """A value moved by a step that is drawn in."""
    return value + gain * min(max(step, -most), most)


@njit
def follow_rest(
    left: Floats,
    valid: Flags,
    noise: Floats,
    predicted: Floats,
    misfit: float,
    contacts: int,
    stamp_ns: int,
    before_ns: Ints,
    state: State,
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
    stamp_ns, before_ns : int and (1,) array, ns
        Of this reading, and of the one before, which becomes this one.
    state : tuple of arrays
        Rest and variance; what is held, its variance, and what it shares with the rest's; how far
        recent readings are from it; how many readings are held, of how many contacts, and for how
        many readings there were others.
    """
    rest, variance, held, unsure, shared, recent, marks = state
    wrong = 0.0
    if contacts > 0 or marks[0] > 0:
        marks[2] = marks[2] + 1 if marks[1] != contacts else 0
        resting = marks[0] > 0 and marks[2] < LASTING
        if not resting or has_changed(left, valid, noise, held, predicted, recent):
            marks[0], marks[1], marks[2] = 0, contacts, 0
            held[:] = recent[:] = 0.0
    if (contacts > 0 or marks[0] > 0) and marks[0] < SETTLED:
        marks[0] += 1
        for taxel in range(len(rest)):
            own = noise[taxel] * noise[taxel]
            if marks[0] == 1:
                unsure[taxel] = UNSEEN * own
            if valid[taxel]:
                gain = unsure[taxel] / (unsure[taxel] + own)
                held[taxel] += gain * (left[taxel] - held[taxel])
                unsure[taxel] *= 1.0 - gain
            wrong = max(wrong, abs(predicted[taxel]))
            if marks[0] == SETTLED:  # it was read less the rest, whose error it has
                unsure[taxel] += variance[taxel]
                shared[taxel] = -variance[taxel]
    rests, seconds = marks[0] == SETTLED, seconds_since(before_ns[0], stamp_ns)
    before_ns[0] = stamp_ns
    walk, wrong = min(max(seconds, 0.0), LONGEST) * USUAL / FOLLOWED**2, (misfit * wrong) ** 2
    for taxel in range(len(rest)):
        own = noise[taxel] * noise[taxel]
        reads = rests and abs(held[taxel]) > READ * noise[taxel]
        variance[taxel] += walk * own / (UNDER * UNDER if reads else 1.0)
        if not valid[taxel]:
            continue
        if rests:
            alone, both = variance[taxel] + shared[taxel], shared[taxel] + unsure[taxel]
            total = alone + both + own
            off, most = left[taxel] - held[taxel], JUMP * np.sqrt(total)
            rest[taxel] = draw_near(rest[taxel], alone / total, off, most)
            held[taxel] = draw_near(held[taxel], both / total, off, most)
            variance[taxel] -= alone * alone / total
            shared[taxel] -= alone * both / total
            unsure[taxel] -= both * both / total
        else:
            total = variance[taxel] + own + wrong
            off, most = left[taxel] - predicted[taxel], JUMP * np.sqrt(total)
            gain = variance[taxel] / total
            rest[taxel] = draw_near(rest[taxel], gain, off, most)
            variance[taxel] *= 1.0 - gain


@njit
def follow_idle(
    left: Floats,
    valid: Flags,
    noise: Floats,
    nothing: Floats,
    idle: Flags,
    starts: Ints,
    stamps: Ints,
    stamps_before: Ints,
    state: State,
) -> None:
    """`follow_rest` of all patches that nothing touches, as `idle` (P,) says.

    Parameters
    ----------
    left, valid, noise, nothing : (L,) arrays
        Of the taxels of all patches; the last is 0.
    starts : (P + 1,) array
        Where each patch's taxels begin.
    stamps, stamps_before : (P,) arrays, ns
        Of this reading, and the one before, which becomes this one.
    state : tuple of arrays
        Of all patches.
    """
    rest, variance, held, unsure, shared, recent, marks = state
    for patch in range(len(idle)):
        if idle[patch]:
            a, b = starts[patch], starts[patch + 1]
            first, second = (rest[a:b], variance[a:b], held[a:b]), (unsure[a:b], shared[a:b])
            own = *first, *second, recent[a:b], marks[patch]
            parts = left[a:b], valid[a:b], noise[a:b], nothing[a:b]
            before = stamps_before[patch : patch + 1]
            follow_rest(*parts, 0.0, 0, stamps[patch], before, own)


class Drift:
    """What is known of the rest of taxels, reading after reading, patch by patch.

    Parameters
    ----------
    noise_std : (L,) array, in the quantity's unit
        Of the taxels of all patches.
    starts : (P + 1,) array, optional
        Where each patch's taxels begin. Default one patch.

    Attributes
    ----------
    rest : (L,) array, in the quantity's unit
        That readings are taken from.
    variance : (L,) array
        Of the rest.
    """

    def __init__(self, noise_std: Floats, starts: Ints | None = None) -> None:
        self.noise_std = np.array(noise_std, np.float64)
        self._starts = np.array([0, len(noise_std)]) if starts is None else starts
        patches, rows = len(self._starts) - 1, np.zeros((8, len(self.noise_std)))
        self.rest, self.variance, *pattern, self._left, self._nothing = rows
        marks = np.zeros((patches, 3), np.int64)
        self._state: Any = (self.rest, self.variance, *pattern, marks)
        self._stamps = np.zeros(patches, np.int64)
        self._parts = [self._part(patch) for patch in range(patches)]

    def _part(self, patch: int) -> tuple[Any, ...]:
        """Views of one patch: readings, noise, nothing, its stamp, its state."""
        of = slice(*self._starts[patch : patch + 2])
        rows = [each[of] for each in (self._left, self.noise_std, self._nothing)]
        *state, marks = self._state
        own = *(each[of] for each in state), marks[patch]
        return *rows, self._stamps[patch : patch + 1], own

    def reset(self) -> None:
        """Forget all readings: taxels rest at 0."""
        for each in self._state:
            each[...] = 0
        self._stamps[:] = 0

    def take(self, readings: Floats, stamp_ns: int | None = None) -> Floats:
        """Readings (L,) less the rest, in memory that the next call writes over.

        A stamp that is older than the one before, by a second or more, begins anew.
        """
        if stamp_ns is not None and stamp_ns < self._stamps[0] - BACK_NS:
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
        patch: int = 0,
    ) -> None:
        """Follow the rest by what was taken last and the contacts in it; see `follow_rest`.

        A reading that was learnt from, by its stamp, is not again.
        """
        left, noise, nothing, before, state = self._parts[patch]
        if stamp_ns and stamp_ns == before[0]:
            return
        explained = nothing if predicted is None else predicted
        follow_rest(left, valid, noise, explained, misfit, contacts, stamp_ns, before, state)

    @property
    def known(self) -> Floats:
        """Rest and its variance, (2, L), from which another may go on."""
        return np.stack([self.rest, self.variance])

    def go_on_from(self, known: Floats) -> None:
        """Begin anew with a rest and its variance (2, L)."""
        self.reset()
        self.rest[:], self.variance[:] = known

    def learn_idle(self, valid: Flags, idle: Flags, stamps_ns: Ints) -> None:
        """Follow the rest of patches that nothing touches, as `idle` (P,) says."""
        known = self._left, valid, self.noise_std, self._nothing, idle
        follow_idle(*known, self._starts, stamps_ns, self._stamps, self._state)
