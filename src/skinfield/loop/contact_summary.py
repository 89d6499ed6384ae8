"""Summary of contacts over a while, one entry for each."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass
class ContactSummary:
    """One contact over its time.

    Attributes
    ----------
    track : int
    patch : str
    first_s, last_s : float, s
        Since watching began.
    force_n, force_std_n : float, N
        The largest normal force, and its standard deviation.
    position_mm : list of float, mm
        Where it was then, in the patch's frame.
    area_mm2, peak_kpa : float
        Then.
    """

    track: int
    patch: str
    first_s: float
    last_s: float
    force_n: float = 0.0
    force_std_n: float | None = None
    position_mm: tuple[float, ...] = ()
    area_mm2: float = 0.0
    peak_kpa: float = 0.0


class ContactSummaries:
    """Collects contacts.

    Parameters
    ----------
    patches : list of str
        Names, by number.
    """

    def __init__(self, patches: list[str]) -> None:
        self._patches = patches
        self._summaries: dict[int, ContactSummary] = {}

    def take(self, rows: NDArray[Any], seconds: float) -> None:
        """Take the contacts of one cycle, `seconds` after watching began."""
        for row in rows:
            track, force = int(row["track"]), float(row["normal_force"])
            known = self._summaries.get(track)
            if known is None:
                known = ContactSummary(track, self._patches[int(row["patch"])], seconds, seconds)
                self._summaries[track] = known
            known.last_s = seconds
            if force >= known.force_n:
                std = float(row["force_std"])
                known.force_n, known.force_std_n = force, std if np.isfinite(std) else None
                known.position_mm = tuple((row["position"] * 1e3).tolist())
                known.area_mm2 = float(row["area"]) * 1e6
                known.peak_kpa = float(row["peak_pressure"]) * 1e-3

    @property
    def contacts(self) -> list[dict[str, Any]]:
        """By the order in which they came; numbers rounded to what they are good for."""
        return [
            {key: _short(value) for key, value in vars(each).items()}
            for each in self._summaries.values()
        ]


def _short(value: Any) -> Any:
    if isinstance(value, float):
        return round(value, 4)
    return [round(each, 4) for each in value] if isinstance(value, tuple) else value
