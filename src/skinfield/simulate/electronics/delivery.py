"""Delivery of readings: conversion times of the converters, arrival, and loss."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, Ints, check_positive
from skinfield.settings import Positive, Range, Section
from skinfield.skin import Patch

INPUTS = 12
"""Of a converter that are converted in turn: a module of these skins has up to twelve taxels."""


@dataclass(frozen=True, eq=False)
class Wiring:
    """Converter (L,) and stage (L,) of each taxel: a converter converts its stages in turn."""

    converter: Ints
    stage: Ints

    @property
    def converters(self) -> int:
        """How many there are."""
        return int(self.converter.max()) + 1

    @property
    def neighbours(self) -> Ints:
        """Pairs (P, 2) of rows at one converter whose stages follow on each other."""
        order = np.lexsort([self.stage, self.converter])
        before, after = order[:-1], order[1:]
        same = self.converter[before] == self.converter[after]
        next_ = self.stage[after] - self.stage[before] == 1
        pairs = np.column_stack([before, after])[same & next_]
        return np.asarray(pairs, dtype=np.int64)


def wiring(patch: Patch) -> Wiring:
    """Wiring of a patch, from its modules and channels.

    Every twelve channels of a module are the stages of one converter. They are counted from
    channel 0 of the port where its width is a multiple of twelve, as on an iCub, where thermal and
    absent channels keep their places; else from the module's first.
    """
    channel = patch.channel.copy()
    if patch.n_channels % INPUTS:
        for module in np.unique(patch.module):
            rows = patch.module == module
            channel[rows] -= channel[rows].min()
    both = np.column_stack([patch.module, channel // INPUTS])
    converter = np.unique(both, axis=0, return_inverse=True)[1].reshape(-1)
    return Wiring(converter.astype(np.int64), (channel % INPUTS).astype(np.int64))


@dataclass(frozen=True, kw_only=True)
class CrossTalk(Section):
    """Part of the change of other taxels that a taxel shows in addition to its own.

    Parameters
    ----------
    neighbours : float
        Of those at the stages before and after it at the same converter. 0: none.
    """

    neighbours: Annotated[float, Range(0.0, 0.5, "a part of the neighbour's change")] = 0.0

    def seen_by_taxels(self, change: Floats, wiring: Wiring) -> Floats:
        """What taxels show, (T, L), of changes (T, L)."""
        shown = change.copy()
        if self.neighbours:
            before, after = wiring.neighbours.T
            shown[:, before] += self.neighbours * change[:, after]
            shown[:, after] += self.neighbours * change[:, before]
        return shown


@dataclass(frozen=True, eq=False)
class Sampling:
    """Instants of a recording.

    Attributes
    ----------
    time : (T,) array, s
        Start of each cycle of conversions, since the start of the recording.
    skew : (L,) array, s
        By how much later than the cycle a taxel is converted.
    stamp_ns : (T,) int64 array, ns
        When the reading was received, by the receiver's clock; never falls.
    delivered : (T,) bool array
        False for a reading that is lost on the way as a whole.
    ticks_ns : (R,) int64 array, ns, or None
        When a logger with a clock of its own reads the port; None: readings are logged as they
        arrive.
    """

    time: Floats
    skew: Floats
    stamp_ns: NDArray[np.int64]
    delivered: NDArray[np.bool_]
    ticks_ns: NDArray[np.int64] | None = None

    def __len__(self) -> int:
        return len(self.time)

    @property
    def instants(self) -> Floats:
        """When each taxel is converted, (T, L) s: where to evaluate what presses."""
        return np.asarray(self.time[:, None] + self.skew)

    @property
    def logged(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Row of the sampling, and stamp in ns, of each reading of the recording, both (R,).

        A logger with a clock of its own logs the newest reading that is there, again and again
        until the next one comes, and stamps it by its own tick.
        """
        rows = np.flatnonzero(self.delivered)
        if self.ticks_ns is None or not len(rows):
            return rows, self.stamp_ns[rows]
        newest = np.searchsorted(self.stamp_ns[rows], self.ticks_ns, side="right") - 1
        there = newest >= 0
        return rows[newest[there]], self.ticks_ns[there]


