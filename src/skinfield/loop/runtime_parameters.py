"""Runtime parameters of an engine: what can be changed while it answers, within which limits."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np

from skinfield.errors import InputError, check_choice, check_range, check_type

AUTO: Literal["auto"] = "auto"
SHORTEST = 20e-6  # s, for the reconstruction
LARGEST = 0.9  # of a period
HEAVIEST, SLOWEST = 5.0, 1.0  # N, s: thresholds and time constants up to these


@dataclass(frozen=True, kw_only=True)
class Focus:
    """A window of a patch: what presses there is answered first, and on the finest grid.

    Parameters
    ----------
    patch : str
    low, high : pair of float, m
        Its corners, in the plane of the patch.
    """

    patch: str
    low: tuple[float, float]
    high: tuple[float, float]

    def __post_init__(self) -> None:
        check_type("patch", self.patch, str, "the name of the patch to look at")
        for name in ("low", "high"):
            corner: Any = getattr(self, name)
            try:
                x, y = map(float, corner)
            except (TypeError, ValueError):
                expected = "expected a pair of numbers, m"
                raise InputError(f"{name} is {corner!r:.80}, {expected}") from None
            for each in (x, y):
                check_range(name, each, -1e3, 1e3, "m, in the plane of the patch")
            object.__setattr__(self, name, (x, y))
        if not (self.low[0] < self.high[0] and self.low[1] < self.high[1]):
            raise InputError(
                f"high is {self.high}, expected more than low, {self.low}, along both axes"
            )

    @classmethod
    def of(cls, plain: object) -> "Focus":
        """Of a mapping with patch, low and high; raises InputError for anything else."""
        if not isinstance(plain, Mapping) or set(plain) != {"patch", "low", "high"}:
            raise InputError(f"focus is {plain!r:.80}, expected patch, low and high, or None")
        return cls(patch=plain["patch"], low=plain["low"], high=plain["high"])


@dataclass(frozen=True, kw_only=True)
class Tuning:
    """What can be changed while an engine answers.

    Parameters
    ----------
    resolution : "auto" or int
        Nodes along the sides of the finest grid for answers; "auto": as fine as time allows.
    deadline : float, s
        For the reconstruction within one cycle.
    threshold : float, N
        Contacts of a smaller force are not told.
    smoothing : float, s
        Time constant of a first-order low-pass of what each taxel reads; 0: none.
    focus : Focus, optional
    """

    resolution: int | Literal["auto"] = AUTO
    deadline: float = 400e-6
    threshold: float = 0.0
    smoothing: float = 0.0
    focus: Focus | None = None

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return asdict(self)

    def changed(self, changes: Mapping[str, Any]) -> "Tuning":
        """With other values by name; a focus may be a mapping, as `Focus.of` takes it.

        Raises
        ------
        InputError
            For a name that is none of these; see `Limits.check` for values.
        """
        known = list(vars(self))
        for name in changes:
            if name not in known:
                raise InputError(f"{name!r:.80} is no setting, expected one of {', '.join(known)}")
        given = dict(changes)
        if given.get("focus") is not None and not isinstance(given["focus"], Focus):
            given["focus"] = Focus.of(given["focus"])
        return replace(self, **given)


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What a tuning may be of one engine.

    Parameters
    ----------
    rungs : tuple of int
        Nodes along the sides of its grids.
    longest : float, s
        For the reconstruction within one cycle.
    patches : tuple of str
    fixed : str
        Why nothing can be changed; empty if it can.
    """

    rungs: tuple[int, ...]
    longest: float
    patches: tuple[str, ...]
    fixed: str = ""

    @classmethod
    def of(cls, description: Mapping[str, Any]) -> "Limits":
        """Of the engine whose ring has this description."""
        longest = max(LARGEST * float(description["period"]), float(description["budget"]))
        return cls(
            rungs=tuple(description["rungs"]),
            longest=longest,
            patches=tuple(description["patches"]),
            fixed=str(description.get("fixed", "")),
        )

    def check(self, tuning: Tuning) -> Tuning:
        """The tuning itself, with plain numbers.

        Raises
        ------
        InputError
            If the engine cannot be tuned so.
        """
        if self.fixed:
            raise InputError(f"nothing can be changed here: {self.fixed}")
        if type(tuning.resolution) is bool or tuning.resolution not in (AUTO, *self.rungs):
            raise InputError(
                f"resolution is {tuning.resolution!r:.80}, expected {AUTO!r} or one of "
                f"{', '.join(map(str, self.rungs))}: the grids that are prepared"
            )
        for name, low, high, why in (
            ("deadline", SHORTEST, self.longest, "s, of a cycle for its answers"),
            ("threshold", 0.0, HEAVIEST, "N, of contacts that are told"),
            ("smoothing", 0.0, SLOWEST, "s, a time constant; 0: none"),
        ):
            value = getattr(tuning, name)
            check_range(name, np.nan if isinstance(value, bool) else value, low, high, why)
        if tuning.focus is not None:
            check_type("focus", tuning.focus, Focus, "a window, or None")
            check_choice("focus.patch", tuning.focus.patch, self.patches, "a patch of the skin")
        return replace(
            tuning,
            deadline=float(tuning.deadline),
            threshold=float(tuning.threshold),
            smoothing=float(tuning.smoothing),
        )

    def as_dict(self, tuning: Tuning) -> dict[str, Any]:
        """Values, options and ranges in plain SI numbers; `off` says what cannot be changed."""
        plain = tuning.as_dict()
        return {
            "resolution": {"value": tuning.resolution, "options": [AUTO, *self.rungs]},
            "deadline": {"value": tuning.deadline, "range": [SHORTEST, self.longest]},
            "threshold": {"value": tuning.threshold, "range": [0.0, HEAVIEST]},
            "smoothing": {"value": tuning.smoothing, "range": [0.0, SLOWEST]},
            "focus": {"value": plain["focus"], "options": list(self.patches)},
            "off": dict.fromkeys([*plain, "solver"], self.fixed) if self.fixed else {},
        }
