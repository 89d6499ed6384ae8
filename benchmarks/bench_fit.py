"""Time per reading of the contact fit, cold and warm, beside the Gaussian field and the paper.

Run: python benchmarks/bench_fit.py [--laps 300] [--json FILE]

One table in one run, on one thread. One, two and three balls of 6 mm radius with 1 N each move
over the patch by 0.2 mm from reading to reading (10 mm/s at 50 Hz), with noise. Cold, each reading
is the first; warm, it follows the one before. A time is that of the whole call: fields, contacts
and their covariances. `floor` is the least that a method must do: the contact fit one evaluation of
its model with all derivatives, at the truth; a linear one a pass over its operator's bytes. The
paper's algorithm interpolates, inverts and computes displacements anew for each reading.
"""

import argparse
import json
import os
import platform
from collections.abc import Callable
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before NumPy: one core, no spinning threads

import numpy as np
from bench_apply import add_up

import skinfield as sf
from skinfield.lab.bench.machine import laps as lap
from skinfield.lab.paper import reconstruct_as_paper
from skinfield.simulate import Sphere, press
from skinfield.skin.generators import icub_hexagon
from skinfield.solve.atoms.atom_readings import PARAMETERS, predict
from skinfield.solve.atoms.table import atom_tables

LAYER = sf.Layer(2e-3, 100e3, 0.5)
PATCH = icub_hexagon()
PLACES = np.array([[-7e-3, -4e-3], [7e-3, -4e-3], [0.0, 8e-3]])
NOISE = {"stress": 400.0, "capacitance": 0.002}
QUANTITY = {"stress": sf.BaseStress(), "capacitance": sf.Capacitance()}
STEP = 0.2e-3  # m between readings


def readings_of(contacts: int, quantity: str, count: int) -> np.ndarray:
    """Readings (count, L) of balls that move to and fro, with noise."""
    bodies = [Sphere(radius=6e-3, force=1.0, position=tuple(p)) for p in PLACES[:contacts]]
    solved = press(LAYER, bodies, extent=44e-3, cell=0.25e-3)
    way = 4e-3 * np.sin(STEP / 4e-3 * np.arange(count))
    shift = np.column_stack([way, 0.6 * way])
    pads = (PATCH.plane[None] - shift[:, None]).reshape(-1, 2)
    exact = solved.readings(pads, PATCH.pad_diameter, quantity).reshape(count, -1)
    return exact + np.random.default_rng(0).normal(scale=NOISE[quantity], size=exact.shape)


def times_of(rec: sf.Reconstructor, readings: np.ndarray) -> dict[str, float]:
    """Milliseconds of each reading, cold and warm: p50 and p99."""
    found = {}
    for kind in ("cold", "warm"):
        rows = iter(np.concatenate([readings[:20], readings]))

        def once(kind: str = kind, rows: object = rows) -> None:
            rec(next(rows))

        spent = []
        for index in range(20 + len(readings)):
            if kind == "cold":
                rec.reset()
            spent.append(lap(once, 1, 0)[0])
            if index == 19:
                spent.clear()  # what the caches still lacked
        found[f"{kind}_p50_ms"] = 1e3 * float(np.median(spent))
        found[f"{kind}_p99_ms"] = 1e3 * float(np.percentile(spent, 99))
    return found


def floor_of_fit(rec: sf.Reconstructor, contacts: int) -> float:
    """Seconds of one evaluation of the fit's model, with derivatives, at about the truth."""
    h = LAYER.thickness
    tables = atom_tables(rec.model.physics)
    atoms = np.zeros((contacts, PARAMETERS))
    atoms[:, :2] = PLACES[:contacts] / h
    atoms[:, 3] = np.log(2.6e-3 / h)
    family, out = np.zeros(contacts, np.int64), np.empty(len(PATCH))
    jacobian = np.empty((contacts, PARAMETERS, len(PATCH)))
    taxels = np.ascontiguousarray(PATCH.plane / h)
    return float(
        np.median(lap(lambda: predict(atoms, family, taxels, tables, out, jacobian), 2000, 50))
    )


