"""The accuracy table as a picture: error against load, with the bound."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.experiments.accuracy_plan import ANYWHERE
from skinfield.experiments.presses import BALL
from skinfield.experiments.rows import Row
from skinfield.figures.accuracy import Curve, ErrorPanel, draw_errors

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ERRORS = {  # column, what it is called, column of its bound
    "place_error_mm": ("place error (mm)", "bound_place_mm"),
    "force_error": ("force error (part of the load)", "bound_force"),
}


def accuracy_figure(
    rows: Sequence[Row],
    noise_counts: float = 1.0,
    indenter: str = BALL.name,
    place: str = ANYWHERE,
    only: Sequence[tuple[str, str]] | None = None,
) -> "Figure":
    """Place and force error of one indenter and kind of place, a column per quantity.

    Parameters
    ----------
    rows : sequence of dict
        The accuracy table.
    noise_counts : float
        One of the table's.
    indenter, place : str
        By the names in the table.
    only : sequence of (solver, model), optional
        Which curves. Default every solver on the layer, and the first one on the half-space.

    Raises
    ------
    InputError
        If the table has no such rows.
    """
    chosen = [
        row
        for row in rows
        if (row["indenter"], row["place"]) == (indenter, place)
        and row["noise_counts"] == noise_counts
        and not row["note"]
    ]
    if not chosen:
        raise InputError(
            f"the table has no rows of {indenter!r} {place!r} at {noise_counts:g} counts, expected "
            "some: choose what is in it"
        )
    pairs = _pairs(chosen) if only is None else list(only)
    quantities = list(dict.fromkeys(row["quantity"] for row in chosen))
    panels = [
        [_panel(chosen, quantity, error, pairs) for quantity in quantities] for error in ERRORS
    ]
    presses = chosen[0]["readings"]
    note = (
        f"{indenter}, {place}; median and 95 % interval over {presses} presses each; "
        f"noise of {noise_counts:g} counts; grid {chosen[0]['grid']}"
    )
    return draw_errors(panels, note)


def _pairs(rows: Sequence[Row]) -> list[tuple[str, str]]:
    found = list(dict.fromkeys((row["solver"], row["model"]) for row in rows))
    models = list(dict.fromkeys(model for _, model in found))
    first = found[0][0]
    return [pair for pair in found if pair[1] == models[-1] or pair == (first, models[0])]


def _panel(
    rows: Sequence[Row], quantity: str, error: str, pairs: Sequence[tuple[str, str]]
) -> ErrorPanel:
    label, bound = ERRORS[error]
    own = [row for row in rows if row["quantity"] == quantity]
    curves = []
    for solver, model in pairs:
        line = [row for row in own if (row["solver"], row["model"]) == (solver, model)]
        values = {key: _column(line, f"{error}_{key}") for key in ("median", "low", "high")}
        curves.append(
            Curve(
                f"{solver}, {model}",
                _column(line, "load_N"),
                values["median"],
                values["low"],
                values["high"],
                dashed=(solver, model) == pairs[0],
            )
        )
    loads = sorted({row["load_N"] for row in own})
    least = [next(row[bound] for row in own if row["load_N"] == load) for load in loads]
    head = f"{quantity}, noise {own[0]['noise_std']:.2g} {own[0]['noise_unit'].strip('1')}".strip()
    return ErrorPanel(head, label, curves, np.array(loads), np.array(least))


def _column(rows: Sequence[Row], key: str) -> Floats:
    return np.array([row[key] for row in rows], dtype=np.float64)
