"""How long a proof takes: `NonNegative` to certified gaps, beside what else could be done.

Run: python benchmarks/bench_nonnegative.py [--nodes 20 40 80] [--readings 240] [--laps 5]

One run. Readings are those of two balls that wander over the paper's patch of 72 taxels, with the
quantity's typical noise: presses solved by `skinfield.simulate` on cells of their own, one for
each load, carried to the places (the two never come nearer than eight thicknesses, so readings
add). Every reading is solved from nothing (cold) and after the one before (warm).

Times are the shortest of some laps for each reading, p50 and p99 over the readings; only
deadlines are taken once each. `linear` is the product of a matrix and the readings in float32, for
pressure (1), with the normal displacement (2), and with all of it (4). `FISTA` is accelerated
gradient with restart and backtracking on the same dual, compiled, warm. `nnls` is
scipy.optimize.nnls of the same minimum for cells that are independent (length_scale 0), in which
the penalties are further rows.
"""

import argparse
import json
import os
import platform
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before NumPy: one core, no spinning threads

import numpy as np
from fista import Fista
from lateness import overshoot_table
from pressed_readings import LAYER, PATCH, SHAPES, chains, model_of, staying, undisturbed
from scipy.optimize import nnls

import skinfield as sf
from skinfield.elastic import ObservationModel
from skinfield.solve.dual.problem import MISFIT

PRIORS = {"smooth": sf.NonNegative(), "white": sf.NonNegative(length_scale=0.0)}
GAPS = (1e-2, 1e-3, 1e-4)
EXACT = 4  # readings that scipy's nnls solves


def shortest(work: Callable[[int], None], begin: Callable[[], None], count: int, laps: int) -> Any:
    """Seconds of the quickest lap for each of `count` readings, one after another."""
    times = np.full(count, np.inf)
    with undisturbed():
        for _ in range(laps):
            begin()
            for index in range(count):
                start = time.perf_counter_ns()
                work(index)
                times[index] = min(times[index], (time.perf_counter_ns() - start) * 1e-9)
    return times


def linear(nodes: int, rows: np.ndarray, laps: int) -> list[float]:
    """Median seconds of products for one, two and four outputs per node."""
    rec = sf.Reconstructor(PATCH, LAYER, sf.Grid.square(PATCH, nodes), precision=np.float32)
    whole = np.ascontiguousarray(rec.operator.reshape(-1, len(PATCH)), dtype=np.float32)
    single = np.ascontiguousarray(rows, dtype=np.float32)
    found = []
    for outputs in (1, 2, 4):
        matrix = np.ascontiguousarray(np.resize(whole, (outputs * nodes**2, len(PATCH))))
        out = np.empty(len(matrix), np.float32)
        times = shortest(
            lambda index, m=matrix, o=out: np.dot(m, single[index], out=o),
            lambda: None,
            len(rows),
            4 * laps,
        )
        found.append(float(np.median(times)))
    return found


