"""Taxels as made, and their counts at one moment, at full speed."""

import random
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from skinfield.emulator.settings import VirtualSettings
from skinfield.errors import Floats, Ints
from skinfield.signal.boards import CYSKIN_GAIN
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


def electronics_of(settings: VirtualSettings) -> Electronics:
    """Electronics that the taxels of all patches are drawn from.

    Those of `simulate.electronics` with another noise, and without the spreads, cross-talk and
    defects that the settings do not ask for.
    """
    icub = settings.hardware == "icub"
    known = icub_electronics() if icub else cyskin_electronics()
    noise = replace(known.noise, white=known.noise.white * settings.noise, flicker=0.0, walk=0.0)
    return Electronics(
        board=known.board if icub else CySkinBoard(gain=CYSKIN_GAIN),
        gain_spread=settings.gain_spread,
        drift=known.drift,
        noise=noise,
    )


def manufacture(skin: Skin, settings: VirtualSettings) -> list[TaxelArray]:
    """Taxels of all patches, each patch by a stream of random numbers of its own."""
    electronics = electronics_of(settings)
    rngs = np.random.default_rng(settings.seed).spawn(len(skin))
    return [electronics.manufacture(p, rng) for p, rng in zip(skin, rngs, strict=True)]


class Converters:
    """Channels of all patches one after the other, and what follows the taxels.

    Parameters
    ----------
    level, gain, drift, white : (C,) arrays
        Count at rest, counts per unit of ΔC/C₀, counts/K and standard deviation in counts.
    converter : (C,) int64 array
        Whose noise in common a channel has.
    common : float, counts
    low, high : float
        Clamps.
    seed : int

    Attributes
    ----------
    change : (C,) array
        ΔC/C₀, written by the world; 0 where a channel is no taxel.
    counts : (C,) array
        Of the last conversion.
    held : (C,) array
        NaN, or the count that a channel sends whatever it feels.
    """

    def __init__(
        self, level: Floats, gain: Floats, drift: Floats, white: Floats, converter: Ints, *,
        common: float, low: float, high: float, seed: int,
    ) -> None:  # fmt: skip
        self.level, self.gain, self.drift, self.white = level, gain, drift, white.copy()
        self._quiet = white
        self._converter, self._common = converter, common
        self.low, self.high = low, high
        count = len(level)
        self.change: Floats = np.zeros(count)
        self.counts: Floats = np.zeros(count)
        self.held: Floats = np.full(count, np.nan)
        rng = np.random.default_rng([seed, 1])
        self._bits = random.Random(seed).getrandbits  # 50 times faster than numpy's for one number
        spare = max(count, int(converter.max(initial=0)) + 1)
        self._normal: Floats = rng.standard_normal(DEVIATES + spare)
        self.convert(0.0)

    def convert(self, warmth: float) -> None:
        """Put the counts of now into `counts`, with `warmth`, K."""
        from skinfield.emulator.kernels import convert

        convert(
            self.change, self.level, self.gain, self.drift, warmth, self.white, self._common,
            self._converter, self._normal, self._bits(BITS), self._bits(BITS), self.held, self.low,
            self.high, self.counts,
        )  # fmt: skip

    def quiet(self, warmth: float) -> Floats:
        """Counts (C,) of now without noise or held channels: what a board takes as its base."""
        level = self.level + self.gain * self.change + self.drift * warmth
        return np.clip(np.rint(level), self.low, self.high)

    def set_fault(self, kind: str, rows: Ints) -> None:
        """Begin a fault of taxels; see `settings.KINDS`."""
        if kind == "noisy":
            self.white[rows] = NOISIER * np.maximum(self._quiet[rows], 1.0)
        elif kind == "dead":
            self.held[rows] = np.rint(self.level[rows])
        elif kind == "stuck":
            self.held[rows] = self.counts[rows]
        elif kind == "saturated":
            self.held[rows] = self.high - 1.0
        else:
            self.held[rows] = 0.0

    def clear_fault(self, kind: str, rows: Ints) -> None:
        """End it."""
        if kind == "noisy":
            self.white[rows] = self._quiet[rows]
        else:
            self.held[rows] = np.nan


def starts_of(skin: Skin) -> Ints:
    """Where the taxels of each patch begin among those of all, (P + 1,)."""
    return np.cumsum([0, *(len(patch) for patch in skin)], dtype=np.int64)


class Others(NamedTuple):
    """Channels behind those of the taxels, which feel only warmth.

    Attributes
    ----------
    drift : float, counts/K
    white : float, counts
        Standard deviation of their noise.
    shared : int
        How many are on one converter.
    """

    drift: float = 0.0
    white: float = 0.0
    shared: int = 1


def converters_for(
    arrays: Sequence[TaxelArray],
    settings: VirtualSettings,
    level: Floats,
    limits: tuple[float, float],
    *,
    size: float = 1.0,
    drift: Floats | None = None,
    others: Others = Others(),  # noqa: B008 - it never changes
) -> Converters:
    """Converters of the taxels of all patches.

    Parameters
    ----------
    arrays : sequence of TaxelArray
    settings : VirtualSettings
    level : (C,) array, counts
        At rest, of the taxels and then of the others.
    limits : (lowest, highest), counts
    size : float
        Counts per count in which the electronics are given; below 0: a press lowers them.
    drift : (L,) array, counts/K, optional
        Of the taxels; default that of the electronics.
    others : Others
    """

    def joined(name: str, other: float) -> Floats:
        return np.concatenate([*(getattr(each, name) for each in arrays), np.full(spare, other)])

    spare, scale = len(level) - sum(len(each.gain) for each in arrays), abs(size)
    converter, first = [], 0
    for each in arrays:
        converter.append(each.wiring.converter + first)
        first += each.wiring.converters
    drifts = joined("drift", others.drift / size) * size
    if drift is not None:
        drifts[: len(drift)] = drift
    return Converters(
        level,
        size * joined("gain", 0.0),
        drifts,
        scale * joined("white_noise", others.white / scale),
        np.concatenate([*converter, first + np.arange(spare) // others.shared]),
        common=scale * settings.common_noise,
        low=limits[0],
        high=limits[1],
        seed=settings.seed,
    )
