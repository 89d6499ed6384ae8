"""Readings per second of bulk reconstruction, and how long a slice of stored results takes.

Run: python benchmarks/bench_batch.py [--nodes 20 40 80] [--seconds 0.4] [--json FILE]

Two tables in one run, hexagon72, GaussianField, one thread of the BLAS:

* readings per second and core. `bulk` is what `BulkFields` does from readings in double precision:
  look for missing taxels, linearise the capacitance, round to single precision, multiply. `floor`
  is the matrix product alone (numpy.dot with `out`, operands ready). P is the pressure, P+u the
  normal displacement beside it, all four the pressure and three components. Best lap of many, in
  turn, of 4096 readings.
* a slice out of an hour at 50 Hz, from a folder that is open to the answer.
"""

import argparse
import json
import os
import platform
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before NumPy: one core, no spinning threads

import numpy as np

import skinfield as sf
from skinfield.reconstruct.bulk import CHUNK, BulkFields

PATCH = sf.layouts.hexagon72()
OUTPUTS = {
    "P": ("pressure",),
    "P+u": ("pressure", "indentation"),
    "all four": ("pressure", "displacement"),
}
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


def multiply(table: np.ndarray, matrices: list[np.ndarray], outs: list[np.ndarray]) -> None:
    """Products of the readings with each matrix, chunk by chunk."""
    for matrix, out in zip(matrices, outs, strict=True):
        for first in range(0, len(table), CHUNK):
            part = slice(first, first + CHUNK)
            np.dot(table[part], matrix, out=out[part])


def throughput(nodes: int, seconds: float) -> list[dict[str, object]]:
    """Readings per second of one grid, for all outputs."""
    made = sf.Reconstructor(PATCH, grid=sf.Grid.square(PATCH, nodes=nodes), solver=SOLVER)
    readings, found = readings_of(4096), []
    every, single = np.ones(len(PATCH), bool), readings.astype(np.float32)
    for label, names in OUTPUTS.items():
        bulk = BulkFields(made, names)
        matrices = [bulk._matrix(name, every) for name in names]
        outs = [np.empty((len(single), matrix.shape[1]), np.float32) for matrix in matrices]
        calls: dict[str, Callable[[], object]] = {
            "bulk": partial(bulk, readings),
            "floor": partial(multiply, single, matrices, outs),
        }
        laps = best(calls, seconds)
        rates = {name: len(readings) / lap for name, lap in laps.items()}
        found.append({"nodes": nodes, "outputs": label} | rates)
    return found


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
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, nargs="+", default=[20, 40, 80])
    parser.add_argument("--seconds", type=float, default=0.4, help="for each row")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    print(f"{platform.processor() or platform.machine()}, NumPy {np.__version__}")
    print("\nreadings/s/core            bulk     floor   bulk/floor")
    rows = [row for nodes in given.nodes for row in throughput(nodes, given.seconds)]
    for row in rows:
        name = f"{row['nodes']}x{row['nodes']} {row['outputs']}"
        rates = f"{row['bulk']:>9,.0f} {row['floor']:>9,.0f}"
        print(f"{name:<20} {rates} {row['bulk'] / row['floor']:>10.0%}")
    with tempfile.TemporaryDirectory() as folder:
        looks = {nodes: slices(Path(folder), nodes) for nodes in given.nodes if nodes <= 40}
    print("\nan hour at 50 Hz, stored and looked at")
    for nodes, laps in looks.items():
        for name, seconds in laps.items():
            print(f"{nodes}x{nodes} {seconds * 1e3:>9.3f} ms  {name}")
    if given.json:
        given.json.write_text(json.dumps({"throughput": rows, "slices": looks}, indent=1))


if __name__ == "__main__":
    main()
