"""Cost of contacts of one reading: found, with all they state, as rows, and by their definition.

Run: python benchmarks/bench_contacts.py [--nodes 20 40 80] [--laps 1000] [--json FILE]

One table in one run, on one thread, p50 and p99 in µs. Domes of 6 mm radius press a hexagon of 72
taxels; the field is `GaussianField`'s answer to their readings with noise, and contacts are found
as a reconstructor finds them. `found`: with place, force, area, axes and their covariance. `all`:
also the outline of each contact, which otherwise waits until it is asked for. `definition`: the
same contacts step by step with NumPy, as in tests/contacts_reference.py, with its loop over cells
compiled. `floor`: one pass over the field that only adds it up.
"""

import argparse
import json
import os
import platform
import sys
from collections.abc import Callable
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before NumPy: one core, no spinning threads
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

import contacts_reference as reference
import numpy as np
from bench_apply import add_up
from numba import njit

import skinfield as sf
from skinfield.estimate import Contact
from skinfield.lab.bench.machine import laps as lap

reference.flooded = njit(reference.flooded)
PLACES = np.array([[-9e-3, -9e-3], [9e-3, 9e-3], [12e-3, -12e-3]])
COLUMNS = ("found", "all", "definition", "floor")


def domes(grid: sf.Grid, count: int) -> np.ndarray:
    """Paraboloids of 20 kPa."""
    middle, total = grid.plane.mean(axis=0), np.zeros(len(grid))
    for place in PLACES[:count]:
        square = ((grid.plane - middle - place) ** 2).sum(axis=1)
        total += 2e4 * np.maximum(0.0, 1.0 - square / 6e-3**2)
    return total


def ask_for_all(contacts: tuple[Contact, ...]) -> None:
    """Work out what waits."""
    for contact in contacts:
        _ = contact.outline


def row(rec: sf.Reconstructor, count: int, laps: int) -> dict[str, object]:
    """Times in seconds with some contacts on one grid."""
    grid, plan, finder = rec.grid, rec.plan, rec.finder
    truth = domes(grid, count)
    noise = np.random.default_rng(count).normal(size=len(rec.patch)) * rec.model.noise_std
    readings = rec.model.matrix @ truth + noise * (count > 0)  # idle: none at all
    pressure = np.ascontiguousarray(rec.operator[: len(grid)] @ readings)

    def find() -> tuple[Contact, ...]:
        return rec.plans.find(plan, pressure)

    work: dict[str, tuple[Callable[[], object], int]] = {
        "found": (find, laps),
        "all": (lambda: ask_for_all(find()), laps),
        "definition": (
            lambda: reference.contacts(
                finder, grid, pressure, plan.noise, plan.posterior, plan.model_error
            ),
            max(laps // 10, 5),
        ),
        "floor": (lambda: add_up(pressure), laps),
    }
    times = {name: lap(call, count, 1) for name, (call, count) in work.items()}
    made: dict[str, object] = {"nodes": grid.shape[0], "pressed": count, "contacts": len(find())}
    for name, spent in times.items():
        made[f"{name}_p50_s"] = float(np.median(spent))
        made[f"{name}_p99_s"] = float(np.percentile(spent, 99))
    return made


def shown(found: dict[str, object]) -> str:
    cells = [f"{found['nodes']} x {found['nodes']}", f"{found['pressed']}", f"{found['contacts']}"]
    for name in COLUMNS:
        p50, p99 = (1e6 * float(str(found[f"{name}_{part}_s"])) for part in ("p50", "p99"))
        cells.append(f"{p50:.0f} / {p99:.0f}" if p50 > 100 else f"{p50:.1f} / {p99:.1f}")
    return f"| {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, nargs="+", default=[20, 40, 80])
    parser.add_argument("--laps", type=int, default=1000)
    parser.add_argument("--json", help="file for the numbers")
    options = parser.parse_args()
    print(f"{platform.machine()}, Python {platform.python_version()}, NumPy {np.__version__}")
    head = ["nodes", "pressed", "contacts", *(f"{name} µs p50 / p99" for name in COLUMNS)]
    print(f"| {' | '.join(head)} |\n|{' --- |' * len(head)}")
    rows = []
    for nodes in options.nodes:
        patch = sf.layouts.hexagon72()
        grid, solver = sf.Grid.square(patch, nodes=nodes), sf.GaussianField()
        rec = sf.Reconstructor(patch, sf.Layer(), grid, solver=solver)
        for count in range(4):
            rows.append(row(rec, count, options.laps))
            print(shown(rows[-1]), flush=True)
    if options.json:
        Path(options.json).write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
