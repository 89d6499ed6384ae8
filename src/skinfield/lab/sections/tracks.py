"""Tracking in the report: how often numbers of contacts change, and how near the tracks are."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skinfield.errors import Floats
from skinfield.lab.plots import BROAD, DOTS, Curve, Panel, Scale, draw_panels
from skinfield.lab.report import Cell, Missing, Part, Picture, Section, Settings, Table
from skinfield.lab.tracking import NEAREST, QUANTITIES, SOLVERS, TRACKER, added, run_of
from skinfield.plot.style import number

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
DRAWN = (("slide", "cross"), ("roll", "meet"))  # scenes of the picture
IN_TIME = ("roll", "meet")  # along the direction of motion, against time
TITLES = {
    "slide": "Slide of 40 mm",
    "cross": "Two that pass at 12 mm",
    "roll": "To and fro, with changing force",
    "meet": "Two that meet at 5 mm",
}


def tracks_parts(settings: Settings) -> list[Part]:
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
    summed = {key: added([r for r in rows if _key(r) == key]) for key in keys}
    return Section(
        name="tracks",
        title="Contacts over time",
        claim="",
        sentences=tuple(_sentences(summed, settings)),
        pictures=tuple(pictures_of_tracks([p for result in known for p in result["pictures"]])),
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
        parts = []
        for method in (TRACKER, NEAREST):
            each = [mine[scene, method] for scene in SCENES if (scene, method) in mine]
            touch = sum(row["touch_s"] for row in each)
            rate = sum(row["switches"] for row in each) / touch
            whole, balls = (sum(row[name] for row in each) for name in ("whole", "contacts"))
            parts.append(f"{method} {number(rate, 2)} and {whole} of {balls}")
        tracked, raw = mine["slide", TRACKER], mine["slide", NEAREST]
        words.append(
            f"{quantity.capitalize()}, {solver}: switches per second of touch, and whole balls: "
            f"{'; '.join(parts)}. On the slide the place is off by "
            f"{number(_rms(tracked['place_mm']), 2)} mm (root mean square; single readings "
            f"{number(_rms(raw['place_mm']), 2)} mm), the force by "
            f"{number(_rms(tracked['force_N']), 2)} N ({number(_rms(raw['force_N']), 2)} N), the "
            f"velocity by {number(_rms(tracked['speed_mm_s']), 2)} mm/s."
        )
    return words


def _numbers(summed: dict[Any, dict[str, Any]]) -> Table:
    rows = []
    for (quantity, solver, scene, method), row in summed.items():
        events = [f"{count} {kind}" for kind, count in row["events"].items()]
        cells: dict[str, Cell] = {
            "reads": quantity,
            "solver": solver,
            "scene": SCENES[scene],
            "numbered by": method,
            "switches": row["switches"],
            "per second": _share(row["switches"], row["touch_s"]),
            "per ball": _share(row["switches"], row["contacts"]),
            "whole": f"{row['whole']} of {row['contacts']}",
            "missed per reading": _share(row["missed"], row["readings"]),
            "false per reading": _share(row["false"], row["readings"]),
            "coasting per reading": _share(row["coasting"], row["readings"]),
            "events": ", ".join(events),
        }
        rows.append(cells)
    caption = "Numbers of contacts (CLEAR MOT, Bernardin and Stiefelhagen 2008)."
    return Table.of("numbers", caption, rows)


def _share(count: float, of: float) -> float | None:
    return count / of if of else None


def _errors(summed: dict[Any, dict[str, Any]]) -> Table:
    rows = []
    for (quantity, solver, scene, method), row in summed.items():
        if not row["place_mm"]:
            continue
        filtered = method == TRACKER
        cells: dict[str, Cell] = {
            "reads": quantity,
            "solver": solver,
            "scene": SCENES[scene],
            "what": "filtered" if filtered else "single readings",
            "place, rms (mm)": _rms(row["place_mm"]),
            "place, p90 (mm)": float(np.quantile(row["place_mm"], 0.9)),
            "force, rms (N)": _rms(row["force_N"]),
        }
        if filtered:
            cells |= {
                "velocity, rms (mm/s)": _rms(row["speed_mm_s"]),
                "squared place error over its variance, mean": float(np.mean(row["nees"])) / 2,
                "median": float(np.median(row["nees"])) / MEDIAN,
                "the same of velocity, mean": float(np.mean(row["nees_speed"])) / 2,
            }
        rows.append(cells)
    caption = (
        "Errors of contacts that belong to a ball (within 8 mm). Squared errors are over what the "
        "filter states, per axis, so that 1 is right; the median is over that of the χ² "
        "distribution."
    )
    return Table.of("errors", caption, rows)


def pictures_of_tracks(pictures: Sequence[dict[str, Any]]) -> list[Picture]:
    """One for each quantity and solver of which the scenes are there."""
    out = []
    for key in dict.fromkeys((each["quantity"], each["solver"]) for each in pictures):
        mine = {e["scene"]: e for e in pictures if (e["quantity"], e["solver"]) == key}
        figure = draw_panels([[_panel(mine[name]) for name in row] for row in DRAWN], 3.0)
        quantity, solver = key
        caption = (
            f"{quantity.capitalize()}, {solver}: places of the balls (grey), of the contacts of "
            "single readings (dots), and of the tracker's contacts, one colour and number per "
            "track. Below, along the direction of motion."
        )
        out.append(Picture.of(f"{quantity}-{solver}".lower(), caption, figure))
    return out


def _panel(scene: dict[str, Any]) -> Panel:
    """Ways of the balls, contacts of single readings and tracks: places, or along the motion."""
    name, period = scene["scene"], scene["period"]
    truth = 1e3 * np.array(scene["truth"])  # (T, B, 2) mm
    scale = Scale(x="x (mm)", y="y (mm)", equal=True)
    middle, direction = truth.mean(axis=(0, 1)), np.zeros(2)
    if name in IN_TIME:
        direction = np.linalg.svd((truth - middle).reshape(-1, 2), full_matrices=False)[2][0]
        scale = Scale(x="time (s)", y="place along the motion (mm)")

    def way(index: Floats, places: Floats) -> tuple[Floats, Floats]:
        if name in IN_TIME:
            return period * index, (places - middle) @ direction
        return places[:, 0], places[:, 1]

    steps = np.arange(len(truth), dtype=np.float64)
    curves = [
        Curve("truth", *way(steps, truth[:, ball]), look=BROAD) for ball in range(truth.shape[1])
    ]
    raw = [np.array(each)[:, :3] for each in scene["raw"].values()]
    if raw:
        dots = np.concatenate(raw)
        curves.append(Curve("single readings", *way(dots[:, 0], dots[:, 1:]), look=DOTS))
    for turn, (number_of, line) in enumerate(scene["tracks"].items()):
        each = np.array(line)
        curves.append(Curve(f"track {turn + 1}", *way(each[:, 0], each[:, 1:3]), tag=number_of))
    return Panel(TITLES[name], _note(scene), tuple(curves), scale)


def _note(scene: dict[str, Any]) -> str:
    """Events but the motion, with their times."""
    events = [e for e in scene["events"] if e["kind"] in ("merged", "split", "lost")]
    words = [f"{e['kind']} {'/'.join(map(str, e['ids']))} at {e['time']:.2f} s" for e in events[:4]]
    return ", ".join(words) or "no number is lost"
