"""Batches by array libraries and devices: readings per second, beside the host's own way.

Run: python benchmarks/bench_gpu.py [--device numpy cpu cuda] [--nodes 40] [--readings 32768]

One table in one run, of the devices that are found (PyTorch's, or CuPy's). `to host` is pressure
and displacement of many readings from arrays of the host to one array of the host; `chunks` the
same with each chunk used before the next comes, without a copy into one array; `stay` without the
way back. `NonNegative` is pressure without pull, certified to `--gap`, of readings of a moving
press; the host's row has the solver's own search, one by one. Each is the best of some laps on one
core of the host, in float32; `error` is the largest difference to the host's product in float64,
part of its largest value in its unit. A GPU's laps end when the device has.
"""

import argparse
import os
import time
from collections.abc import Callable

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before NumPy: one core, no spinning threads

import numpy as np

import skinfield as sf
from skinfield.errors import InputError
from skinfield.pipeline.array_backend import ArrayBackend
from skinfield.pipeline.batch import BulkProduct
from skinfield.pipeline.device_non_negative import BulkNonNegative
from skinfield.pipeline.device_product import DeviceProduct

PATCH = sf.layouts.hexagon72()
LAYER = sf.Layer(2e-3, 100e3, 0.5)
NOISE = 2e-3


def rate(work: Callable[[], object], count: int, laps: int = 5) -> float:
    """Readings per second of the quickest lap, after one to warm up."""
    work()
    best = np.inf
    for _ in range(laps):
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
    return count / best


def press_readings(count: int) -> np.ndarray:
    """Two bodies that fade in and out, with noise; linearised."""
    bodies = [
        sf.simulate.Sphere(radius=6e-3, position=(-9e-3, 6e-3), force=1.0),
        sf.simulate.Cylinder(radius=4e-3, position=(12e-3, -8e-3), force=3.0),
    ]
    press = sf.simulate.press(LAYER, bodies, extent=70e-3, cell=1e-3)
    change = press.capacitance(PATCH.positions, PATCH.pad_diameter)
    noise = np.random.default_rng(0).normal(scale=NOISE, size=(count, len(PATCH)))
    table = np.abs(np.sin(np.arange(count) / 200.0))[:, None] * change + noise
    return sf.Capacitance().linearise(table, np.empty_like(table))


class Bench:
    """What is the same for all devices."""

    def __init__(self, nodes: int, count: int, gap: float) -> None:
        self.grid = sf.Grid.square(PATCH, nodes=nodes)
        linear = sf.Reconstructor(PATCH, LAYER, self.grid, noise_std=NOISE)
        self.operator, self.gap = linear.operator, gap
        self.search = sf.NonNegative(tolerance=gap).prepare(linear.model)
        self.readings = press_readings(count)
        self.few = self.readings[: max(count // 16, 1)]
        self.exact = self.readings[:256] @ self.operator.T
        self.out = np.empty((count, len(self.operator)), np.float32)

    def error(self) -> float:
        """Of what the last product left."""
        apart = np.abs(self.out[: len(self.exact)] - self.exact).reshape(-1, 4, len(self.grid))
        size = np.abs(self.exact).reshape(-1, 4, len(self.grid)).max(axis=(0, 2))
        return float((apart.max(axis=(0, 2)) / size).max())

    def host(self) -> str:
        """Row of the ways without any array library."""
        product = BulkProduct(self.operator)
        fast = rate(lambda: product.fields(self.readings, self.out), len(self.readings))
        pressure = np.empty(len(self.grid))

        def one_by_one() -> None:
            for reading in self.few:
                self.search.apply(reading, pressure)

        slow = rate(one_by_one, len(self.few), 2)
        return (
            f"| BulkProduct, NonNegative | {fast:,.0f} | | | {self.error():.0e} | {slow:,.0f} | |"
        )

    def row(self, backend: ArrayBackend) -> str:
        """Row of a device."""
        product = DeviceProduct(self.operator, backend)
        fast = rate(lambda: product.fields(self.readings, self.out), len(self.readings))
        last = slice(-1, None)

        def chunks() -> None:
            for _ in product.chunks(self.readings):
                pass

        passing = rate(chunks, len(self.readings))

        def stay() -> None:
            for first in range(0, len(self.readings), product.chunk):
                there = product.on_device(self.readings[first : first + product.chunk])
            backend.fetch(there[last, ...])  # which the device answers when all is done

        stays = rate(stay, len(self.readings))
        bulk = BulkNonNegative(self.search, backend, self.gap)
        answer = bulk(self.few)
        slow = rate(lambda: bulk(self.few), len(self.few), 2)
        rates = " | ".join(f"{each:,.0f}" for each in (fast, passing, stays))
        proved = f"{answer.iterations.max()}, {answer.gap.max():.0e}"
        name = f"{backend.name}, chunks of {product.chunk}"
        return f"| {name} | {rates} | {self.error():.0e} | {slow:,.0f} | {proved} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--device", nargs="+", default=["numpy", "cpu", "cuda"])
    parser.add_argument("--nodes", type=int, default=40, help="along a side of the grid")
    parser.add_argument("--readings", type=int, default=8192)
    parser.add_argument("--gap", type=float, default=1e-3, help="certified, of NonNegative")
    options = parser.parse_args()
    bench = Bench(options.nodes, options.readings, options.gap)
    print(f"{options.nodes} x {options.nodes} nodes, 72 taxels, readings/s on one core of the host")
    columns = [
        "",
        "to host",
        "chunks",
        "stay",
        "error",
        f"NonNegative, gap {options.gap:g}",
        "steps, gap",
    ]
    print(f"| {' | '.join(columns)} |\n|{' --- |' * len(columns)}")
    print(bench.host(), flush=True)
    for device in options.device:
        try:
            backend = ArrayBackend.on(device)
        except InputError as error:
            print(f"| {device} | not measured: {error} | | | | | |")
            continue
        if device == "cpu":
            backend.namespace.set_num_threads(1)
        print(bench.row(backend), flush=True)


if __name__ == "__main__":
    main()
