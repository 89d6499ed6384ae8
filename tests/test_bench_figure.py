"""The two panels of `skinfield bench`: axes, units, legend, what is drawn where."""

import numpy as np
import pytest

from skinfield.errors import InputError
from skinfield.figures.bench import BELOW, FLOOR, Curve, View, draw_bench, written

NODES = np.array([10.0, 20.0, 40.0])
LEFT = View(
    "Cost",
    "mean",
    (
        Curve("paper", NODES, np.array([1e-3, 1e-2, 1.0]), low=NODES * 0 + 1e-3, high=NODES * 0.1),
        Curve("ours", NODES, np.array([2e-6, 5e-6, 2e-5]), "dashed"),
        Curve("paper", NODES[1:], np.array([4e-4, 1.4e-3]), "hollow"),
    ),
    x="nodes",
    y="time per reading",
    x_is="nodes",
)
RIGHT = View(
    "Error",
    "of nine in ten",
    (Curve("ours", np.array([1e-5, 1e-4, 1e-3]), np.array([1.0, 0.02, 0.0])),),
    x="time",
    y="error",
    y_is="share",
    floor=True,
)


def test_axes_are_logarithmic_with_units() -> None:
    figure = draw_bench(LEFT, RIGHT, ("paper", "ours"), foot="a machine")
    figure.canvas.draw()
    left, right = figure.axes
    assert [axes.get_xscale() for axes in figure.axes] == ["log", "log"]
    assert [axes.get_yscale() for axes in figure.axes] == ["log", "log"]
    assert [tick.get_text() for tick in left.get_xticklabels()] == ["10 × 10", "20 × 20", "40 × 40"]
    shown = {tick.get_text() for tick in left.get_yticklabels()}
    assert {"10 µs", "1 ms", "1 s"} <= shown
    assert {"10 µs", "100 µs", "1 ms"} <= {tick.get_text() for tick in right.get_xticklabels()}
    errors = [tick.get_text() for tick in right.get_yticklabels()]
    assert errors == ["converged", "0.1 %", "1 %", "10 %", "100 %"]
    for axes, view in ((left, LEFT), (right, RIGHT)):
        assert (axes.get_xlabel(), axes.get_ylabel()) == (view.x, view.y)


def test_what_is_nothing_stands_below_the_floor() -> None:
    figure = draw_bench(LEFT, RIGHT, ("paper", "ours"))
    (line,) = figure.axes[1].get_lines()
    assert np.asarray(line.get_ydata()) == pytest.approx([1.0, 0.02, BELOW])
    assert figure.axes[1].get_ylim()[0] < BELOW < FLOOR


def test_a_method_has_one_colour_and_the_legend_covers_nothing() -> None:
    figure = draw_bench(LEFT, RIGHT, ("paper", "ours"), kinds=(("dashed", "cold"),))
    figure.canvas.draw()
    lines = figure.axes[0].get_lines()
    assert lines[-1].get_color() == lines[0].get_color()  # the stars are the paper's
    drawn = [line for line in figure.axes[0].get_lines() if line.get_linestyle() == "--"]
    assert drawn[0].get_color() == figure.axes[1].get_lines()[0].get_color()
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["paper", "ours", "cold"]
    box = legend.get_window_extent()
    whole = figure.bbox
    assert box.x0 >= whole.x0
    assert box.x1 <= whole.x1
    for axes in figure.axes:
        tight = axes.get_tightbbox()
        assert not box.overlaps(tight)
        assert tight.x0 >= whole.x0
        assert tight.x1 <= whole.x1


def test_what_cannot_be_drawn() -> None:
    with pytest.raises(InputError, match="expected one or more"):
        draw_bench(View("t", "n", (), x="x", y="y"), RIGHT, ("ours",))
    with pytest.raises(InputError, match=r"also \['ours'\]"):
        draw_bench(LEFT, RIGHT, ("paper",))


@pytest.mark.parametrize(
    ("value", "what", "text"),
    [
        (2e-5, "time", "20 µs"),
        (1e-3, "time", "1 ms"),
        (0.05, "time", "50 ms"),
        (1.0, "time", "1 s"),
        (5e-7, "time", "500 ns"),
        (1e-4, "share", "0.01 %"),
        (1.0, "share", "100 %"),
        (5e-4, "length", "0.5 mm"),
    ],
)
def test_numbers_as_they_stand_at_ticks(value: float, what: str, text: str) -> None:
    assert written(value, what) == text
