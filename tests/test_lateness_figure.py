"""The picture of late wakes."""

import numpy as np
import pytest

from skinfield.errors import InputError
from skinfield.figures.lateness import Late, draw_lateness

TIME = np.geomspace(1e-5, 2e-3, 30)
SHARE = np.linspace(1.0, 0.0, 30)


def late(name: str, colour: int, kind: str = "solid") -> Late:
    return Late(name, TIME, SHARE, colour, kind)


def test_each_loop_has_its_line_down_to_the_last_wake() -> None:
    loops = [late("cyclictest", 1, "dashed"), late("loop", 2)]
    figure = draw_lateness(("A", "note", loops), ("B", "note", loops[:1]), "machine")
    left, right = figure.axes
    assert [line.get_label() for line in left.lines] == ["cyclictest", "loop"]
    assert len(right.lines) == 1
    time, share = left.lines[1].get_data()
    assert time[-1] == TIME[-1]  # the latest wake, which none is later than
    assert share[-1] == share[-2] == SHARE[-2]
    assert (left.get_xscale(), left.get_yscale()) == ("log", "log")
    assert [text.get_text() for text in left.get_xticklabels()] == ["10 µs", "100 µs", "1 ms"]


def test_an_empty_panel_is_refused() -> None:
    with pytest.raises(InputError, match="no loops"):
        draw_lateness(("A", "", []), ("B", "", [late("loop", 0)]))
    never = Late("never", TIME[:0], SHARE[:0], 0)
    with pytest.raises(InputError, match="never has no wakes"):
        draw_lateness(("A", "", [never]), ("B", "", [late("loop", 0)]))
