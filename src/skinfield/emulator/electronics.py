"""Converters of a virtual skin: taxels as made, their memory, and their counts at one moment."""

import math
import random
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from skinfield.emulator.settings import NO_HABITS, Fault, VirtualSettings
from skinfield.errors import Floats, Ints
from skinfield.simulate.electronics import (
    CySkinBoard,
    Defect,
    Electronics,
    TaxelArray,
    cyskin_electronics,
    icub_electronics,
)
from skinfield.skin import Skin

BITS = 18
DEVIATES = 1 << BITS  # normal ones, drawn once: each reading takes a stretch from a random place
NOISIER = 10.0  # times, of a noisy taxel


def manufacture(skin: Skin, settings: VirtualSettings) -> list[TaxelArray]:
    """Taxels of all patches, each patch by a stream of random numbers of its own.

    Their electronics are those of `simulate.electronics` with another noise, and without the
    spreads, cross-talk and defects that neither the settings nor habits ask for.
    """
    icub = settings.hardware == "icub"
    known, words = icub_electronics() if icub else cyskin_electronics(), CySkinBoard()
    noise = replace(known.noise, flicker=0.0)
    if settings.habits == NO_HABITS:
        noise = replace(noise, walk=0.0)
    electronics = settings.its_habits.electronics(
        Electronics(
            board=known.board if icub else replace(words, gain=words.convention.usual_gain),
            gain_spread=settings.gain_spread,
            drift=known.drift,
            noise=noise,
        )
    )
    noise = electronics.noise
    noise = replace(noise, white=noise.white * settings.noise_times)
    electronics = replace(electronics, noise=noise)
    rngs = np.random.default_rng(settings.seed).spawn(len(skin))
    return [electronics.manufacture(p, rng) for p, rng in zip(skin, rngs, strict=True)]


def faults_of(arrays: Sequence[TaxelArray]) -> list[Fault]:
    """Faults that taxels are made with; see `Defects`."""
    found = []
    for number, each in enumerate(arrays):
        for kind, defect in (("dead", Defect.DEAD), ("stuck", Defect.STUCK)):
            for row in np.flatnonzero(each.defect == defect).tolist():
                start = float(each.stops_after[row]) if kind == "stuck" else 0.0
                found.append(Fault(kind, f"{number}/{row}", start))
    return found


def starts_of(skin: Skin) -> Ints:
    """Where the taxels of each patch begin among those of all, (P + 1,)."""
    return np.cumsum([0, *(len(patch) for patch in skin)], dtype=np.int64)