def contenders(quantity: str) -> dict[str, sf.Reconstructor]:
    """Prepared reconstructions by name."""

    def made(solver: object, mechanics: object, nodes: int) -> sf.Reconstructor:
        return sf.Reconstructor(
            PATCH,
            LAYER,
            sf.Grid.square(PATCH, nodes=nodes),
            mechanics=mechanics,
            quantity=QUANTITY[quantity],
            solver=solver,
            noise_std=NOISE[quantity],
        )

    return {
        "ContactFit": made(sf.ContactFit(), sf.BondedLayer(), 40),
        "GaussianField": made(sf.GaussianField(), sf.BondedLayer(), 40),
        "paper, prepared": made(sf.PseudoInverse(resample=True), sf.HalfSpace(), 20),
    }


def row_of(
    rec: sf.Reconstructor, name: str, contacts: int, quantity: str, readings: np.ndarray
) -> dict[str, object]:
    """One line of the table."""
    if name == "ContactFit":
        floor = floor_of_fit(rec, contacts)
    else:
        operator = rec.operator.ravel(order="K")
        floor = float(np.median(lap(lambda: add_up(operator), 300, 30)))
    seen = float(np.mean([len(found) for found in rec(readings).contacts]))
    head = {"quantity": quantity, "contacts": contacts, "method": name, "found": seen}
    return head | times_of(rec, readings) | {"floor_us": 1e6 * floor}


def paper_row(quantity: str, laps: int) -> dict[str, object]:
    """The paper's algorithm, with all its work for each reading, on 20 x 20 nodes."""
    grid = sf.Grid.square(PATCH, nodes=20)
    reading = np.random.default_rng(0).normal(scale=NOISE[quantity], size=len(PATCH))
    work: Callable[[], object] = lambda: reconstruct_as_paper(  # noqa: E731
        reading, PATCH.plane, grid.plane, LAYER, grid.cell_area
    )
    spent = 1e3 * lap(work, laps, 1)
    return {
        "quantity": quantity, "contacts": "any", "method": "paper, all its work", "found": None,
        "cold_p50_ms": float(np.median(spent)), "cold_p99_ms": float(np.percentile(spent, 99)),
        "warm_p50_ms": None, "warm_p99_ms": None, "floor_us": None,
    }  # fmt: skip


def shown(row: dict[str, object]) -> str:
    """A line of the table."""
    kinds = [
        "–"
        if row[f"{k}_p50_ms"] is None
        else f"{row[f'{k}_p50_ms']:.2f} / {row[f'{k}_p99_ms']:.2f}"
        for k in ("cold", "warm")
    ]
    floor = "–" if row["floor_us"] is None else f"{row['floor_us']:.1f}"
    seen = "–" if row["found"] is None else f"{row['found']:.1f}"
    cells = [row["quantity"], row["contacts"], row["method"], seen, *kinds, floor]
    return f"| {' | '.join(map(str, cells))} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--laps", type=int, default=300, help="readings of each")
    parser.add_argument("--paper-laps", type=int, default=20, help="of the paper's algorithm")
    parser.add_argument("--json", help="file for the numbers")
    options = parser.parse_args()
    print(f"{platform.machine()}, Python {platform.python_version()}, NumPy {np.__version__}")
    columns = ["reads", "contacts", "method", "found", "cold ms p50 / p99", "warm ms p50 / p99"]
    columns += ["floor µs"]
    print(f"| {' | '.join(columns)} |\n|{' --- |' * len(columns)}")
    rows = []
    for quantity in QUANTITY:
        prepared = contenders(quantity)
        for contacts in (1, 2, 3):
            readings = readings_of(contacts, quantity, options.laps)
            for name, rec in prepared.items():
                rows.append(row_of(rec, name, contacts, quantity, readings))
                print(shown(rows[-1]), flush=True)
    rows.append(paper_row("stress", options.paper_laps))
    print(shown(rows[-1]))
    if options.json:
        Path(options.json).write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
