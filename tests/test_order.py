"""Recordings of another layout are noted, those with times in another unit refused."""

from pathlib import Path

import numpy as np
import pytest
from command_line import refused, run

import skinfield as sf
from skinfield.reconstruct.diagnostics import TELL_ORDER, order_note, partners

PATCH = sf.layouts.hexagon72()


def strokes(seed: int = 0) -> np.ndarray:
    """Counts (T, 72) of a fingertip that strokes to and fro, rest at 240."""
    rng, readings = np.random.default_rng(seed), 600
    time = np.arange(readings)
    at = 20e-3 * np.stack([np.sin(0.21 * time), np.cos(0.083 * time)], axis=1)
    away = np.linalg.norm(PATCH.plane[None] - at[:, None], axis=-1)
    counts = 240.0 - 90.0 * np.exp(-np.square(away / 6e-3)) + rng.normal(0.0, 0.6, away.shape)
    return np.asarray(np.rint(counts))


def test_taxels_that_read_together_are_neighbours() -> None:
    count, near, chance = partners(strokes(), PATCH)
    assert count >= TELL_ORDER
    assert near > 0.8 > 4 * chance
    assert not order_note(strokes(), PATCH)


@pytest.mark.parametrize("seed", range(5))
def test_columns_in_another_order_are_noted(seed: int) -> None:
    order = np.random.default_rng(seed).permutation(72)
    (note,) = order_note(strokes()[:, order], PATCH)
    assert "lie side by side on 'hexagon72'" in note


def test_noise_and_single_pokes_are_no_order() -> None:
    rng = np.random.default_rng(1)
    assert not order_note(rng.normal(240.0, 0.6, (500, 72)), PATCH)
    pokes = np.full((500, 72), 240.0)
    pokes[np.arange(500), rng.integers(0, 72, 500)] = 150.0
    assert not order_note(pokes, PATCH)
    assert not order_note(np.full((5, 72), np.nan), PATCH)
    together = rng.normal(240.0, 0.6, (200, 72))
    plate = rng.normal(240.0, 0.6, (600, 72))
    plate[::20, :20] -= 60.0 * rng.uniform(0.5, 1.0, (30, 1))
    assert not order_note(plate, PATCH)
    together[50:80] -= 40.0 * rng.uniform(0.5, 1.0, (30, 1))  # of a palm, or of the board
    assert not order_note(together, PATCH)


def written(path: Path, counts: np.ndarray, time: str, step: float) -> Path:
    names = ",".join(f"taxel_{k}" for k in range(counts.shape[1]))
    rows = [f"{k * step:g}," + ",".join(f"{c:.0f}" for c in row) for k, row in enumerate(counts)]
    path.write_text(f"# unit = count\n{time},{names}\n" + "\n".join(rows) + "\n")
    return path


def test_milliseconds_are_no_seconds(tmp_path: Path) -> None:
    counts = strokes()[:60]
    wrong = written(tmp_path / "a.csv", counts, "time_s", 20.0)
    said = refused("reconstruct", wrong, "--skin", "hexagon72", "-o", tmp_path / "a_out.csv")
    assert "20 s apart" in said
    assert "time_ms" in said
    right = written(tmp_path / "b.csv", counts, "time_ms", 20.0)
    assert "60 readings in 1.18 s" in run("reconstruct", right, "--skin", "hexagon72")