class Converters:
    """Channels of all patches one after the other, and what follows the taxels.

    Parameters
    ----------
    arrays : sequence of TaxelArray
        Taxels of the patches.
    settings : VirtualSettings
    level : (C,) array, counts
        At rest, of the taxels and then of the others.
    limits : (lowest, highest), counts
    size : float
        Counts per count in which the electronics are given; below 0: a press lowers them.
    drift, white : float
        Of what follows the taxels, and feels only warmth: counts/K, and standard deviation of the
        noise in counts.
    shared : int
        How many of these are on one converter.

    Attributes
    ----------
    gain, drift, white : (C,) arrays
        Counts per unit of ΔC/C₀, counts/K and standard deviation in counts.
    change : (C,) array
        ΔC/C₀, written by the world; 0 where a channel is no taxel.
    counts : (C,) array
        Of the last conversion.
    held : (C,) array
        NaN, or the count that a channel sends whatever it feels.
    faults : list of Fault
        That taxels are made with.
    """

    def __init__(
        self,
        arrays: Sequence[TaxelArray],
        settings: VirtualSettings,
        level: Floats,
        limits: tuple[float, float],
        *,
        size: float = 1.0,
        drift: float = 0.0,
        white: float = 0.0,
        shared: int = 1,
    ) -> None:
        count = len(level)
        spare = count - sum(len(each.gain) for each in arrays)

        def joined(name: str, other: float) -> Floats:
            return np.concatenate(
                [*(getattr(each, name) for each in arrays), np.full(spare, other)]
            )

        self.low, self.high = limits
        own = arrays[0].electronics
        self._off = size * joined("baseline", own.board.rest) - size * own.board.rest
        self.level = level + self._off
        self.faults = faults_of(arrays)
        self.gain = size * joined("gain", 0.0)
        self.drift = size * joined("drift", drift / size)
        self._quiet = abs(size) * joined("white_noise", white / abs(size))
        self.white = self._quiet.copy()
        converters, first = [], 0
        for each in arrays:
            converters.append(each.wiring.converter + first)
            first += each.wiring.converters
        self._converter = np.concatenate([*converters, first + np.arange(spare) // shared])
        self._common = abs(size) * settings.common_noise
        self.change: Floats = np.zeros(count)
        self.counts: Floats = np.zeros(count)
        self.held: Floats = np.full(count, np.nan)
        self._elastomer = settings.its_habits.elastomer or settings.layer.relaxation
        self._loop = own.hysteresis
        self._late, self._peak = np.zeros(count), np.zeros(count)
        self._felt_change: Floats = np.zeros(count)
        self._walk = abs(size) * own.noise.walk * settings.noise_times
        self._before_ns = 0
        self._bits = random.Random(settings.seed).getrandbits  # of numpy one takes 50 times as long
        self._normal: Floats = own.noise.deviates(
            DEVIATES + max(count, int(self._converter.max(initial=0)) + 1),
            np.random.default_rng([settings.seed, 1]),
            np.random.default_rng([settings.seed, 4]),
        )
        self.convert(0.0)

    def _felt(self, warmth: float) -> Floats:
        return self.level + self.gain * self._felt_change + self.drift * warmth

    def _whole(self, values: Floats) -> Floats:
        return np.clip(np.rint(values), self.low, self.high)

    def convert(self, warmth: float, now_ns: int = 0) -> None:
        """Put the counts of now into `counts`, with `warmth`, K, above 25 °C."""
        self._remember(now_ns)
        start = self._bits(BITS)
        values = self._felt(warmth)
        values += self.white * self._normal[start : start + len(values)]
        if self._common > 0.0:
            values += self._common * self._normal[self._bits(BITS) + self._converter]
        self.counts[:] = np.where(np.isnan(self.held), self._whole(values), self.held)

    def _remember(self, now_ns: int) -> None:
        """Let the elastomer creep, the dielectric lag and levels walk since the last conversion."""
        seconds = max(now_ns - self._before_ns, 0) * 1e-9 if self._before_ns else 0.0
        self._before_ns, change = now_ns, self.change
        if self._elastomer is not None:
            part = self._elastomer.relaxed_fraction
            late = -math.expm1(-seconds / self._elastomer.retardation_time)
            strain = change / (1.0 + change)  # which goes with the load, as ΔC/C₀ does not
            self._late += late * (strain - self._late)
            strain = part * strain + (1.0 - part) * self._late
            change = strain / (1.0 - strain)
        if self._loop.width:
            change = self._loop.step(change, self._peak)
        self._felt_change = change
        if self._walk and seconds:
            start = self._bits(BITS)
            steps = self._normal[start : start + len(change)]
            self.level = self.level + self._walk * math.sqrt(seconds) * steps

    def quiet(self, warmth: float) -> Floats:
        """Counts (C,) of now without held channels: what a board takes as its base.

        Without noise, but for that of the one reading that a board takes which tares itself.
        """
        self._remember(self._before_ns)
        return self._whole(self._felt(warmth) - self._off)

    def set_fault(self, kind: str, row: int) -> None:
        """Begin a fault of a taxel; see `settings.KINDS`."""
        if kind == "noisy":
            self.white[row] = NOISIER * max(self._quiet[row], 1.0)
        elif kind == "dead":
            self.held[row] = self._whole(self.level)[row]
        elif kind == "stuck":
            self.held[row] = self.counts[row]
        else:
            self.held[row] = self.high - 1.0 if kind == "saturated" else 0.0

    def clear_fault(self, kind: str, row: int) -> None:
        """End it."""
        if kind == "noisy":
            self.white[row] = self._quiet[row]
        else:
            self.held[row] = np.nan