@dataclass(frozen=True, kw_only=True)
class Delivery(Section):
    """Clock and transport.

    Parameters
    ----------
    rate : float, 1/s
        Cycles of conversion. 20: the boards of the iCub send every 50 ms, and CySkin's EtherCAT
        boards too.
    conversion_time : float, s
        From one taxel of a converter to the next. 0: all at once.
    free_running : bool
        The first cycle begins at a random moment of a period, not at the start of the recording.
    delay : float, s
        From the start of a cycle to its stamp, at least.
    jitter : float, s
        Mean of an exponentially distributed further delay, of a logger's ticks too. 0: none.
    lost_readings : float
        Probability that a reading of the whole patch is lost: its row is missing.
    lost_messages : float
        Probability that one converter's part of a reading is lost.
    holds : bool
        The port then repeats what that converter sent last, as YARP's does; else it shows NaN.
    logged_at : float, 1/s
        Rate of a logger that reads the port by a clock of its own, and so repeats readings where
        it is faster than the board: 50 on recordings of the iCub. 0: each is logged as it arrives.
    """

    rate: Annotated[float, Positive("readings per second")] = 20.0
    conversion_time: Annotated[float, Range(0.0, 1e6, "in seconds; 0 is off")] = 0.0
    free_running: bool = False
    delay: Annotated[float, Range(0.0, 1e6, "in seconds; 0 is off")] = 0.0
    jitter: Annotated[float, Range(0.0, 1e6, "in seconds; 0 is off")] = 0.0
    lost_readings: Annotated[float, Range(0.0, 1.0, "a probability; 0 is off")] = 0.0
    lost_messages: Annotated[float, Range(0.0, 1.0, "a probability; 0 is off")] = 0.0
    holds: bool = True
    logged_at: Annotated[float, Range(0.0, 1e6, "readings per second; 0 is off")] = 0.0

    def check(self) -> None:
        """See `Section`."""
        if INPUTS * self.conversion_time > 1.0 / self.rate:
            raise InputError(
                f"conversion_time is {self.conversion_time:g} s, expected at most "
                f"{1.0 / (INPUTS * self.rate):g}: {INPUTS} taxels are converted within a period "
                f"of {1.0 / self.rate:g} s"
            )

    def sampling(
        self, wiring: Wiring, duration: float, rng: np.random.Generator, start_ns: int
    ) -> Sampling:
        """Instants of a recording of `duration`, s, that starts at `start_ns`."""
        check_positive("duration", duration, "of the recording, in seconds")
        phase, late, lost, logger = rng.spawn(4)
        first = phase.random() / self.rate if self.free_running else 0.0
        readings = max(1, int(np.ceil((duration - first) * self.rate - 1e-9)))
        time = first + np.arange(readings) / self.rate
        arrival = self._stamps(time + self.delay, late, start_ns)
        ticks = None
        if self.logged_at:
            span = (arrival[-1] - arrival[0]) * 1e-9
            grid = np.arange(int(span * self.logged_at) + 1) / self.logged_at
            ticks = self._stamps(grid, logger, int(arrival[0]))
        delivered = lost.random(readings) >= self.lost_readings
        skew = np.asarray(self.conversion_time * wiring.stage, dtype=np.float64)
        return Sampling(time, skew, arrival, delivered, ticks)

    def _stamps(self, time: Floats, rng: np.random.Generator, start_ns: int) -> NDArray[np.int64]:
        """Times, s, as stamps that are late by the jitter; no message overtakes another."""
        late = time + self.jitter * rng.standard_exponential(len(time))
        return start_ns + np.rint(np.maximum.accumulate(late) * 1e9).astype(np.int64)

    def lose(self, counts: Floats, wiring: Wiring, rng: np.random.Generator) -> Floats:
        """Counts (T, L) as the port shows them where messages are lost; the first never is."""
        if self.lost_messages == 0.0:
            return counts
        lost = rng.random((len(counts), wiring.converters)) < self.lost_messages
        lost[0] = False
        if not self.holds:
            return np.where(lost[:, wiring.converter], np.nan, counts)
        fresh = np.where(lost, 0, np.arange(len(counts))[:, None])
        latest = np.maximum.accumulate(fresh, axis=0)
        return np.asarray(np.take_along_axis(counts, latest[:, wiring.converter], axis=0))
