"""Taxels as made: each with its gain, baseline, drift, noise and defect."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from skinfield.conditioning import Calibration
from skinfield.errors import Floats, InputError, as_floats, check_finite, check_shape
from skinfield.layout import Patch
from skinfield.simulate.electronics.board import ICubBoard
from skinfield.simulate.electronics.defects import Defect, Kinds
from skinfield.simulate.electronics.delivery import Sampling
from skinfield.simulate.electronics.wiring import Wiring, wiring

if TYPE_CHECKING:
    from skinfield.simulate.electronics.electronics import Electronics

PER_TAXEL = ("gain", "baseline", "drift", "white_noise", "defect", "stops_after")
OVERLOAD = 1e9  # counts: beyond the clamp of any board
NOISELESS = 1e-6  # of ΔC/C₀: stands for no noise, which a calibration cannot hold


@dataclass(frozen=True, kw_only=True, eq=False)
class TaxelArray:
    """One draw of a patch's electronics; see `Electronics.manufacture`.

    Attributes
    ----------
    electronics : Electronics
    patch : Patch
    gain : (L,) array, counts per unit of ΔC/C₀
        Sign included.
    baseline : (L,) array, counts
        Level of the unloaded taxel at the reference temperature.
    drift : (L,) array, counts/K
    pad_error : (converters,) array, converter counts
        Of the thermal pads.
    white_noise : (L,) array, counts
        Standard deviation.
    defect : (L,) int8 array
        Of `Defect`.
    stops_after : (L,) array, s
        From when on a stuck taxel is stuck.
    """

    electronics: "Electronics"
    patch: Patch
    gain: Floats
    baseline: Floats
    drift: Floats
    pad_error: Floats
    white_noise: Floats
    defect: Kinds
    stops_after: Floats

    def __post_init__(self) -> None:
        for name in PER_TAXEL:
            column = np.array(getattr(self, name))
            check_shape(name, column, (len(self.patch),), "one per taxel of the patch")
            column.setflags(write=False)
            object.__setattr__(self, name, column)
        pads = (self.wiring.converters,)
        check_shape("pad_error", self.pad_error, pads, "one per converter of the patch")

    def __len__(self) -> int:
        return len(self.patch)

    @cached_property
    def wiring(self) -> Wiring:
        """Converter and stage of each taxel."""
        return wiring(self.patch)

    @cached_property
    def calibration(self) -> Calibration:
        """The true one: gain, baseline, and the noise of a reading from one to the next.

        That is white and common noise and the board's steps; drift, flicker and walk are not in
        it. Taxels with a defect are not alive.
        """
        settings = self.electronics
        steps = settings.board.step / math.sqrt(12.0) if settings.quantised else 0.0
        noise = np.sqrt(self.white_noise**2 + settings.noise.common**2 + steps**2)
        return Calibration(
            self.baseline,
            self.gain,
            np.maximum(noise, NOISELESS * np.abs(self.gain)),
            self.defect == Defect.NONE,
            self.patch.uid,
            patch_name=self.patch.name,
            unit="count" if settings.board.unit == "count" else "1",
            basis="the truth of simulated electronics",
        )

    def with_defects(self, rows: Mapping[Defect, ArrayLike]) -> "TaxelArray":
        """Array in which the taxels of the given rows have the given defects as well.

        Raises
        ------
        InputError
            If a row is none of the patch's.
        """
        defect = self.defect.copy()
        for kind, which in rows.items():
            chosen = np.asarray(which)
            inside = chosen.dtype.kind in "iu" and ((chosen >= 0) & (chosen < len(self))).all()
            if chosen.size and not inside:
                raise InputError(
                    f"rows of {kind!r} are {which!r}, expected whole numbers from 0 to "
                    f"{len(self) - 1}: rows of patch {self.patch.name!r}"
                )
            defect[chosen.astype(np.int64)] = kind
        return replace(self, defect=defect)

    def sample_times(
        self, duration: float, rng: np.random.Generator, *, start_ns: int = 0
    ) -> Sampling:
        """When the taxels are converted and their readings stamped.

        Parameters
        ----------
        duration : float, s
        rng : numpy Generator
        start_ns : int, ns
            Stamp of the start of the recording.
        """
        return self.electronics.delivery.sampling(self.wiring, duration, rng, start_ns)

    def counts(
        self, change: ArrayLike, temperature: ArrayLike | None, rng: np.random.Generator
    ) -> Floats:
        """Counts (T, L) of one recording; NaN where a taxel does not answer.

        Parameters
        ----------
        change : (T, L) array
            ΔC/C₀ of each taxel when it is converted, `Sampling.instants`.
        temperature : (T,) array, K, or None
            Of the surroundings; None: that of the reference.
        rng : numpy Generator
            Noise, flicker and losses have a stream each.

        Raises
        ------
        InputError
            If a shape is another, or a number is not finite.
        """
        change = self._changes(change)
        noise, joints, losses, pads = rng.spawn(4)
        rate = self.electronics.delivery.rate
        level = self._cold_level(change) + self._warmed(len(change), temperature, pads)
        level += self.electronics.noise.sample(
            self.white_noise, self.wiring, len(level), rate, noise
        )
        counts = self._spoiled(level, joints)
        return self.electronics.delivery.lose(counts, self.wiring, losses)

    def _changes(self, change: ArrayLike) -> Floats:
        change = as_floats("change", change)
        check_shape("change", change, (None, len(self)), "ΔC/C₀, one row per reading")
        if not len(change):
            raise InputError(f"change has shape {change.shape}, expected at least one reading")
        check_finite("change", change, "what a taxel feels is known, even if it does not answer")
        return change

    def _cold_level(self, change: Floats) -> Floats:
        """What the converter is offered at the reference temperature, (T, L) counts."""
        shown = self.electronics.cross_talk.shown(change, self.wiring)
        return np.asarray(self.baseline + self.gain * shown)

    def _warmed(
        self, readings: int, temperature: ArrayLike | None, rng: np.random.Generator
    ) -> Floats:
        """What the temperature adds to that, (T, L) counts, less what the board takes off."""
        settings = self.electronics
        if temperature is None:
            warmth = np.zeros(readings)
        else:
            temperature = as_floats("temperature", temperature)
            check_shape("temperature", temperature, (readings,), "one per reading, in kelvin")
            check_finite("temperature", temperature, "the surroundings have one at any time")
            warmth = settings.drift.warmth(temperature, settings.delivery.rate)
        added = warmth[:, None] * self.drift
        if settings.thermal_pads is not None and isinstance(settings.board, ICubBoard):
            remainder = settings.thermal_pads.remainder(warmth, self.pad_error, self.wiring, rng)
            added = added - remainder / settings.board.size
        return np.asarray(added)

    def _spoiled(self, level: Floats, rng: np.random.Generator) -> Floats:
        """Counts as sent, (T, L), the defects included."""
        settings = self.electronics
        direction, rate = math.copysign(1.0, settings.board.gain), settings.delivery.rate
        clamps = settings.quantised and settings.board.step > 0
        full = OVERLOAD if clamps else 4.0 * abs(settings.board.gain)
        loose = np.flatnonzero(self.defect == Defect.FLICKERING)
        if len(loose):
            open_ = settings.defects.open(len(level), len(loose), rate, rng)
            level[:, loose] -= self.gain[loose] * open_  # all of its capacitance
        level[:, self.defect == Defect.DEAD] = settings.board.rest
        level[:, self.defect == Defect.SATURATED] = settings.board.rest + direction * full
        counts = settings.board.counts_from_level(level) if settings.quantised else level
        for taxel in np.flatnonzero(self.defect == Defect.STUCK):
            stop = math.ceil(self.stops_after[taxel] * rate)
            counts[stop:, taxel] = counts[min(stop, len(counts) - 1), taxel]
        counts[:, self.defect == Defect.ABSENT] = np.nan
        return counts
