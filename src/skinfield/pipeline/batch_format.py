"""How results lie on the disk: a folder of settings, stamps and readings, all of it checkable.

    run.skinfield/
      settings.json   patch, grid, elastomer, solver, calibration; sums of the two arrays' blocks
      stamp_ns.npy    (T,) int64
      readings.npy    (T, L) what was recorded, in the narrowest type that holds it

The arrays open with `numpy.load`. Where the readings are counts, the settings say what turns them
into the quantity; a missing one is the type's highest number.
"""

import json
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats

FORMAT = "skinfield results"
VERSION = 1
SETTINGS, STAMPS, READINGS = "settings.json", "stamp_ns.npy", "readings.npy"
BLOCK = 4096  # readings of one sum
WHOLE = ("|u1", "<i2", "<u2", "<i4")  # types of counts, the narrowest first
TYPES = (*WHOLE, "<f4", "<f8")
ROUNDING = 1e-3  # of the noise: what single precision may round readings by


def missing_of(kind: np.dtype[Any]) -> int | None:
    """What stands for a missing value; None where the type has NaN."""
    return None if kind.kind == "f" else int(np.iinfo(kind).max)


@dataclass
class Extent:
    """Which numbers a recording holds, so that the narrowest type can be found."""

    whole: bool = True
    single: bool = True
    low: float = np.inf
    high: float = -np.inf

    def add(self, counts: Floats) -> None:
        """Look at some more (T, L)."""
        there = counts[~np.isnan(counts)]
        if there.size:
            self.whole = self.whole and bool((there == np.rint(there)).all())
            self.single = self.single and bool((there.astype(np.float32) == there).all())
            self.low = min(self.low, float(there.min()))
            self.high = max(self.high, float(there.max()))

    def kind(self, noise_std: float | None = None) -> np.dtype[Any]:
        """Type that holds them all exactly.

        Parameters
        ----------
        noise_std : float, optional
            If single precision rounds all by less than a thousandth of it, it is taken.
        """
        if self.whole and self.low <= self.high:
            for name in WHOLE:
                limits = np.iinfo(name)
                if limits.min <= self.low and self.high < limits.max:
                    return np.dtype(name)
        rounding = max(abs(self.low), abs(self.high)) * 2.0**-24
        fine = noise_std is not None and rounding < ROUNDING * noise_std
        return np.dtype("<f4" if self.single or fine else "<f8")


def narrowed(counts: Floats, kind: np.dtype[Any]) -> NDArray[Any]:
    """Numbers (T, L) in another type, missing ones as it has them."""
    missing = missing_of(kind)
    return (counts if missing is None else np.where(np.isnan(counts), missing, counts)).astype(kind)


def widened(stored: NDArray[Any]) -> Floats:
    """Undo `narrowed`."""
    missing = missing_of(stored.dtype)
    wide = stored.astype(np.float64)
    if missing is not None:
        wide[stored == missing] = np.nan
    return wide


def text_from_content(content: dict[str, Any]) -> str:
    """The settings file: what it is, its version, and a sum of the rest."""
    head = {"format": FORMAT, "version": VERSION, "check": _sum(content)}
    return json.dumps(head | {"content": content}, indent=1, allow_nan=False) + "\n"


def content_from_text(text: str, where: str) -> dict[str, Any]:
    """Undo `text_from_content`; raises FileError for what it never writes."""
    try:
        whole = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise FileError(f"{where} is no JSON ({str(error)[:120]}), expected settings") from error
    if not isinstance(whole, dict) or whole.get("format") != FORMAT:
        raise FileError(f"{where} does not say {FORMAT!r} as its format, expected results")
    if whole.get("version") != VERSION:
        raise FileError(
            f"{where} is of version {str(whole.get('version'))[:20]}, expected {VERSION}: open it "
            "with the skinfield that wrote it"
        )
    content = whole.get("content")
    if not isinstance(content, dict) or whole.get("check") != _sum(content):
        raise FileError(
            f"{where} is not as it was written (its sum differs), expected it unchanged: damaged, "
            "or edited; for another solver or grid use LazyResults.using"
        )
    return content


def _sum(content: dict[str, Any]) -> str:
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return f"{zlib.crc32(text.encode('utf-8', 'surrogatepass')):08x}"
