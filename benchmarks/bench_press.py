"""Time and memory of one press on 120 x 120 cells, and of what is read from it.

    python benchmarks/bench_press.py

Seconds of one core, as on an idle machine. "First" includes the tables of the layer's responses,
which are kept for later presses on the same layer; "again" is the best of five.
"""

import os
import resource
import time
import tracemalloc
from collections.abc import Callable

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

import skinfield as sf
from skinfield.simulate import Cylinder, Press, Sphere, press, press_ladder

LAYER = sf.Layer(thickness=2e-3, young_modulus=100e3, poisson_ratio=0.5)
PATCH = sf.layouts.hexagon72()


def timed(call: Callable[[], object], repeats: int) -> float:
    times = []
    for _ in range(repeats):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return min(times)


def spread(count: int) -> list[Sphere]:
    """Balls on a circle with 0.3 N each."""
    angle = np.arange(count) * 2 * np.pi / count
    return [
        Sphere(radius=3e-3, force=0.3, position=(18e-3 * np.cos(a), 18e-3 * np.sin(a)))
        for a in angle
    ]


CASES: dict[str, Callable[[], object]] = {
    "ball of 12 mm, 1 N": lambda: press(LAYER, [Sphere(radius=6e-3)]),
    "the same at 0.2 N": lambda: press(LAYER, [Sphere(radius=6e-3, force=0.2)]),
    "the same to 0.6 mm": lambda: press(LAYER, [Sphere(radius=6e-3, depth=0.6e-3)]),
    "flat end of 3 mm, 1 N": lambda: press(LAYER, [Cylinder(radius=1.5e-3)]),
    "flat end of 12 mm, 1 N": lambda: press(LAYER, [Cylinder(radius=6e-3)]),
    "flat end of 48 mm, 50 N": lambda: press(LAYER, [Cylinder(radius=24e-3, force=50.0)]),
    "3 balls, 36 mm apart": lambda: press(LAYER, spread(3)),
    "10 balls": lambda: press(LAYER, spread(10)),
    "ball, sticking shear": lambda: press(LAYER, [Sphere(radius=6e-3, shear=(0.2, 0.0))]),
    "ball, partial slip": lambda: press(
        LAYER, [Sphere(radius=6e-3, shear=(0.2, 0.0))], friction=0.5
    ),
    "ladder of 20 loads": lambda: press_ladder(
        LAYER, Sphere(radius=6e-3), np.geomspace(0.1, 3.0, 20)
    ),
}


def readings(found: Press) -> dict[str, Callable[[], object]]:
    at, pad = PATCH.plane, PATCH.pad_diameter
    fresh = {"displacement": 0, "outline": 0}
    cases: dict[str, Callable[[], object]] = {
        f"{quantity} of 72 pads": lambda quantity=quantity: found.readings(at, pad, quantity)
        for quantity in ("stress", "gap", "capacitance")
    }
    for name in fresh:
        cases[name] = lambda name=name: (found.__dict__.pop(name, None), getattr(found, name))
    return cases


def report(cases: dict[str, Callable[[], object]]) -> None:
    for name, call in cases.items():
        first = timed(call, 1)
        again = timed(call, 1 if name.startswith("ladder") else 5)
        tracemalloc.start()
        call()
        peak = tracemalloc.get_traced_memory()[1] / 1e6
        tracemalloc.stop()
        print(f"{name:28}{first:9.3f}{again:9.3f}{peak:11.1f}")


def main() -> None:
    print(f"{'':28}{'first s':>9}{'again s':>9}{'memory MB':>11}")
    report(CASES)
    report(readings(press(LAYER, [Sphere(radius=6e-3)])))
    whole = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"process at its largest: {whole:.0f} MB")


if __name__ == "__main__":
    main()
