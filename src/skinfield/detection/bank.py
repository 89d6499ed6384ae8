"""Templates against the noise: from readings to how well each template matches."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from skinfield.detection.templates import Templates
from skinfield.errors import Floats, InputError, Ints, as_floats, check_range, check_shape

UNSEEN = 1e-12  # of the best template's information: below, a template is not seen at all
MASKS_KEPT = 32  # sets of taxels whose information stays known


@dataclass(frozen=True, eq=False)
class Noise:
    """Gaussian noise of one reading: independent per taxel, and an offset that all share.

    Attributes
    ----------
    std : (L,) array, unit of the reading
    common : float, unit of the reading
        Standard deviation of the offset; infinite where nothing is known of it, 0 for none.
    correlation : float
        With the next reading; it falls as a power of the readings between (an AR(1) process).
    """

    std: Floats
    common: float
    correlation: float = 0.0

    @classmethod
    def of(
        cls, noise_std: object, common_mode: bool | float, correlation: float, taxels: int
    ) -> "Noise":
        """Check what the caller gave: a number or (L,); False, True or a number."""
        std = as_floats("noise_std", noise_std)  # type: ignore[arg-type]
        std = np.full(taxels, float(std)) if std.ndim == 0 else std.copy()
        check_shape("noise_std", std, (taxels,), "one number, or one per taxel")
        good = np.isfinite(std) & (std > 0)
        if not good.all():
            row = int(np.argmin(good))
            raise InputError(
                f"noise_std[{row}] is {std[row]}, expected a finite number above 0: no reading is "
                "exact; give the standard deviation of a quiet taxel"
            )
        switch = isinstance(common_mode, bool | np.bool_)
        common = (np.inf if common_mode else 0.0) if switch else _number(common_mode)
        if not common >= 0.0:
            raise InputError(
                f"common_mode is {common_mode!r}, expected False, True, or the standard deviation "
                "of an offset that all taxels share, in the unit of a reading"
            )
        why = "of a reading's noise with that of the next; 0 for white noise"
        check_range("correlation", correlation, 0.0, 0.99, why)
        return cls(std, common, float(correlation))

    def growth(self, count: Ints) -> Floats:
        """Variance of the sum of so many readings, in variances of one; the count if white."""
        kept = self.correlation
        far = 2.0 * kept * (1.0 - kept**count) / (1.0 - kept) ** 2
        return np.asarray(count * (1.0 + kept) / (1.0 - kept) - far)

    @property
    def offset(self) -> Floats:
        """What an offset of 1 adds to the readings in units of their noise, (L,)."""
        return np.asarray(1.0 / self.std)

    @property
    def inverse_variance(self) -> float:
        """Of the offset: 0 where it is unknown."""
        return 1.0 / self.common**2 if self.common > 0 else np.inf


@dataclass(frozen=True, eq=False)
class Bank:
    """Templates in units of the noise.

    Attributes
    ----------
    templates : Templates
    noise : Noise
    scaled : (J, L) array, 1/N
        Template over noise.
    """

    templates: Templates
    noise: Noise
    scaled: Floats
    _known: dict[bytes, Floats] = field(default_factory=dict, repr=False)

    @classmethod
    def of(cls, templates: Templates, noise: Noise) -> "Bank":
        """Divide the templates by the noise."""
        bank = cls(templates, noise, np.ascontiguousarray(templates.readings / noise.std))
        if not bank.information(np.ones(len(noise.std), dtype=np.bool_)).any():
            raise InputError(
                f"common_mode is {noise.common!r} and the patch has {len(noise.std)} taxel(s), "
                "expected a template that an offset cannot imitate: give common_mode=False"
            )
        return bank

    def whitened(self, readings: Floats) -> Floats:
        """Inverse covariance times readings (..., L), times the noise: 0 where they are NaN."""
        valid = ~np.isnan(readings)
        out = np.where(valid, readings, 0.0) / self.noise.std
        if self.noise.common > 0:
            shared = np.where(valid, self.noise.offset, 0.0)
            out -= shared * self._shared_part(out @ self.noise.offset, shared)[..., None]
        return out

    def score(self, whitened: Floats) -> Floats:
        """Scores (N, J) of sums of whitened readings (N, L): see `Matches`."""
        return np.asarray(whitened @ self.scaled.T)

    def information(self, valid: NDArray[np.bool_]) -> Floats:
        """Information g² (J,) of one reading in which some taxels answered: see `Matches`."""
        key = np.packbits(valid).tobytes()
        if key not in self._known:
            while len(self._known) >= MASKS_KEPT:
                self._known.pop(next(iter(self._known)))
            self._known[key] = self._computed(valid)
        return self._known[key]

    def _computed(self, valid: NDArray[np.bool_]) -> Floats:
        part = self.scaled[:, valid]
        known = np.einsum("jl,jl->j", part, part)
        floor = UNSEEN * known.max(initial=0.0)
        if self.noise.common > 0:
            shared = self.noise.offset[valid]
            along = part @ shared
            known -= along * self._shared_part(along, shared)
        return np.where(known > floor, known, 0.0)

    def _shared_part(self, along: Floats, shared: Floats) -> Floats:
        """The offset that best explains a reading, given its product with `shared`; 0 if none."""
        weight = np.square(shared).sum(axis=-1) + self.noise.inverse_variance
        out: Floats = np.divide(along, weight, out=np.zeros(np.shape(along)), where=weight > 0)
        return out

    def idle(self, count: int, rng: "np.random.Generator") -> Floats:
        """Whitened noise (count, L) of single readings of an idle patch."""
        noise = rng.standard_normal((count, len(self.noise.std)))
        if 0 < self.noise.common < np.inf:
            offset = self.noise.common * rng.standard_normal((count, 1))
            noise += offset * self.noise.offset
        return self.whitened(noise * self.noise.std)


def _number(value: object) -> float:
    """A number, or NaN for what is none."""
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return np.nan


def spread_of(information: Floats) -> Floats:
    """1/g where g² is above 0, else 0."""
    out = np.zeros_like(information)
    np.divide(1.0, np.sqrt(information), out=out, where=information > 0)
    return out
