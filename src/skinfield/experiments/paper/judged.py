"""The truth beside an independent judge: contact solver, exact solution and finite elements."""

from importlib.util import find_spec

import numpy as np

from skinfield.experiments.agreement import BODIES, LOADS, Agreement, agree, agreement_table
from skinfield.experiments.section import Missing, Picture, Section, Verdict
from skinfield.experiments.settings import Settings
from skinfield.experiments.words import png_of, spread_in_words
from skinfield.figures.panels import Line, Panel, Scale, draw_panels

SMOKE_LOADS, SMOKE_FINEST = (0.5,), 0.03
FINEST = 0.01  # length of the smallest elements, in thicknesses


def judged(settings: Settings) -> Section | Missing:
    """How far the truth of all other sections is from finite elements, per indenter and load."""
    if find_spec("skfem") is None:
        return Missing(
            "agreement with finite elements: scikit-fem is not installed "
            "(pip install 'skinfield[fem]')"
        )
    rows = all_agreements(settings)
    return Section(
        name="agreement",
        title="The truth and its judge",
        claim="Simulations are compared with a commercial finite-element program; no numbers are "
        "given.",
        sentences=(_sentence(rows),),
        pictures=(_picture(rows),),
        tables=(agreement_table(rows),),
        verdicts=(
            Verdict(
                "truth",
                "a finite-element program is the reference",
                f"contact solver off by at most {_worst(rows, 'base_error')} of base stress, "
                f"{_worst(rows, 'surface_error')} of the surface (relative L2)",
                "holds without it, up to linear elasticity",
            ),
        ),
    )


def all_agreements(settings: Settings) -> list[Agreement]:
    """Every indenter and load that linear elasticity keeps off the base."""
    smoke = settings.size.name == "smoke"
    loads, finest = (SMOKE_LOADS, SMOKE_FINEST) if smoke else (LOADS, FINEST)
    rows = []
    for name, body in BODIES[:3] if smoke else BODIES:  # the wide cylinder takes longest
        for force in loads:
            if not (name == "cylinder 3 mm" and force > 1.8):  # it would go through the layer
                rows.append(agree(settings.layer, name, body, force, finest=finest))
    return rows


def _worst(rows: list[Agreement], name: str) -> str:
    return f"{100 * max(getattr(row.lattice, name) for row in rows):.2g} %"


def _sentence(rows: list[Agreement]) -> str:
    lattice = [row.lattice for row in rows]
    exact = [row.exact for row in rows]
    depth = [abs(row.lattice.depth / row.depth - 1) for row in rows]
    field = [abs(row.field / row.reading - 1) for row in rows]
    series = [abs(row.series / row.reading - 1) for row in rows]
    return (
        f"{len(rows)} presses, solved three ways: on cells with the layer's Green's function, as "
        "everywhere in this report; by an integral equation for bodies of revolution; and by "
        "mixed finite elements that share no code with either. Against the elements the cells are "
        f"off by {spread_in_words([a.base_error for a in lattice], '%', 100)} of base stress, "
        f"{spread_in_words([a.surface_error for a in lattice], '%', 100)} of the surface and "
        f"{spread_in_words(depth, '%', 100)} of depth; the integral equation by "
        f"{spread_in_words([a.base_error for a in exact], '%', 100)} and "
        f"{spread_in_words([a.surface_error for a in exact], '%', 100)}. A centred pad's "
        f"capacitance is {spread_in_words(field, '%', 100)} off what elements find for Laplace's "
        "equation in the deformed gap, and to third order of its series "
        f"{spread_in_words(series, '%', 100)}."
    )


def _picture(rows: list[Agreement]) -> Picture:
    panels = []
    for title, name in (("Base stress", "base_error"), ("Surface", "surface_error")):
        lines = []
        for body, _ in BODIES:
            mine = [row for row in rows if row.name == body]
            x = np.array([row.force for row in mine])
            y = np.array([100 * getattr(row.lattice, name) for row in mine])
            lines.append(Line(body, x, y))
        panels.append(Panel(title, "cells against finite elements", tuple(lines)))
    scale = Scale(
        x="load (N)",
        y="relative L2 (%)",
        log_x=True,
        log_y=True,
        x_ticks=LOADS,
        x_limits=(0.17, 3.5),
    )
    caption = (
        "The contact solver on cells of 0.25 mm against finite elements, by indenter and load."
    )
    return Picture("errors", caption, png_of(draw_panels(panels, scale, columns=2)))
