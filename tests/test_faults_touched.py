"""Faults of skins that are touched: what is touched is not faulty, and what is faulty is found."""

import numpy as np
import pytest

import skinfield as sf
from skinfield.signal import CySkinCount, Verdict

PATCH = sf.layouts.hexagon72()


def skin(seconds: float, rate: float, seed: int, clipped: bool) -> tuple[np.ndarray, np.ndarray]:
    """Counts of a skin that is touched in half of the time; taxels that ever are."""
    rng = np.random.default_rng(seed)
    readings = int(seconds * rate)
    scale = 40.0 * np.exp(0.6 * rng.standard_normal(len(PATCH)))
    counts = scale * rng.standard_t(3.0, (readings, len(PATCH)))
    ever = np.zeros(len(PATCH), np.bool_)
    length = int(0.5 * rate)
    for first in range(0, readings, 2 * length):
        middle = PATCH.plane[rng.integers(len(PATCH))]
        away = np.linalg.norm(PATCH.plane - middle, axis=1) / PATCH.pitch
        touch = 9000.0 * np.exp(-0.5 * np.square(away))
        counts[first : first + length] += touch * rng.uniform(0.6, 1.0)
        ever |= touch > 3000.0
    return np.rint(np.clip(counts, 0.0, None) if clipped else counts + 20000.0), ever


@pytest.mark.parametrize("clipped", [True, False])
@pytest.mark.parametrize("rate", [10.0, 50.0])
def test_what_is_touched_is_not_faulty(rate: float, clipped: bool) -> None:
    lost = touched = false = 0
    for seed in range(8):
        counts, ever = skin(5.0, rate, seed, clipped)
        usable = sf.find_faults(counts, PATCH, CySkinCount() if clipped else None).usable
        lost, touched = lost + int((ever & ~usable).sum()), touched + int(ever.sum())
        false += int((~usable).sum())
    assert touched > 100
    assert lost <= 1  # whose own noise is far beyond that of the others
    assert false <= 2  # of 576


@pytest.mark.parametrize("rate", [20.0, 50.0])
def test_taxels_far_noisier_than_all_others_are_found(rate: float) -> None:
    found = 0
    for seed in range(10):
        counts, _ = skin(5.0, rate, seed, clipped=False)
        rng = np.random.default_rng(seed)
        broken = int(rng.integers(len(PATCH)))
        counts[:, broken] += np.rint(6000.0 * rng.standard_normal(len(counts)))
        found += sf.find_faults(counts, PATCH).verdict[broken] == Verdict.NOISY
    assert found >= 9
