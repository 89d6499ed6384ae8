"""Converters of a virtual skin: taxels as made, and their counts at one moment."""

import random
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from skinfield.emulator.settings import VirtualSettings
from skinfield.errors import Floats, Ints
from skinfield.simulate.electronics import (
    CySkinBoard,
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
    spreads, cross-talk and defects that the settings do not ask for.
    """
    icub = settings.hardware == "icub"
    known, words = icub_electronics() if icub else cyskin_electronics(), CySkinBoard()
    white = known.noise.white * settings.noise_scale
    noise = replace(known.noise, white=white, flicker=0.0, walk=0.0)
    electronics = Electronics(
        board=known.board if icub else replace(words, gain=words.convention.usual_gain),
        gain_spread=settings.gain_spread,
        drift=known.drift,
        noise=noise,
    )
    rngs = np.random.default_rng(settings.seed).spawn(len(skin))
    return [electronics.manufacture(p, rng) for p, rng in zip(skin, rngs, strict=True)]


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

        self.level, (self.low, self.high) = level, limits
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
        self._bits = random.Random(settings.seed).getrandbits  # of numpy one takes 50 times as long
        self._normal: Floats = np.random.default_rng([settings.seed, 1]).standard_normal(
            DEVIATES + max(count, int(self._converter.max(initial=0)) + 1)
        )
        self.convert(0.0)

    def _felt(self, warmth: float) -> Floats:
        return self.level + self.gain * self.change + self.drift * warmth

    def _whole(self, values: Floats) -> Floats:
        return np.clip(np.rint(values), self.low, self.high)

    def convert(self, warmth: float) -> None:
        """Put the counts of now into `counts`, with `warmth`, K, above 25 °C."""
        start = self._bits(BITS)
        values = self._felt(warmth)
        values += self.white * self._normal[start : start + len(values)]
        if self._common > 0.0:
            values += self._common * self._normal[self._bits(BITS) + self._converter]
        self.counts[:] = np.where(np.isnan(self.held), self._whole(values), self.held)

    def quiet(self, warmth: float) -> Floats:
        """Counts (C,) of now without noise or held channels: what a board takes as its base."""
        return self._whole(self._felt(warmth))

    def set_fault(self, kind: str, row: int) -> None:
        """Begin a fault of a taxel; see `settings.KINDS`."""
        if kind == "noisy":
            self.white[row] = NOISIER * max(self._quiet[row], 1.0)
        elif kind == "dead":
            self.held[row] = np.rint(self.level[row])
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
