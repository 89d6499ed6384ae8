"""Summary of contacts over a while, one entry for each."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

DIGITS = 4  # to which numbers are rounded: what they are good for


class ContactSummaries:
    """Collects contacts.

    Parameters
    ----------
    patches : list of str
        Names, by number.
    """

    def __init__(self, patches: list[str]) -> None:
        self._patches = patches
        self._known: dict[int, dict[str, Any]] = {}

    def take(self, rows: NDArray[Any], seconds: float) -> None:
        """Take the contacts of one cycle, `seconds` after watching began."""
        for row in rows:
            track, force = int(row["track"]), round(float(row["normal_force"]), DIGITS)
            new = {"track": track, "patch": self._patches[int(row["patch"])], "force_n": 0.0}
            known = self._known.setdefault(track, new | {"first_s": round(seconds, DIGITS)})
            known["last_s"] = round(seconds, DIGITS)
            if force >= known["force_n"]:
                std = float(row["force_std"])
                known |= {
                    "force_n": force,
                    "force_std_n": round(std, DIGITS) if np.isfinite(std) else None,
                    "position_mm": np.round(row["position"] * 1e3, DIGITS).tolist(),
                    "area_mm2": round(float(row["area"]) * 1e6, DIGITS),
                    "peak_kpa": round(float(row["peak_pressure"]) * 1e-3, DIGITS),
                }

    @property
    def contacts(self) -> list[dict[str, Any]]:
        """One entry for each contact, in the order in which they came, for JSON.

        `track` and `patch`; from `first_s` to `last_s` since watching began; its largest force
        `force_n` with `force_std_n`; and where and how it pressed then: `position_mm` in the
        patch's frame, `area_mm2`, `peak_kpa`.
        """
        return list(self._known.values())
