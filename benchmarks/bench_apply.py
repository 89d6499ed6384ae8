"""Cost of one reading: the paper's algorithm every time, and the operator prepared once.

Run: python benchmarks/bench_apply.py [--nodes 10 20 30 40] [--json FILE]

One table in one run. The paper's algorithm interpolates on a Delaunay triangulation, builds C,
inverts it and computes the displacements for each reading; the prepared operator is one
matrix-vector product with the same outputs (pressure and three components of displacement,
float32). `read` is the floor: a pass over the operator's bytes that only adds them up.
"""

import argparse
import json
import os
import platform
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before NumPy: one core, no spinning threads

import numpy as np
from numba import njit

import skinfield as sf
from skinfield.lab.bench.machine import laps as lap
from skinfield.lab.paper import reconstruct_as_paper


@njit(fastmath=True)
def add_up(values: np.ndarray) -> float:
    """One pass over the bytes, as fast as the machine reads them."""
    total = np.float32(0)
    for index in range(values.size):  # an index: iteration does not become SIMD code
        total += values[index]
    return total


def row(nodes: int, paper_laps: int, laps: int) -> dict[str, float]:
    """Times of one grid, in seconds."""
    patch, layer = sf.layouts.hexagon72(), sf.Layer(2e-3, 100e3, 0.5)
    grid = sf.Grid.square(patch, nodes=nodes)
    readings = np.random.default_rng(0).normal(scale=0.01, size=len(patch))
    rec = sf.Reconstructor(
        patch,
        layer,
        grid,
        mechanics=sf.HalfSpace(),
        quantity=sf.BaseStress(pad_averaged=False),
        solver=sf.Inverse(),
        precision=np.float32,
    )
    paper = lap(
        lambda: reconstruct_as_paper(readings, patch.plane, grid.plane, layer, grid.cell_area),
        paper_laps,
        1,
    )
    single, out = readings.astype(np.float32), np.empty(4 * len(grid), np.float32)
    operator = rec.operator.ravel(order="K")
    prepared, read = [], []
    for _ in range(10):  # in turn, so that both see the same machine
        prepared.append(lap(lambda: rec.apply(single, out), laps // 10, laps // 100))
        read.append(lap(lambda: add_up(operator), laps // 10, laps // 100))
    return {
        "nodes": nodes,
        "bytes": rec.operator.nbytes,
        "paper_mean_s": float(paper.mean()),
        "paper_std_s": float(paper.std()),
        "prepared_p50_s": float(np.median(prepared)),
        "prepared_p99_s": float(np.percentile(prepared, 99)),
        "read_p50_s": float(np.median(read)),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, nargs="+", default=[10, 20, 30, 40])
    parser.add_argument("--laps", type=int, default=5000, help="of the prepared operator")
    parser.add_argument("--paper-laps", type=int, default=5, help="of the paper's algorithm")
    parser.add_argument("--json", help="file for the numbers")
    options = parser.parse_args()
    print(f"{platform.machine()}, Python {platform.python_version()}, NumPy {np.__version__}")
    columns = ["nodes", "paper ms", "prepared µs p50 / p99", "ratio", "MB", "read µs", "over read"]
    print(f"| {' | '.join(columns)} |\n|{' --- |' * len(columns)}")
    rows = []
    for nodes in options.nodes:
        found = row(nodes, options.paper_laps, options.laps)
        rows.append(found)
        paper, prepared, read = (
            found[name] for name in ("paper_mean_s", "prepared_p50_s", "read_p50_s")
        )
        print(
            f"| {nodes} x {nodes} | {paper * 1e3:.1f} ± {found['paper_std_s'] * 1e3:.1f} "
            f"| {prepared * 1e6:.1f} / {found['prepared_p99_s'] * 1e6:.1f} "
            f"| {paper / prepared:.0f} | {found['bytes'] / 1e6:.2f} | {read * 1e6:.1f} "
            f"| {prepared / read:.2f} |",
            flush=True,
        )
    if options.json:
        Path(options.json).write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
