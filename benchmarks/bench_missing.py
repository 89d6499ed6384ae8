"""Cost of taxels that do not answer: by what is prepared for all of them, and prepared anew.

Run: python benchmarks/bench_missing.py [--nodes 20 40 80] [--readings 1000] [--missing 3]

One table in one run. `new set` is a reading that lacks taxels that never lacked together before,
`known set` one that lacks the same as the one before, to its pressure and then with its contacts;
`anew` is the same by a solver that is prepared for the taxels that are left. `all different` are
readings in one call, each of which lacks taxels of its own, with their contacts; `none missing` as
many that lack none. Times are the shortest of many laps.
"""

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import replace

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before NumPy: one core, no spinning threads

import numpy as np

import skinfield as sf
from skinfield.elastic import ObservationModel


class Anew:
    """The same operator, which does not say how it answers without some of its taxels."""

    def __init__(self, solver: sf.GaussianField) -> None:
        self.solver = solver

    def prepare(self, model: ObservationModel) -> sf.solve.LinearOperator:
        return replace(self.solver.prepare(model), solver=self, gaussian=None)


def shortest(work: Callable[[int], object], laps: int) -> float:
    """Seconds of the quickest lap."""
    best = np.inf
    for lap in range(laps):
        start = time.perf_counter()
        work(lap)
        best = min(best, time.perf_counter() - start)
    return best


def row(nodes: int, count: int, missing: int) -> str:
    """Times of one grid."""
    patch, rng = sf.layouts.hexagon72(), np.random.default_rng(0)
    grid = sf.Grid.square(patch, nodes=nodes)
    mine = sf.Reconstructor(patch, grid=grid, solver=sf.GaussianField())
    anew = sf.Reconstructor(patch, grid=grid, solver=Anew(sf.GaussianField()))
    readings = rng.normal(size=(count, len(patch))) * mine.model.noise_std
    valid = np.ones((count, len(patch)), dtype=bool)
    for mask in valid:
        mask[rng.choice(len(patch), missing, replace=False)] = False
    times = [
        shortest(lambda lap: mine(readings[lap]), 100),
        shortest(lambda lap: mine(readings[lap], valid=valid[0]), 100),
        shortest(lambda lap: mine(readings[lap], valid=valid[lap + 1]), 100),
        shortest(lambda lap: mine(readings[lap]).contacts, 100),
        shortest(lambda lap: mine(readings[lap], valid=valid[0]).contacts, 100),
        shortest(lambda lap: mine(readings[lap], valid=valid[lap + 200]).contacts, 100),
        shortest(lambda lap: anew(readings[lap], valid=valid[lap + 1]).contacts, 10),
        shortest(lambda lap: mine(readings), 3),
        shortest(lambda lap: mine(readings, valid=valid), 3),
    ]
    cells = [f"{seconds * 1e3:.3g}" for seconds in times]
    return f"| {nodes} x {nodes} | {' | '.join(cells)} | {times[6] * count * 1e3:.0f} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, nargs="+", default=[20, 40, 80])
    parser.add_argument("--readings", type=int, default=1000, help="in one call, 300 or more")
    parser.add_argument("--missing", type=int, default=3, help="taxels that each reading lacks")
    options = parser.parse_args()
    print("ms; 72 taxels, GaussianField, of which each reading lacks", options.missing)
    kinds = ["none missing", "known set", "new set"]
    columns = ["grid", *kinds, *(f"{kind}, contacts" for kind in kinds), "anew, contacts"]
    columns += [f"{options.readings} readings, none missing", "all different", "anew (10 taken)"]
    print(f"| {' | '.join(columns)} |\n|{' --- |' * len(columns)}")
    for nodes in options.nodes:
        print(row(nodes, max(options.readings, 300), options.missing), flush=True)


if __name__ == "__main__":
    main()
