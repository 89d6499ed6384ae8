"""Readings per second of long recordings, and what it costs to keep readings in place of fields.

Run: python benchmarks/bench_batch.py [--nodes 20 40 80] [--seconds 0.4] [--json FILE]

Three tables in one run, hexagon72, GaussianField, one thread of the BLAS per process:

* readings per second and core. `bulk` is what `BulkFields` does from readings in double precision:
  look for missing taxels, linearise the capacitance, round to single precision, multiply. `floor`
  is the matrix product alone (numpy.dot with `out`, operands ready). P is the pressure, P+u the
  normal displacement beside it, all four the pressure and three components. Best lap of many, in
  turn; a star marks the chunk that is taken by default.
* what `skinfield reconstruct` does with an hour at 50 Hz from the file of results, in one process
  and in all: the pressure of each reading and its sum; contacts with all that a table of them
  holds; a non-negative field. Processes have prepared before the clock starts.
* bytes of that hour as readings and as fields, and how long a slice takes to be computed.
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
from skinfield.campaign import in_order
from skinfield.cli.reconstruct_work import PIECE, Task, Worker, cores
from skinfield.pipeline.batch import BulkProduct
from skinfield.pipeline.batch_fields import BulkFields

PATCH = sf.layouts.hexagon72()
OUTPUTS = {
    "P": ("pressure",),
    "P+u": ("pressure", "indentation"),
    "all four": ("pressure", "displacement"),
}
CHUNKS = (64, 128, 256, 512, 4096)
HOUR = 180_000  # readings of 50 Hz
NOISE = 0.002


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


def throughput(nodes: int, seconds: float) -> list[dict[str, object]]:
    """Readings per second of one grid, for all outputs and chunks."""
    made = sf.Reconstructor(PATCH, grid=sf.Grid.square(PATCH, nodes=nodes))
    readings, found = readings_of(4096), []
    for label, names in OUTPUTS.items():
        for chunk in CHUNKS:
            bulk = BulkFields(made, names)
            usual, bulk.run = bulk.run, chunk
            out, part = np.empty((chunk, bulk.width), np.float32), readings[:chunk]
            product: BulkProduct = bulk._product(np.ones(len(PATCH), bool))
            single = part.astype(np.float32)
            laps = best(
                {
                    "bulk": lambda bulk=bulk, part=part, out=out: bulk.into(part, out),
                    "floor": lambda a=single, b=product._transposed, out=out: np.dot(a, b, out=out),
                },
                seconds,
            )
            rates = {name: chunk / lap for name, lap in laps.items()}
            row = {"nodes": nodes, "outputs": label, "chunk": chunk, "usual": usual == chunk}
            found.append(row | rates)
    return found


def hour(folder: Path, nodes: int) -> dict[str, object]:
    """An hour from the disk: bytes, processes, slices."""
    path, raw = folder / f"hour{nodes}.skinfield", readings_of(HOUR)
    counts = np.rint(raw * 20_000) / 20_000  # as a board of 16 bits sends them
    grid = sf.Grid.square(PATCH, nodes=nodes)
    made = sf.Reconstructor(PATCH, grid=grid)
    sf.save_results(path, made, counts, np.arange(HOUR) * 20_000_000)
    found: dict[str, object] = {"nodes": nodes, "slices": slices(path), "bytes": sizes(path, nodes)}
    iterative = folder / f"iterative{nodes}.skinfield"
    other = sf.Reconstructor(PATCH, grid=grid, solver=sf.NonNegative())
    sf.save_results(iterative, other, counts[:4096])
    rates = {"pressure and sum": (Task(path, False, False), PIECE["fields"], HOUR)}
    rates["contacts"] = Task(path, True, False), PIECE["contacts"], 16384
    rates["non-negative"] = Task(iterative, False, False), PIECE["iterative"], 4096
    for what, (task, size, count) in rates.items():
        for processes in sorted({1, cores()}):
            found[f"{what} in {processes}"] = _rate(task, size, count, processes)
    return found


def _rate(task: Task, size: int, count: int, processes: int) -> float:
    """Readings per second, once every process has prepared (most likely)."""
    pieces = [(first, min(first + size, count)) for first in range(0, count, size)]
    warm = [(0, min(size, count))] * processes * 3
    answers = in_order(Worker, (task,), warm + pieces, processes)
    for _ in warm:
        next(answers)
    begun = time.perf_counter()
    done = sum(len(part.force) for part in answers)
    return done / (time.perf_counter() - begun)


def sizes(path: Path, nodes: int) -> dict[str, float]:
    """Bytes of the hour, in single precision and as counts, and of its fields."""
    stored = sum(file.stat().st_size for file in path.iterdir())
    counts = stored - (path / "readings.npy").stat().st_size // 2
    return {"float32": stored, "int16": counts, "P+u": HOUR * nodes**2 * 8.0}


def slices(path: Path) -> dict[str, float]:
    """Seconds from a file that is open to an answer; the first of each from nothing computed."""
    results = sf.open_results(path)
    begun = time.perf_counter()
    results.pressure[0]
    found = {"open, prepare, first reading": time.perf_counter() - begun}

    def once(call: Callable[[int], object]) -> float:
        laps = []
        for turn in range(1, 12):
            results._cache.clear()
            begun = time.perf_counter()
            call(turn * 9000)
            laps.append(time.perf_counter() - begun)
        return min(laps)

    found["one reading, not computed before"] = once(lambda at: results.pressure[at + 77])
    results.pressure[77]
    laps = best({"again": lambda: results.pressure[78]}, 0.05)
    found["its neighbour"] = laps["again"]
    found["100 readings"] = once(lambda at: results.pressure[at : at + 100])
    found["100 readings, displacement"] = once(lambda at: results.displacement[at : at + 100])
    found["contacts of one reading"] = once(lambda at: results.contacts[at])
    return found


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, nargs="+", default=[20, 40, 80])
    parser.add_argument("--seconds", type=float, default=0.4, help="for each row")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    print(f"{platform.processor() or platform.machine()}, {cores()} cores, NumPy {np.__version__}")
    print("\nreadings/s/core       chunk      bulk     floor   bulk/floor")
    rows = [row for nodes in given.nodes for row in throughput(nodes, given.seconds)]
    for row in rows:
        name = f"{row['nodes']}x{row['nodes']} {row['outputs']}"
        rates = f"{row['bulk']:>9,.0f} {row['floor']:>9,.0f}"
        chunk = f"{row['chunk']:>5}{'*' if row['usual'] else ' '}"
        print(f"{name:<20} {chunk} {rates} {row['bulk'] / row['floor']:>10.0%}")
    with tempfile.TemporaryDirectory() as folder:
        hours = [hour(Path(folder), nodes) for nodes in given.nodes if nodes <= 40]
    print("\nan hour at 50 Hz, readings/s")
    for each in hours:
        rates = [f"{k}: {v:,.0f}" for k, v in each.items() if " in " in k]
        print(f"{each['nodes']}x{each['nodes']}  " + ", ".join(rates))
    print("\nan hour at 50 Hz, kept and looked at")
    for each in hours:
        kept = [f"{name} {size / 1e6:,.0f} MB" for name, size in each["bytes"].items()]
        print(f"{each['nodes']}x{each['nodes']}  " + ", ".join(kept))
        for name, seconds in each["slices"].items():
            print(f"       {seconds * 1e3:>9.3f} ms  {name}")
    if given.json:
        given.json.write_text(json.dumps({"throughput": rows, "hours": hours}, indent=1))


if __name__ == "__main__":
    main()
