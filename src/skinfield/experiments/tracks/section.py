"""Contacts over time in the report: how often numbers change, and how near the tracks are."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skinfield.experiments.section import Cell, Missing, Part, Section, Table
from skinfield.experiments.settings import Settings
from skinfield.experiments.tracks.pictures import picture_of_tracks
from skinfield.experiments.tracks.runs import ANEW, NEAREST, QUANTITIES, SOLVERS, TRACKER, run_of
from skinfield.experiments.tracks.switches import added
from skinfield.figures.style import number

REPEATS = {"smoke": 1, "short": 3, "full": 12}
MEDIAN = 1.386  # of χ² with two degrees of freedom
SCENES = {
    "slide": "slide of 40 mm at 40 mm/s",
    "roll": "to and fro, changing force",
    "cross": "two that pass at 12 mm",
    "meet": "two that meet at 5 mm",
    "taps": "five taps at one place",
    "idle": "noise alone",
}


def tracks_parts_of(settings: Settings) -> list[Part]:
    """All scenes with one solver, one by one; of the smoke size, one solver alone."""
    pairs = [(quantity, solver) for solver in SOLVERS for quantity in QUANTITIES]
    chosen = pairs[-2:-1] if settings.size.name == "smoke" else pairs
    return [
        Part(f"{quantity}-{solver}-{repeat}", run_of, (settings, quantity, solver, repeat))
        for quantity, solver in chosen
        for repeat in range(REPEATS[settings.size.name])
    ]


def tracks(settings: Settings, results: Sequence[dict[str, Any] | None]) -> Section | Missing:
    """The section from the results of its parts."""
    known = [result for result in results if result]
    if not known:
        return Missing("tracks: none of its parts could be computed")
    rows = [row for result in known for row in result["rows"]]
    keys = dict.fromkeys((r["quantity"], r["solver"], r["scene"], r["method"]) for r in rows)
    summed = {
        key: added([r for r in rows if _key(r) == key])
        | {"runs": sum(_key(r) == key for r in rows)}
        for key in keys
    }
    return Section(
        name="tracks",
        title="Contacts over time",
        claim="",
        sentences=tuple(_sentences(summed, settings)),
        pictures=tuple(picture_of_tracks([p for result in known for p in result["pictures"]])),
        tables=(_numbers(summed), _errors(summed)),
    )


def _key(row: dict[str, Any]) -> tuple[str, str, str, str]:
    return row["quantity"], row["solver"], row["scene"], row["method"]


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if values else float("nan")


def _sentences(summed: dict[Any, dict[str, Any]], settings: Settings) -> list[str]:
    words = [
        f"A ball of 12 mm moves over the paper's 72 taxels, read {settings.rate:g} times a second "
        "with a noise of 0.002 (capacitance) or 0.4 kPa (stress), at random places and directions. "
        "A switch is a reading in which a ball has another number than when it was seen last; a "
        "ball is whole that has one number from first to last.",
    ]
    for quantity, solver in dict.fromkeys(key[:2] for key in summed):
        mine = {key[2:]: row for key, row in summed.items() if key[:2] == (quantity, solver)}
        said = []
        for method in (TRACKER, NEAREST, ANEW):
            each = [mine[scene, method] for scene in SCENES if (scene, method) in mine]
            touch = sum(row["touch_s"] for row in each)
            rate = sum(row["switches"] for row in each) / touch
            whole, balls = (sum(row[name] for row in each) for name in ("whole", "contacts"))
            said.append(f"{method} {number(rate, 2)} and {whole} of {balls}")
        tracked, raw = mine["slide", TRACKER], mine["slide", ANEW]
        words.append(
            f"{quantity.capitalize()}, {solver}: switches per second of touch, and whole balls: "
            f"{'; '.join(said)}. On the slide the place is off by "
            f"{number(_rms(tracked['place_mm']), 2)} mm (root mean square; single readings "
            f"{number(_rms(raw['place_mm']), 2)} mm), the force by "
            f"{number(_rms(tracked['force_N']), 2)} N ({number(_rms(raw['force_N']), 2)} N), the "
            f"velocity by {number(_rms(tracked['speed_mm_s']), 2)} mm/s."
        )
    return words


def _numbers(summed: dict[Any, dict[str, Any]]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for (quantity, solver, scene, method), row in summed.items():
        told = [f"{count} {kind}" for kind, count in row.get("events", {}).items() if count]
        counts = [row["missed"], row["false"], row["coasting"]]
        cells: list[Cell] = [
            quantity,
            solver,
            SCENES[scene],
            method,
            row["switches"],
            _share(row["switches"], row["touch_s"]),
            _share(row["switches"], row["contacts"]),
            f"{row['whole']} of {row['contacts']}",
            *(_share(count, row["readings"]) for count in counts),
            ", ".join(told),
        ]
        rows.append(tuple(cells))
    columns = (
        "reads", "solver", "scene", "numbered by", "switches", "per second", "per ball", "whole",
        "missed per reading", "false per reading", "coasting beside per reading", "events",
    )  # fmt: skip
    caption = "Numbers of contacts (CLEAR MOT, Bernardin and Stiefelhagen 2008)."
    return Table("numbers", caption, columns, tuple(rows))


def _share(count: float, of: float) -> float | None:
    return count / of if of else None


def _errors(summed: dict[Any, dict[str, Any]]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for (quantity, solver, scene, method), row in summed.items():
        if not row["place_mm"] or method == NEAREST:
            continue
        cells: list[Cell] = [
            quantity,
            solver,
            SCENES[scene],
            "filtered" if method == TRACKER else "single readings",
            _rms(row["place_mm"]),
            float(np.quantile(row["place_mm"], 0.9)),
            _rms(row["force_N"]),
        ]
        filtered: list[Cell] = [None] * 4
        if method == TRACKER:
            filtered = [
                _rms(row["speed_mm_s"]),
                float(np.mean(row["nees"])) / 2,
                float(np.median(row["nees"])) / MEDIAN,
                float(np.mean(row["nees_speed"])) / 2,
            ]
        rows.append((*cells, *filtered))
    columns = (
        "reads", "solver", "scene", "what", "place, rms (mm)", "place, p90 (mm)", "force, rms (N)",
        "velocity, rms (mm/s)", "squared place error over its variance, mean", "median",
        "the same of velocity, mean",
    )  # fmt: skip
    caption = (
        "Errors of contacts that belong to a ball (within 8 mm). Squared errors are over what the "
        "filter states, per axis, so that 1 is right; the median is over that of the χ² "
        "distribution."
    )
    return Table("errors", caption, columns, tuple(rows))
