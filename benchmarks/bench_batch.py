"""How long a slice of stored results takes, of an hour at 50 Hz.

Run: python benchmarks/bench_batch.py [--nodes 20 40] [--json FILE]

From a folder that is open to the answer: hexagon72, GaussianField, one thread of the BLAS.
"""

import argparse
import json
import os
import platform
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before NumPy: one core, no spinning threads

import numpy as np

import skinfield as sf

PATCH = sf.layouts.hexagon72()
HOUR = 180_000  # readings of 50 Hz
NOISE, SOLVER = 0.002, sf.GaussianField()


def readings_of(count: int) -> np.ndarray:
    """A touch that wanders, on and off, with noise."""
    rng, turn = np.random.default_rng(0), np.arange(count) * 2e-3
    place = 8e-3 * np.stack([np.cos(turn), np.sin(1.7 * turn)], axis=1) + PATCH.plane.mean(axis=0)
    away = np.square(PATCH.plane[None] - place[:, None]).sum(axis=2)
    touch = 0.15 * (np.sin(turn / 3) > 0)[:, None] * np.exp(-away / 5e-3**2)
    return touch + rng.normal(scale=NOISE, size=away.shape)


def best(calls: dict[str, Callable[[], object]], seconds: float) -> dict[str, float]:
    """Shortest lap of each call, all in turn, so that all see the same machine."""
    laps = dict.fromkeys(calls, np.inf)
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        for name, call in calls.items():
            begun = time.perf_counter()
            call()
            laps[name] = min(laps[name], time.perf_counter() - begun)
    return laps


def slices(folder: Path, nodes: int) -> dict[str, float]:
    """Seconds from a folder that is open to an answer, none of it computed before."""
    path = folder / f"hour{nodes}.skinfield"
    made = sf.Reconstructor(PATCH, grid=sf.Grid.square(PATCH, nodes=nodes), solver=SOLVER)
    sf.save_results(path, made, readings_of(HOUR), np.arange(HOUR) * 20_000_000)
    results = sf.open_results(path)
    results.pressure[0].compute()
    calls = {
        "one reading": lambda: results.pressure[9077].compute(),
        "100 readings": lambda: results.pressure[9000:9100].compute(),
        "100 readings, displacement": lambda: results.displacement[9000:9100].compute(),
        "contacts of 100 readings": lambda: sf.load_contacts(path, slice(9000, 9100)),
    }
    return best(calls, 2.0)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, nargs="+", default=[20, 40])
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    print(f"{platform.processor() or platform.machine()}, NumPy {np.__version__}")
    with tempfile.TemporaryDirectory() as folder:
        looks = {nodes: slices(Path(folder), nodes) for nodes in given.nodes}
    print("\nan hour at 50 Hz, stored and looked at")
    for nodes, laps in looks.items():
        for name, seconds in laps.items():
            print(f"{nodes}x{nodes} {seconds * 1e3:>9.3f} ms  {name}")
    if given.json:
        given.json.write_text(json.dumps({"slices": looks}, indent=1))


if __name__ == "__main__":
    main()
