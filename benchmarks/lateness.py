"""How late answers are that were asked for by a deadline."""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from pressed_readings import model_of, undisturbed

import skinfield as sf

DEADLINES = (30, 50, 100, 200, 500)  # µs


@contextmanager
def real_time(wanted: bool) -> Iterator[bool]:
    """With the scheduler's real-time class where that is permitted."""
    if not wanted or not hasattr(os, "sched_setscheduler"):
        yield False
        return
    before = os.sched_getscheduler(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
    except OSError:
        yield False
        return
    try:
        yield True
    finally:
        os.sched_setscheduler(0, before, os.sched_param(0))


def overshoot_table(rows: dict[str, np.ndarray], nodes: int, laps: int) -> list[dict[str, Any]]:
    """Print how late answers are, each taken once; a pause after each lets others run."""
    print(f"\nDeadlines, {nodes} x {nodes}, warm, smooth prior, to 1e-4")
    columns = (
        "scheduler | readings | deadline µs | late p50 / p99 / max µs | met | proved to 1e-2 | "
        "gap p50 / p90"
    )
    print(f"| {columns} |\n|{' --- |' * (columns.count('|') + 1)}")
    found = []
    for wanted in (False, True):
        with real_time(wanted) as given:
            if wanted and not given:
                print("| SCHED_FIFO is not permitted | | | | | | |")
                continue
            for quantity, chain in rows.items():
                operator = sf.NonNegative().prepare(model_of(quantity, nodes))
                for deadline in DEADLINES:
                    row = _late(operator, chain, deadline, laps)
                    row.update(fifo=given, quantity=quantity, deadline=deadline)
                    found.append(row)
                    late = " / ".join(f"{1e6 * row[key]:.1f}" for key in ("p50", "p99", "max"))
                    name = "SCHED_FIFO" if given else "usual"
                    gaps = f"{row['gap']:.0e} / {row['gap_p90']:.0e}"
                    print(
                        f"| {name} | {quantity} | {deadline} | {late} "
                        f"| {row['met']:.4f} | {row['proved']:.2f} | {gaps} |",
                        flush=True,
                    )
    return found


def _late(operator: Any, chain: np.ndarray, deadline: int, laps: int) -> dict[str, Any]:
    late, gaps, met = [], [], []
    data = operator.data()
    with undisturbed():
        for lap in range(laps + 1):
            for readings in chain:
                limit = time.perf_counter_ns() + 1000 * deadline
                solution = operator.solve(readings, data, limit)
                end = time.perf_counter_ns()
                if lap:  # the first one learns the pace
                    late.append(max(end - limit, 0) * 1e-9)
                    gaps.append(solution.gap)
                    met.append(solution.in_time)
                time.sleep(5e-4)
    p50, p99 = np.quantile(late, [0.5, 0.99])
    return {
        "p50": float(p50),
        "p99": float(p99),
        "max": max(late),
        "met": float(np.mean(met)),
        "proved": float(np.mean(np.array(gaps) <= 1e-2)),
        "gap": float(np.median(gaps)),
        "gap_p90": float(np.quantile(gaps, 0.9)),
    }
