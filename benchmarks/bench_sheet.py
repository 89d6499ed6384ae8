"""One sheet of 1,000 to 1,000,000 taxels: what set-up, one reading and memory cost per taxel.

Run: python benchmarks/bench_sheet.py [--taxels 1000 10000 100000 1000000] [--cpu] [--json FILE]

One table in one run. Each size has a process of its own, so that its peak of memory is its own.
Taxels stand at random (a square lattice of 5.8 mm, moved by up to 30 % of that, in random order) on
cells of 1.5 mm. Readings are two contacts per 1,000 taxels and noise of 1 % of their peak, fresh
each time; the pressure is solved for from nothing ("cold") and from the reading before ("warm").

* stamps: once per elastomer and cell size, whatever the number of taxels.
* set-up: per taxel, with the stamps at hand and the machine code loaded.
* solve + force: readings to pressure on all cells, to a relative residual of 1e-3.
* force alone: the stamps of the taxels' weights added to the cells.
* FFT: the same sum for taxels that stood in the middle of their cells, by scipy.fft in float32 with
  the kernel's transform at hand. For taxels anywhere it would need a finer lattice.
* displacement: three components on all cells, by FFT in blocks.
* peak: resident memory of the whole process at its highest, with interpreter, SciPy and the
  displacement of one reading.

"over 1k" compares the least times of cold readings, as the load of others only ever adds. `--cpu`
counts processor time instead of elapsed time, for a machine that is busy otherwise.
"""

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before NumPy: one core, no spinning threads

import numpy as np

import skinfield as sf

DISTANCE = 5.8e-3
CLOCK = [time.perf_counter]
COLUMNS = [
    "taxels",
    "cells",
    "stamps ms",
    "set-up µs/taxel",
    "steps cold / warm",
    "solve + force ns/taxel cold",
    "warm",
    "least",
    "over 1k",
    "force alone ns/taxel",
    "FFT ns/taxel",
    "displacement ns/taxel",
    "peak MB",
]


def places_of(taxels: int, rng: np.random.Generator) -> np.ndarray:
    side = round(taxels**0.5)
    index = np.stack(np.meshgrid(np.arange(side), np.arange(side)), -1).reshape(-1, 2)
    return rng.permutation((index + rng.uniform(-0.3, 0.3, index.shape)) * DISTANCE)


