"""Time stamps of text recordings, to whole nanoseconds."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

LIMIT = 2**63 - 1
SECOND = 10**9  # ns


def ns_from_text(token: str, scale: int) -> int:
    """Nanoseconds from a decimal number of `scale` ns; exact, where a float would round to 200 ns.

    Raises
    ------
    ValueError
        If `token` is no number, not finite, or beyond 292 years.
    """
    whole, _, part = token.strip().partition(".")
    digits = whole[1:] if whole[:1] in "+-" else whole
    try:
        if (digits + part).isdecimal() and len(part) <= 9 and len(digits) <= 20:
            sign = -1 if whole.startswith("-") else 1
            fraction = int(part.ljust(9, "0")) * scale // 10**9 if part else 0
            stamp = sign * (int(digits or "0") * scale + fraction)
        else:
            stamp = round(float(token) * scale)
    except (ValueError, OverflowError):
        raise ValueError(f"the time {token.strip()[:20]!r} is not a finite number") from None
    if abs(stamp) > LIMIT:
        raise ValueError(f"the time {token.strip()[:20]!r} is beyond 292 years: is it in seconds?")
    return stamp


@dataclass
class WholeSeconds:
    """Whether stamps look like whole milliseconds that were taken for seconds.

    Recorders that write a time in whole milliseconds do not say so; no skin is read that slowly.
    """

    possible: bool = True
    steps: int = 0
    short: int = 0  # of these, below 5 s
    last: int | None = None

    def add(self, stamp_ns: NDArray[np.int64]) -> None:
        """Look at some more stamps."""
        self.possible = self.possible and not (stamp_ns % SECOND).any()
        known = stamp_ns if self.last is None else np.concatenate([[self.last], stamp_ns])
        steps = np.diff(known)
        self.steps, self.short = self.steps + len(steps), self.short + int((steps < 5e9).sum())
        self.last = int(stamp_ns[-1])

    @property
    def are_milliseconds(self) -> bool:
        """Whether all stamps are whole seconds that mostly step by 5 or more."""
        return self.possible and self.steps > 0 and 2 * self.short < self.steps


@dataclass
class Order:
    """Stamps that repeat or run backwards."""

    repeats: int = 0
    backwards: int = 0
    first: dict[str, int] = field(default_factory=dict)
    last: int | None = None

    def add(self, stamp_ns: NDArray[np.int64], line: NDArray[np.int64]) -> None:
        """Look at some more stamps."""
        before = stamp_ns[:1] if self.last is None else np.array([self.last])
        steps = np.diff(stamp_ns, prepend=before)
        if self.last is None:
            steps[0] = 1  # the first has none before it
        for wrong, kind in ((steps == 0, "repeats"), (steps < 0, "backwards")):
            if wrong.any():
                setattr(self, kind, getattr(self, kind) + int(wrong.sum()))
                self.first.setdefault(kind, int(line[int(np.argmax(wrong))]))
        self.last = int(stamp_ns[-1])

    def notes(self, name: str) -> tuple[str, ...]:
        """Sentences, with file and line of the first."""
        said = (("repeats", "repeat the one before"), ("backwards", "run backwards"))
        return tuple(
            f"{getattr(self, kind)} stamps {what}, first at {name}:{self.first[kind]}: kept"
            for kind, what in said
            if getattr(self, kind)
        )


def order_notes(stamp_ns: NDArray[np.int64], name: str, line: NDArray[np.int64]) -> tuple[str, ...]:
    """Sentences on stamps that repeat or run backwards, with file and line of the first."""
    order = Order()
    if len(stamp_ns):
        order.add(stamp_ns, line)
    return order.notes(name)
