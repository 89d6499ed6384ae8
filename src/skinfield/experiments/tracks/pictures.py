"""Tracks beside the truth."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skinfield.experiments.section import Picture
from skinfield.experiments.words import png_of
from skinfield.figures.tracks import TrackPanel, Way, draw_tracks

SHOWN = (("slide", "cross"), ("roll", "meet"))
IN_TIME = ("roll", "meet")  # along the direction of motion, against time
TITLES = {
    "slide": "Slide of 40 mm",
    "cross": "Two that pass at 12 mm",
    "roll": "To and fro, with changing force",
    "meet": "Two that meet at 5 mm",
}


def picture_of_tracks(pictures: Sequence[dict[str, Any]]) -> list[Picture]:
    """One for each quantity and solver of which the scenes were kept."""
    found = []
    for key in dict.fromkeys((each["quantity"], each["solver"]) for each in pictures):
        mine = {e["scene"]: e for e in pictures if (e["quantity"], e["solver"]) == key}
        rows = [[_panel(mine[name]) for name in row] for row in SHOWN]
        quantity, solver = key
        caption = (
            f"{quantity.capitalize()}, {solver}: places of the balls (grey), of the contacts of "
            "single readings (dots), and of the tracker's contacts, one colour and number per "
            "track. Below, along the direction of motion."
        )
        name = f"{quantity}-{solver}".lower()
        found.append(Picture(name, caption, png_of(draw_tracks(rows))))
    return found


def _panel(scene: dict[str, Any]) -> TrackPanel:
    name, period = scene["scene"], scene["period"]
    truth = 1e3 * np.array(scene["truth"])  # (T, B, 2) mm
    lines = {int(k): np.array(v) for k, v in scene["tracks"].items()}
    dots = [np.array(v) for v in scene["raw"].values()]
    raw = np.concatenate(dots)[:, :3] if dots else np.empty((0, 3))
    time = period * np.arange(len(truth))
    if name in IN_TIME:
        ways = truth - truth.mean(axis=(0, 1))
        direction = np.linalg.svd(ways.reshape(-1, 2), full_matrices=False)[2][0]
        middle = truth.mean(axis=(0, 1))

        def axis(points: Any) -> Any:
            return (points - middle) @ direction

        return TrackPanel(
            TITLES[name], _note(scene), "time (s)", "place along the motion (mm)",
            [Way(ball, time, axis(truth[:, ball])) for ball in range(truth.shape[1])],
            np.column_stack([period * raw[:, 0], axis(raw[:, 1:])]),
            [Way(k, period * v[:, 0], axis(v[:, 1:3])) for k, v in lines.items()],
        )  # fmt: skip
    return TrackPanel(
        TITLES[name], _note(scene), "x (mm)", "y (mm)",
        [Way(ball, truth[:, ball, 0], truth[:, ball, 1]) for ball in range(truth.shape[1])],
        raw[:, 1:], [Way(k, v[:, 1], v[:, 2]) for k, v in lines.items()], equal=True,
    )  # fmt: skip


def _note(scene: dict[str, Any]) -> str:
    """Events but the motion, with their times."""
    told = [e for e in scene["events"] if e["kind"] in ("merged", "split", "lost")]
    words = [f"{e['kind']} {'/'.join(map(str, e['ids']))} at {e['time']:.2f} s" for e in told[:4]]
    return ", ".join(words) or "no number is lost"
