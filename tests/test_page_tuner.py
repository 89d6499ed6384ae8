"""Settings in the page's units: what it says may be, may be."""

from types import SimpleNamespace
from typing import Any

import pytest

from skinfield.page.live_controller import tune

RANGES = {
    "deadline": (2e-5, 9.000000000000001e-4),
    "smoothing": (0.0, 1.0),
    "threshold": (0.0, 5.0),
}


class Tuned:
    """Stands for a live skin; refuses what is outside of its ranges by one bit."""

    tuning = None
    limits = SimpleNamespace(
        as_dict=lambda _: {name: {"range": list(ends)} for name, ends in RANGES.items()}
    )

    def tune(self, **changes: Any) -> None:
        for name, value in changes.items():
            low, high = RANGES[name]
            assert low <= value <= high, (name, value)
        self.took = changes


@pytest.mark.parametrize(
    ("what", "value", "took"),
    [
        ("deadline_us", 20, {"deadline": 2e-5}),
        ("deadline_us", 900, {"deadline": 9.000000000000001e-4}),
        ("deadline_us", 400, {"deadline": pytest.approx(4e-4)}),
        ("smoothing_ms", 1000, {"smoothing": 1.0}),
        ("threshold_N", 0, {"threshold": 0.0}),
    ],
)
def test_the_ends_of_a_range_are_in_it(what: str, value: float, took: dict[str, Any]) -> None:
    live = Tuned()
    tune(live, what, value)  # type: ignore[arg-type]
    assert live.took == took
