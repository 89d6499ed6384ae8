"""Calibration per taxel: counts to ΔC/C₀ and back; on disk as NPZ for programs, TOML for people."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from operator import index
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import FileError, Floats, InputError, as_floats, check_shape
from skinfield.plot import Pictured, Place, drawing, number
from skinfield.signal.baseline import Baseline
from skinfield.signal.boards import Bools, Convention
from skinfield.signal.calibration_file import read_file, write_file
from skinfield.skin import Patch


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Pictured):
    """What turns counts of each taxel of one patch into ΔC/C₀.

    counts = baseline + gain · ΔC/C₀, per taxel. Rows are the rows of the patch.

    Parameters
    ----------
    baseline : (L,) array, counts
        Of the unloaded taxel.
    gain : (L,) array, counts per unit of ΔC/C₀
        Its sign included: negative where pressure lowers the count, as iCub's bytes do.
    noise_std : (L,) array, counts
        Standard deviation of one reading.
    alive : (L,) bool array
        False for a taxel that must be left out; its other columns may then be NaN.
    uid : (L,) uint64 array
        Of the taxels that the rows belong to.
    patch_name : str
    unit : str
        Of the counts.
    basis : str
        What the figures were made from, in a sentence: file, stretch, method.
    """

    baseline: Floats
    gain: Floats
    noise_std: Floats
    alive: Bools
    uid: NDArray[np.uint64]
    patch_name: str = field(default="patch", kw_only=True)
    unit: str = field(default="count", kw_only=True)
    basis: str = field(default="not said", kw_only=True)

    def __post_init__(self) -> None:
        uid = np.array(self.uid, dtype=np.uint64)
        if uid.ndim != 1 or len(uid) == 0:
            raise InputError(f"uid has shape {uid.shape}, expected (taxels,) with at least one")
        columns: dict[str, NDArray] = {  # type: ignore[type-arg]
            name: np.array(as_floats(name, getattr(self, name)))
            for name in ("baseline", "gain", "noise_std")
        }
        columns |= {"alive": np.array(self.alive, dtype=bool), "uid": uid}
        for name, column in columns.items():
            check_shape(name, column, uid.shape, "one per taxel, as uid has")
            column.setflags(write=False)
            object.__setattr__(self, name, column)
        self._check_usable("baseline", np.isfinite(self.baseline), "a finite number")
        self._check_usable(
            "gain", np.isfinite(self.gain) & (self.gain != 0), "a finite number other than 0"
        )
        self._check_usable(
            "noise_std",
            np.isfinite(self.noise_std) & (self.noise_std > 0),
            "a finite number above 0: quantisation alone gives 0.29 counts",
        )

    def _check_usable(self, name: str, good: Bools, expected: str) -> None:
        bad = self.alive & ~good
        if bad.any():
            row = int(np.argmax(bad))
            raise InputError(
                f"{name}[{row}] is {getattr(self, name)[row]}, expected {expected} "
                f"({int(bad.sum())} of {len(bad)} are not): set alive[{row}] to False to leave "
                "the taxel out"
            )

    def __len__(self) -> int:
        return len(self.uid)

    def __repr__(self) -> str:
        return (
            f"Calibration({self.patch_name!r}, {int(self.alive.sum())} of {len(self)} taxels "
            f"alive, median noise {self._noise():.3g} in ΔC/C₀, basis: {self.basis})"
        )

    def _noise(self) -> float:
        return float(np.median(self.quantity_std()[self.alive])) if self.alive.any() else np.nan

    def plot(self, ax: Place = None, *, patch: Patch | None = None) -> Any:
        """Draw the gain of each taxel, by its row or, with its patch, at its place.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            To draw in. Default those of a new figure.
        patch : Patch, optional
            Whose taxels these are, by uid. Taxels that are not alive are crossed.

        Returns
        -------
        matplotlib Axes
            Gains in counts, or whatever `unit` says, per ΔC/C₀; lengths in mm.

        Raises
        ------
        InputError
            If it is another patch's, `ax` is something else, or Matplotlib is not installed.
        """
        return drawing("skinfield.signal.plot:plot_calibration")(self, ax, patch)

    def _facts(self) -> Mapping[str, str]:
        gain = self.gain[self.alive]
        low, high = (gain.min(), gain.max()) if len(gain) else (np.nan, np.nan)
        return {
            "Calibration": self.patch_name,
            "taxels alive": f"{int(self.alive.sum())} of {len(self)}",
            "gain": f"{number(low)} to {number(high)} {self.unit} per ΔC/C₀",
            "median noise": f"{self._noise():.3g} in ΔC/C₀",
            "basis": self.basis,
        }

    @classmethod
    def identity(cls, patch: Patch, *, noise_std: ArrayLike) -> "Calibration":
        """For readings that are ΔC/C₀ already; `noise_std` in ΔC/C₀, one for all or (L,)."""
        return cls._of(patch, 0.0, 1.0, noise_std, unit="1", basis="readings are ΔC/C₀ already")

    @classmethod
    def from_convention(
        cls,
        patch: Patch,
        convention: Convention,
        *,
        gain: ArrayLike,
        noise_std: ArrayLike,
        alive: Bools | None = None,
    ) -> "Calibration":
        """Baseline by the maker's convention: for a recording without an unloaded stretch.

        Parameters
        ----------
        convention : Convention
            Its `rest` becomes the baseline of every taxel, 240 for ``ICubByte()``.
        gain : float or (L,) array, counts per unit of ΔC/C₀
        noise_std : float or (L,) array, counts
        alive : (L,) bool array, optional
            As `find_faults` gives it; default all.

        Raises
        ------
        InputError
            If the convention has no rest, or `gain` has the other sign than its direction.
        """
        if not np.isfinite(convention.rest):
            raise InputError(
                f"convention.rest is {convention.rest}, expected a count: {convention!r} has no "
                "rest by convention, estimate a baseline from an unloaded stretch"
            )
        wrong = np.sign(as_floats("gain", gain)) == -convention.direction
        if np.any(wrong):
            raise InputError(
                f"gain is {gain!r}, expected the sign {convention.direction:+d}: pressure moves "
                f"the counts of {convention!r} that way"
            )
        basis = f"rest {convention.rest:g} of {convention!r}, not measured"
        return cls._of(patch, convention.rest, gain, noise_std, alive=alive, basis=basis)

    @classmethod
    def from_baseline(
        cls,
        patch: Patch,
        baseline: Baseline,
        *,
        gain: ArrayLike,
        alive: Bools | None = None,
        even_if_loaded: bool = False,
    ) -> "Calibration":
        """Baseline and noise as measured; taxels without a baseline are not alive.

        Parameters
        ----------
        gain : float or (L,) array, counts per unit of ΔC/C₀
        alive : (L,) bool array, optional
            As `find_faults` gives it; default all.
        even_if_loaded : bool
            Take a baseline that is not quiet for what it is, as a tare.

        Raises
        ------
        InputError
            If the baseline is not quiet and `even_if_loaded` is False.
        """
        if not (baseline.quiet or even_if_loaded):
            raise InputError(
                f"baseline is not of a quiet, unloaded stretch: {'; '.join(baseline.notes)}. "
                "Record the untouched skin, use Calibration.from_convention, or pass "
                "even_if_loaded=True to count the standing load as zero"
            )
        check_shape("baseline", baseline.baseline, (len(patch),), "one per taxel of the patch")
        if alive is not None:
            check_shape("alive", np.asarray(alive), (len(patch),), "one per taxel of the patch")
        return cls._of(
            patch,
            np.where(baseline.measured, baseline.baseline, np.nan),
            gain,
            baseline.noise_std,
            alive=baseline.measured if alive is None else baseline.measured & alive,
            basis=baseline.basis,
        )

    @classmethod
    def _of(
        cls,
        patch: Patch,
        baseline: ArrayLike,
        gain: ArrayLike,
        noise_std: ArrayLike,
        *,
        alive: Bools | None = None,
        unit: str = "count",
        basis: str,
    ) -> "Calibration":
        def column(name: str, values: ArrayLike) -> Floats:
            array = as_floats(name, values)
            return np.full(len(patch), array) if array.ndim == 0 else array

        return cls(
            baseline=column("baseline", baseline),
            gain=column("gain", gain),
            noise_std=column("noise_std", noise_std),
            alive=np.ones(len(patch), bool) if alive is None else alive,
            uid=patch.uid,
            patch_name=patch.name,
            unit=unit,
            basis=basis,
        )

    @cached_property
    def _divisor(self) -> Floats:
        return np.where(self.alive, self.gain, np.nan)

    def relative_capacitance_from_counts(
        self, counts: ArrayLike, out: Floats | None = None
    ) -> Floats:
        """ΔC/C₀ from counts, (L,) or (T, L); NaN for a taxel that is not alive or not valid.

        With `out` nothing is allocated.

        Raises
        ------
        InputError
            If the last axis is not one count per taxel.
        """
        counts = self._checked("counts", counts)
        out = np.subtract(counts, self.baseline, out=out)
        return np.divide(out, self._divisor, out=out)

    def counts_from_relative_capacitance(
        self, relative_capacitance: ArrayLike, out: Floats | None = None
    ) -> Floats:
        """Counts from ΔC/C₀, (L,) or (T, L), unrounded; NaN for a taxel that is not alive."""
        change = self._checked("relative_capacitance", relative_capacitance)
        out = np.multiply(change, self._divisor, out=out)
        return np.add(out, self.baseline, out=out)

    def _checked(self, name: str, values: ArrayLike) -> Floats:
        array = as_floats(name, values)
        if array.ndim not in (1, 2) or array.shape[-1] != len(self):
            raise InputError(
                f"{name} has shape {array.shape}, expected ({len(self)},) or "
                f"(readings, {len(self)}): one column per taxel of {self.patch_name!r}; pick the "
                "columns of the port with files.recordings.readings_for"
            )
        return array

    def quantity_std(self) -> Floats:
        """Noise of one reading in ΔC/C₀, (L,); infinite where not alive: it tells nothing."""
        noise = np.full(len(self), np.inf)
        np.divide(self.noise_std, np.abs(self.gain), out=noise, where=self.alive)
        return noise

    def without(self, dead: Bools) -> "Calibration":
        """Calibration that leaves out the taxels marked in `dead`, (L,) bool, as well."""
        check_shape("dead", np.asarray(dead), (len(self),), "one per taxel")
        return replace(self, alive=self.alive & ~np.asarray(dead, dtype=bool))

    def check_patch(self, patch: Patch) -> None:
        """Raise InputError unless the rows are those of `patch`, by uid."""
        if len(patch) != len(self):
            raise InputError(
                f"calibration of {self.patch_name!r} has {len(self)} taxels, expected "
                f"{len(patch)} as in patch {patch.name!r}: it belongs to another layout"
            )
        bad = patch.uid != self.uid
        if bad.any():
            row = int(np.argmax(bad))
            raise InputError(
                f"uid[{row}] of the calibration of {self.patch_name!r} is {self.uid[row]}, "
                f"expected {patch.uid[row]} as in patch {patch.name!r} ({int(bad.sum())} of "
                f"{len(bad)} differ): it was made for another layout or another order of taxels"
            )


def strain_from_relative_capacitance(relative_capacitance: ArrayLike) -> Floats:
    """Gap strain v = indentation / thickness from c = ΔC/C₀: v = c / (1 + c).

    C/C₀ = 1 / (1 - v), from eq. (1) and (2). It holds for a gap that is uniform over the pad and
    around it; under a contact narrower than the pad and its gap it is 10-35 % off, and the
    electrostatic observation model is the right one. NaN stays NaN.

    Raises
    ------
    InputError
        If ΔC/C₀ is -1 or less: no gap takes away all capacitance.
    """
    change = as_floats("relative_capacitance", relative_capacitance)
    bad = np.argwhere((change <= -1.0) | np.isinf(change))
    if len(bad):
        where = tuple(int(i) for i in bad[0])
        raise InputError(
            f"relative_capacitance{list(where) if where else ''} is {change[where]}, expected a "
            f"finite number above -1 ({len(bad)} of {change.size} are not): a pad cannot lose all "
            "capacitance"
        )
    return np.asarray(change / (1.0 + change))


KIND = "counts"
_COLUMNS = ("baseline", "gain", "noise_std", "alive", "uid")
_TEXTS = ("patch_name", "unit", "basis")


def save_calibration(calibration: Calibration, path: Path | str) -> None:
    """Write `calibration` to `path`, ``.npz`` or ``.toml`` by its ending.

    Raises
    ------
    FileError
        If the ending is another, or the file cannot be written.
    """
    write_file(path, KIND, table_from_calibration(calibration))


def load_calibration(path: Path | str, patch: Patch | None = None) -> Calibration:
    """Read a calibration of counts; with `patch`, one that must be that patch's, by uid.

    Raises
    ------
    FileError
        If the file is missing, of another format, kind or version, broken, or of another patch.
    """
    kind, content = read_file(path)
    if kind != KIND:
        raise FileError(f"{path} is a calibration by {kind}, expected one of counts")
    try:
        calibration = calibration_from_table(content)
        if patch is not None:
            calibration.check_patch(patch)
    except InputError as error:
        raise FileError(f"{path}: {error}") from error
    return calibration


def table_from_calibration(calibration: Calibration) -> dict[str, Any]:
    """Arrays and texts of a calibration, by name, as a file holds them."""
    table = {name: getattr(calibration, name) for name in (*_TEXTS, *_COLUMNS)}
    # hexadecimal text, as TOML's integers end at 63 bits
    return table | {"uid": [f"{uid:#x}" for uid in calibration.uid.tolist()]}


def calibration_from_table(table: Mapping[str, Any]) -> Calibration:
    """Calibration of what a file holds; InputError for what is none."""
    missing = [name for name in (*_COLUMNS, *_TEXTS) if name not in table]
    if missing:
        raise InputError(f"{', '.join(missing)} is missing, expected as save_calibration writes")
    try:
        columns = {name: _column(name, table[name]) for name in _COLUMNS}
        patch_name, unit, basis = (str(table[name]) for name in _TEXTS)
        return Calibration(**columns, patch_name=patch_name, unit=unit, basis=basis)
    except (ValueError, TypeError, OverflowError) as error:
        raise InputError(str(error)) from error


def _column(name: str, values: Any) -> Any:
    if name == "uid":
        uids = np.asarray(values).tolist()
        return np.array([int(u, 16) if isinstance(u, str) else index(u) for u in uids], np.uint64)
    array = np.asarray(values)
    wanted = "b" if name == "alive" else "if"
    if array.dtype.kind not in wanted:
        raise InputError(
            f"{name} holds {str(values)[:40]}, expected "
            f"{'true or false' if name == 'alive' else 'numbers'}, one per taxel"
        )
    return array