def pressed(sheet: sf.Sheet, rng: np.random.Generator) -> np.ndarray:
    """What the taxels read of a pressure with two round contacts per 1,000 taxels."""
    field = np.zeros(sheet.shape, dtype=np.float32)
    across = np.exp(-np.square(np.arange(-12, 13) / 4.0))
    for _ in range(max(2 * len(sheet) // 1000, 2)):
        row, column = (rng.integers(20, n - 20) for n in sheet.shape)
        field[row - 12 : row + 13, column - 12 : column + 13] += 2e4 * np.outer(across, across)
    return sheet.predict(field.ravel())


def least(call: Callable[[], object], laps: int) -> tuple[float, float]:
    """Median and least time of a call, s."""
    call()
    spent = []
    for _ in range(laps):
        begin = CLOCK[0]()
        call()
        spent.append(CLOCK[0]() - begin)
    return float(np.median(spent)), min(spent)


def by_fft(sheet: sf.Sheet) -> Callable[[], object]:
    """The short force kernel's sum over the lattice, by one transform there and back."""
    from scipy import fft

    stamp = sheet.plan.stamps.spread
    kernel = stamp.at(np.zeros((1, 2)))[0].astype(np.float32)
    period = [fft.next_fast_len(n + len(kernel), real=True) for n in sheet.shape]
    spectrum = fft.rfft2(kernel, period)
    row, column = np.divmod(sheet.plan.corner, sheet.shape[1])
    values = np.ones(len(sheet), dtype=np.float32)
    loads = np.zeros(sheet.shape, dtype=np.float32)

    def convolve() -> object:
        loads[:] = 0.0
        loads[row, column] = values
        product = fft.rfft2(loads, period)
        product *= spectrum
        return fft.irfft2(product, period)

    return convolve


def force_alone(sheet: sf.Sheet, out: np.ndarray) -> Callable[[], object]:
    from skinfield.solve.sheet.kernels import add_stamps
    from skinfield.solve.sheet.plan import parts_of

    values = np.ones(len(sheet), dtype=np.float32)
    parts = parts_of(sheet.plan.stamps.spread, np.float32)
    corner, offset = sheet.plan.corner, sheet.plan.offset
    return lambda: add_stamps(values, corner, offset, parts, sheet.shape[1], out)


def row(taxels: int) -> dict[str, float]:
    """All numbers of one size, in this process."""
    rng = np.random.default_rng(0)
    places, layer = places_of(taxels, rng), sf.Layer(2e-3, 150e3, 0.5)
    sf.Sheet(places_of(100, rng), layer, pitch=1.6e-3)(np.zeros(100))  # loads the machine code
    begin = CLOCK[0]()
    sheet = sf.Sheet(places[:1], layer, solver=sf.GaussianField(length_scale=1.1e-3))
    stamps_s = CLOCK[0]() - begin
    sheet = sf.Sheet(places, layer)
    setup, laps = [], max(min(3_000_000 // taxels, 300), 7)
    for _ in range(3 if taxels > 300_000 else 7):
        del sheet
        begin = CLOCK[0]()
        sheet = sf.Sheet(places, layer)  # the stamps are kept from the one before
        setup.append(CLOCK[0]() - begin)
    clean = pressed(sheet, rng)
    noise = 0.01 * np.abs(clean).max()
    readings = [(clean + rng.normal(size=len(clean)) * noise).astype(np.float32) for _ in range(8)]
    out, turn = np.empty(len(sheet.grid), dtype=np.float32), [0]

    def warm() -> None:
        turn[0] += 1
        sheet.apply(readings[turn[0] % len(readings)], out)

    def cold() -> None:
        sheet.reset()
        warm()

    cold_s, cold_steps = least(cold, laps), sheet.iterations
    warm_s = least(warm, laps)
    found: dict[str, float] = {
        "taxels": len(sheet),
        "rows": sheet.shape[0],
        "columns": sheet.shape[1],
        "stamps_s": stamps_s,
        "setup_s": min(setup),
        "steps_cold": cold_steps,
        "steps_warm": sheet.iterations,
        "cold_p50_s": cold_s[0],
        "cold_least_s": cold_s[1],
        "warm_p50_s": warm_s[0],
        "warm_least_s": warm_s[1],
        "force_s": least(force_alone(sheet, out), laps)[1],
    }
    displaced = least(lambda: sheet.displacement(out), min(laps, 5))[1]
    found["peak_bytes"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    found["fft_s"] = least(by_fft(sheet), min(laps, 20))[1]
    found["displacement_s"] = displaced
    return found


def in_process(taxels: int, cpu: bool) -> dict[str, float]:
    command = [sys.executable, __file__, "--row", str(taxels), *(["--cpu"] if cpu else [])]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def line(found: dict[str, float], first: dict[str, float]) -> str:
    each = 1e9 / found["taxels"]
    ratio = found["cold_least_s"] * each / (first["cold_least_s"] * 1e9 / first["taxels"])
    cells = [
        f"{found['taxels']:,}",
        f"{found['rows']} x {found['columns']}",
        f"{found['stamps_s'] * 1e3:.0f}",
        f"{found['setup_s'] * each / 1e3:.2f}",
        f"{found['steps_cold']} / {found['steps_warm']}",
        *(f"{found[name] * each:.0f}" for name in ("cold_p50_s", "warm_p50_s", "cold_least_s")),
        f"{ratio:.2f}",
        *(f"{found[name] * each:.0f}" for name in ("force_s", "fft_s", "displacement_s")),
        f"{found['peak_bytes'] / 1e6:.0f}",
    ]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--taxels", type=int, nargs="+", default=[1000, 10_000, 100_000, 1_000_000])
    parser.add_argument("--cpu", action="store_true", help="processor time, not elapsed time")
    parser.add_argument("--json", help="file for the numbers")
    parser.add_argument("--row", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.cpu:
        CLOCK[0] = time.thread_time
    if options.row is not None:
        print(json.dumps(row(options.row)))
        return
    begin = time.perf_counter()
    in_process(100, options.cpu)
    print(f"{platform.machine()}, Python {platform.python_version()}, NumPy {np.__version__}")
    spent = time.perf_counter() - begin
    print(f"First run, which compiles what is not kept from before: {spent:.1f} s")
    print(f"| {' | '.join(COLUMNS)} |\n|{' --- |' * len(COLUMNS)}")
    rows: list[dict[str, float]] = []
    for taxels in options.taxels:
        rows.append(in_process(taxels, options.cpu))
        print(line(rows[-1], rows[0]), flush=True)
    if options.json:
        Path(options.json).write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
