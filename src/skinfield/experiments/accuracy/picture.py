"""The accuracy table as a picture: error against load, with the bound."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.experiments.accuracy.plan import ANYWHERE
from skinfield.experiments.paper.presses import BALL
from skinfield.experiments.scoring.rows import Row
from skinfield.figures.accuracy import Curve, ErrorPanel, draw_errors
from skinfield.figures.style import number

ERRORS = {  # stem of the columns, what it is called, column of its bound
    "place_error_mm": ("place error of what\nis found (mm)", "bound_place_mm"),
    "force_error": ("force error\n(part of the load)", "bound_force"),
    "missed": ("presses missed\n(share)", ""),
}


def accuracy_figure(
    rows: Sequence[Row],
    noise_counts: float = 1.0,
    indenter: str = BALL.name,
    place: str = ANYWHERE,
    only: Sequence[tuple[str, str]] | None = None,
) -> Any:
    """Place, force and misses of one indenter and kind of place, a column per quantity.

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

    Returns
    -------
    matplotlib.figure.Figure

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
    counts = f"{noise_counts:g} {'count' if noise_counts == 1 else 'counts'}"
    note = (
        f"{indenter}, {place}; median and 95 % interval over {presses} presses each; "
        f"noise of {counts}; grid {chosen[0]['grid']}"
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
        middle = error if not bound else f"{error}_median"
        curves.append(
            Curve(
                f"{solver}, {model}",
                _column(line, "load_N"),
                _column(line, middle),
                _column(line, f"{error}_low"),
                _column(line, f"{error}_high"),
                dashed=(solver, model) == pairs[0],
            )
        )
    least = {row["load_N"]: row[bound] for row in own} if bound else {}
    loads = sorted(least)
    return ErrorPanel(
        f"{quantity}, noise {_noise(own[0])}",
        label,
        curves,
        np.array(loads),
        np.array([least[load] for load in loads]),
        share=not bound,
    )


def _noise(row: Row) -> str:
    if row["noise_unit"] == "Pa":
        return f"{number(row['noise_std'] / 1e3, 2)} kPa"
    return number(row["noise_std"], 2)


def _column(rows: Sequence[Row], key: str) -> Floats:
    return np.array([row[key] for row in rows], dtype=np.float64)
