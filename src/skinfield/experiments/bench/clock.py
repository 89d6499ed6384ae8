"""Laps of the clock, and what many of them come to."""

import gc
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats

PERCENTILES = (10, 50, 90, 99)
Spread = dict[str, float]  # count, mean, std, min, p10, p50, p90, p99, max


@contextmanager
def undisturbed() -> Iterator[None]:
    """Without garbage collection, which would fall into some lap and not into others."""
    was = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()


@contextmanager
def settled() -> Iterator[None]:
    """With what is there by now left out of garbage collections: each `undisturbed` needs one."""
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


def laps(function: Callable[[], object], count: int) -> Floats:
    """Seconds of each of `count` calls."""
    out = np.empty(count)
    for index in range(count):
        start = time.perf_counter_ns()
        function()
        out[index] = time.perf_counter_ns() - start
    return out * 1e-9


def spread(values: ArrayLike, scale: float = 1.0) -> Spread | None:
    """Mean, deviation, ends and percentiles of the numbers among `values`, times `scale`.

    None if there is no number among them.
    """
    found = np.asarray(values, dtype=np.float64).ravel() * scale
    found = found[np.isfinite(found)]
    if not len(found):
        return None
    named = zip(PERCENTILES, np.percentile(found, PERCENTILES).tolist(), strict=True)
    return {
        "count": len(found),
        "mean": float(found.mean()),
        "std": float(found.std()),
        "min": float(found.min()),
        **{f"p{percent}": value for percent, value in named},
        "max": float(found.max()),
    }