def algebra(
    solver: sf.NonNegative, model: ObservationModel, chain: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """B (L, K) and mu (K,) of the docstring, and the readings (T, L) as b."""
    problem, taxels = solver.prepare(model).problem, chain.shape[1]
    root, white = problem.root[:taxels], chain * problem.whitening
    white -= np.outer(white @ root, root)
    white /= np.hypot(1.0, problem.numbers[MISFIT] * np.abs(chain).max(axis=1))[:, None]
    penalty = solver.shrinkage * problem.threshold * problem.norms.astype(np.float64)
    return problem.rows[:, :taxels].T.astype(np.float64), penalty, white


def by_nnls(seen: np.ndarray, penalty: np.ndarray, white: np.ndarray) -> float:
    """Median seconds of scipy's nnls."""
    rows = np.concatenate([seen, np.eye(len(penalty))])
    times = []
    for index in np.linspace(0, len(white) - 1, EXACT).astype(int):
        start = time.perf_counter()
        nnls(rows, np.concatenate([white[index], -penalty]), maxiter=100 * len(penalty))
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def certified(
    solver: sf.NonNegative, model: ObservationModel, rows: np.ndarray, laps: int
) -> dict[str, Any]:
    """Seconds per reading, cold and warm, steps and the largest gap."""
    operator = solver.prepare(model)
    data = operator.data()
    gaps, steps = np.zeros(len(rows)), np.zeros(len(rows))

    def warm(index: int) -> None:
        found = operator.solve(rows[index], data)
        gaps[index], steps[index] = found.gap, found.steps

    def cold(index: int) -> None:
        operator.solve(rows[index], data)

    chained = shortest(warm, data.reset, len(rows), laps)[1:]
    found = {"warm": chained, "gap": gaps.max(), "steps": steps[1:].mean()}
    alone = np.full(len(rows), np.inf)
    for _ in range(laps):
        for index in range(len(rows)):
            data.reset()
            start = time.perf_counter_ns()
            cold(index)
            alone[index] = min(alone[index], (time.perf_counter_ns() - start) * 1e-9)
    return {**found, "cold": alone, "pressed": int(np.count_nonzero(data.solution.pressure))}


def by_fista(
    seen: np.ndarray, penalty: np.ndarray, white: np.ndarray, gap: float, laps: int
) -> tuple[np.ndarray, float]:
    """Seconds per reading, warm, and steps."""
    solver = Fista(seen, penalty, gap)
    steps = np.zeros(len(white))

    def work(index: int) -> None:
        steps[index] = solver(white[index])

    times = shortest(work, solver.reset, len(white), laps)
    return times[1:], float(steps[1:].mean())


def us(values: np.ndarray) -> str:
    """Median and 99th percentile in microseconds."""
    return " / ".join(f"{1e6 * float(v):.0f}" for v in np.quantile(values, [0.5, 0.99]))


def times_table(rows: dict[str, np.ndarray], nodes: list[int], laps: int) -> list[dict[str, Any]]:
    """Print the times to certified gaps."""
    print("\n| nodes | linear 1 / 2 / 4 outputs, µs |\n| --- | --- |")
    products = {}
    for each in nodes:
        products[each] = linear(each, rows["stress"], laps)
        print(f"| {each} x {each} | {' / '.join(f'{1e6 * t:.1f}' for t in products[each])} |")
    columns = (
        "nodes | readings | prior | gap | cold p50 / p99 µs | warm p50 / p99 µs | steps | "
        "warm over linear 1 / 2 / 4 | FISTA µs (steps) | FISTA over warm | nnls ms | "
        "nnls over cold / warm"
    )
    print(f"\n| {columns} |\n|{' --- |' * (columns.count('|') + 1)}", flush=True)
    found = []
    for each in nodes:
        for quantity, chain in rows.items():
            model = model_of(quantity, each)
            for prior, solver in PRIORS.items():
                found += _rows(model, prior, solver, chain, products[each], laps)
                for row in found[-len(GAPS) :]:
                    row.update(nodes=each, quantity=quantity, prior=prior)
                    print(_line(row), flush=True)
    return found


def shapes_table(count: int, nodes: int, laps: int) -> list[dict[str, Any]]:
    """Print the times to the default gap for presses of several shapes that stay."""
    print(f"\nPresses that stay, {nodes} x {nodes}, smooth prior, to 1e-4")
    columns = "press | readings | cold p50 / p99 µs | warm p50 / p99 µs | steps | nodes pressed"
    print(f"| {columns} |\n|{' --- |' * (columns.count('|') + 1)}")
    found = []
    for name, body in SHAPES.items():
        for quantity, chain in staying(body, count):
            row = certified(sf.NonNegative(), model_of(quantity, nodes), chain, laps)
            found.append({"press": name, "quantity": quantity, "pressed": row["pressed"]})
            for start in ("cold", "warm"):
                found[-1][f"{start}_p50"] = float(np.median(row[start]))
                found[-1][f"{start}_p99"] = float(np.quantile(row[start], 0.99))
            print(
                f"| {name} | {quantity} | {us(row['cold'])} | {us(row['warm'])} "
                f"| {row['steps']:.1f} | {row['pressed']} |",
                flush=True,
            )
    return found


def _rows(
    model: ObservationModel,
    prior: str,
    solver: sf.NonNegative,
    chain: np.ndarray,
    products: list[float],
    laps: int,
) -> Iterator[dict[str, Any]]:
    seen, penalty, white = algebra(solver, model, chain)
    few = white if len(penalty) < 2000 else white[: len(white) // 4]
    exact = by_nnls(seen, penalty, white) if prior == "white" and len(penalty) < 2000 else np.nan
    for gap in GAPS:
        row = certified(replace(solver, tolerance=gap), model, chain, laps)
        fista, steps = by_fista(seen, penalty, few, gap, 3)
        yield {
            "gap": gap,
            "proved": row["gap"],
            "steps": row["steps"],
            "linear": products,
            "fista": float(np.median(fista)),
            "fista_steps": steps,
            "nnls": exact,
            **{f"{kind}_p50": float(np.median(row[kind])) for kind in ("cold", "warm")},
            **{f"{kind}_p99": float(np.quantile(row[kind], 0.99)) for kind in ("cold", "warm")},
        }


def _line(row: dict[str, Any]) -> str:
    warm, cold = row["warm_p50"], row["cold_p50"]
    over = " / ".join(f"{warm / each:.1f}" for each in row["linear"])
    late = "" if row["proved"] <= row["gap"] * 1.001 else f" (proved {row['proved']:.0e})"
    exact = "| |" if np.isnan(row["nnls"]) else (
        f"| {1e3 * row['nnls']:.0f} | {row['nnls'] / cold:.0f} / {row['nnls'] / warm:.0f} |"
    )  # fmt: skip
    return (
        f"| {row['nodes']} | {row['quantity']} | {row['prior']} | {row['gap']:.0e}{late} "
        f"| {1e6 * cold:.0f} / {1e6 * row['cold_p99']:.0f} "
        f"| {1e6 * warm:.0f} / {1e6 * row['warm_p99']:.0f} | {row['steps']:.1f} | {over} "
        f"| {1e6 * row['fista']:.0f} ({row['fista_steps']:.0f}) | {row['fista'] / warm:.1f} {exact}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, nargs="*", default=[20, 40, 80])
    parser.add_argument("--readings", type=int, default=240)
    parser.add_argument("--laps", type=int, default=5)
    parser.add_argument("--json", help="file for the numbers, in seconds")
    options = parser.parse_args()
    print(f"{platform.machine()}, Python {platform.python_version()}, NumPy {np.__version__}")
    rows = chains(options.readings)
    times = times_table(rows, options.nodes, options.laps)
    shapes = shapes_table(options.readings // 2, 40, options.laps)
    late = overshoot_table(rows, 40, max(options.laps // 2, 1))
    if options.json:
        Path(options.json).write_text(
            json.dumps({"times": times, "shapes": shapes, "late": late}, indent=1) + "\n"
        )


if __name__ == "__main__":
    main()
