"""Numbers as the report says them, and figures as bytes."""

from collections.abc import Sequence

from skinfield.figures.png import png_of as png_of
from skinfield.figures.style import number


def share_in_words(share: float, interval: tuple[float, float]) -> str:
    """Such as "10 % [6–17 %]": a rate and its 95 % interval."""
    low, high = interval
    return f"{100 * share:.0f} % [{100 * low:.0f}–{100 * high:.0f} %]"


def spread_in_words(values: Sequence[float], unit: str, scale: float = 1.0) -> str:
    """Such as "0.12 to 0.19 mm": the ends of some numbers."""
    low, high = min(values) * scale, max(values) * scale
    ends = number(low, 2) if number(low, 2) == number(high, 2) else ""
    return f"{ends or f'{number(low, 2)} to {number(high, 2)}'} {unit}"


def listed(words: Sequence[str]) -> str:
    """Such as "a, b and c"."""
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
