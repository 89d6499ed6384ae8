"""Times as they are written, to whole nanoseconds."""

import numpy as np
from numpy.typing import NDArray

LIMIT = 2**63 - 1


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


def milliseconds_if_whole(stamp_ns: NDArray[np.int64]) -> NDArray[np.int64] | None:
    """The same stamps a thousand times closer, if they are whole seconds that step by 5 or more.

    Recorders that write a time in whole milliseconds do not say so; no skin is read that slowly.
    """
    steps = np.diff(stamp_ns)
    if len(steps) and not (stamp_ns % 10**9).any() and np.median(steps) >= 5 * 10**9:
        return stamp_ns // 1000
    return None


def order_notes(stamp_ns: NDArray[np.int64], name: str, line: NDArray[np.int64]) -> tuple[str, ...]:
    """Sentences on stamps that repeat or run backwards, with file and line of the first."""
    notes = []
    steps = np.diff(stamp_ns)
    for wrong, what in ((steps == 0, "repeat the one before"), (steps < 0, "run backwards")):
        if wrong.any():
            first = line[int(np.argmax(wrong)) + 1]
            notes.append(f"{int(wrong.sum())} stamps {what}, first at {name}:{first}: kept")
    return tuple(notes)
