"""Faults planted in recordings of touched skins: how many are found, how many others are lost.

    python benchmarks/fault_detection.py [--draws N] [--seed N] [--json FILE]

Touches pass over a skin for 5 s, or a hand holds on to it all the time; noise has heavy tails and
another size for each taxel, gains are spread by 20 %, boards clip and round. Touches are soft discs
and lobes, nothing of which the fault finder knows.

What only touches tell (no answer, swaps) counts as shown where the taxel, were it healthy, would
have read `CLEAR` deviations of its noise above rest in `READINGS` readings. At the end shares are
summed over settings, of what was planted and of what was shown.
"""

import argparse
import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import skinfield as sf

Numbers = NDArray[np.float64]
Rows = NDArray[np.int64]


class Board(NamedTuple):
    """What a board sends: rest and its spread, counts of a firm touch, noise, range."""

    rest: float
    rest_spread: float
    touch: float  # counts, below 0 where pressure lowers them
    noise: float
    noise_spread: float  # of the logarithm
    lowest: float
    highest: float


BOARDS = {
    "bytes": Board(240.0, 1.5, -90.0, 2.5, 0.3, 0.0, 255.0),
    "clipped words": Board(0.0, 0.0, 12000.0, 90.0, 0.5, 0.0, 65535.0),
    "plain words": Board(20000.0, 3000.0, 8000.0, 40.0, 0.4, 0.0, 65535.0),
}
KINDS = (
    "dead", "deaf", "stuck at 0", "stuck at a value", "stuck at full scale", "stops", "noisy x 10",
    "absent", "warm", "swapped", "frozen board", "swapped boards",
)  # fmt: skip
OF_BOARDS = ("frozen board", "swapped boards")
BY_TOUCH = ("deaf", "warm", "swapped", "swapped boards")
CLEAR, READINGS = 10.0, 3


def large_skin(taxels: int = 640) -> sf.Patch:
    """Patch of so many taxels on boards of ten in triangles: rows of a hexagonal lattice."""
    side = int(np.ceil(np.sqrt(taxels)))
    row, column = np.divmod(np.arange(taxels), side)
    plane = 6.6e-3 * np.column_stack([column + 0.5 * (row % 2), row * 3**0.5 / 2])
    block = (row // 3) * side + column // 3
    order = np.argsort(block, kind="stable")
    module = np.unique(block[order], return_inverse=True)[1]
    return sf.Patch(plane[order], module=module)


def footprint(patch: sf.Patch, centre: Numbers, rng: np.random.Generator) -> Numbers:
    """How much each taxel (T, L) feels of a finger, one soft disc or two, centred at (T, 2)."""
    radius, edge = rng.uniform(0.7, 1.5), rng.uniform(0.15, 0.4)
    lobes = [np.zeros(2)]
    if rng.random() < 0.3:
        lobes.append(rng.normal(size=2) * radius * patch.pitch)
    felt = np.zeros((len(centre), len(patch)))
    for lobe in lobes:
        away = np.linalg.norm(patch.plane - (centre + lobe)[:, None], axis=2) / patch.pitch
        felt = np.maximum(felt, 1.0 / (1.0 + np.exp((away - radius) / edge)))
    return felt


def strokes(
    patch: sf.Patch, times: Numbers, fingers: int, rng: np.random.Generator
) -> tuple[Numbers, Numbers]:
    """Load (T, L) of fingers that pass over a skin again and again, and least distance (L,)."""
    low, high = patch.plane.min(axis=0), patch.plane.max(axis=0)
    load, nearest = np.zeros((len(times), len(patch))), np.full(len(patch), np.inf)
    for _ in range(fingers):
        start = times[0] + rng.uniform(0.0, 0.3)
        while start < times[-1]:
            speed = rng.uniform(0.04, 0.12)  # m/s
            begin, angle = rng.uniform(low, high), rng.uniform(0.0, 2.0 * np.pi)
            way = np.array([np.cos(angle), np.sin(angle)])
            reach = float(np.linalg.norm(high - low))
            rows = np.flatnonzero((times >= start) & (times < start + reach / speed))
            centre = begin + way * (speed * (times[rows] - start) - reach / 2.0)[:, None]
            inside = ((centre > low - 5e-3) & (centre < high + 5e-3)).all(axis=1)
            rows, centre = rows[inside], centre[inside]
            if len(rows):
                force = rng.uniform(0.5, 1.0) * (1.0 + 0.1 * rng.normal(size=(len(rows), 1)))
                load[rows] = np.maximum(load[rows], force * footprint(patch, centre, rng))
                away = np.linalg.norm(patch.plane - centre[:, None], axis=2).min(axis=0)
                nearest = np.minimum(nearest, away)
                start = times[rows[-1]] + rng.uniform(0.05, 0.3)
            else:
                start += 0.1
    return load, nearest


def hand(patch: sf.Patch, times: Numbers, rng: np.random.Generator) -> Numbers:
    """Load (T, L) of a hand that holds on from the first to the last reading."""
    low, high = patch.plane.min(axis=0), patch.plane.max(axis=0)
    load = np.zeros((len(times), len(patch)))
    for _ in range(max(5, len(patch) // 60)):
        angle, length = rng.uniform(0.0, np.pi), rng.uniform(0.01, 0.04)
        along = (
            np.linspace(-0.5, 0.5, 6)[:, None] * length * np.array([np.cos(angle), np.sin(angle)])
        )
        shape = footprint(patch, rng.uniform(low, high) + along, rng).max(axis=0)
        phase, period = rng.uniform(0.0, 2.0 * np.pi, 2), rng.uniform([0.6, 2.0], [2.0, 8.0])
        grip = 1.0 + 0.15 * np.sin(2.0 * np.pi * times / period[0] + phase[0])
        grip += 0.25 * np.sin(2.0 * np.pi * times / period[1] + phase[1])
        tremor = 0.02 * rng.normal(size=len(times))
        load = np.maximum(load, rng.uniform(0.3, 1.2) * (grip + tremor)[:, None] * shape)
    return load


def counts_of(
    load: Numbers, board: Board, rng: np.random.Generator, heavy: bool = True
) -> tuple[Numbers, Numbers]:
    """Counts (T, L) of a load, and what they would be untouched, before the board clips."""
    taxels = load.shape[1]
    gain = board.touch * np.exp(0.2 * rng.standard_normal(taxels))
    rest = board.rest + board.rest_spread * rng.standard_normal(taxels)
    size = board.noise * np.exp(board.noise_spread * rng.standard_normal(taxels))
    noise = rng.standard_t(3.0, load.shape) / 3**0.5 if heavy else rng.standard_normal(load.shape)
    untouched = rest + size * noise
    return untouched + gain * load, untouched


def sent(counts: Numbers, board: Board) -> Numbers:
    """As the board clips and rounds it."""
    return np.clip(np.rint(counts), board.lowest, board.highest)


def plant(
    kind: str,
    rows: Rows,
    counts: Numbers,
    untouched: Numbers,
    board: Board,
    rng: np.random.Generator,
) -> Numbers:
    """Counts with a fault at some taxels: (K,) rows, or (2, K) that are swapped."""
    broken, readings = counts.copy(), len(counts)
    rest = np.median(untouched[:, rows], axis=0)
    if kind in ("dead", "frozen board"):
        broken[:, rows] = rest
    elif kind == "deaf":
        broken[:, rows] = untouched[:, rows]
    elif kind == "stuck at 0":
        broken[:, rows] = 0.0
    elif kind == "stuck at a value":
        broken[:, rows] = board.rest + board.touch * rng.uniform(0.3, 0.8, len(rows))
    elif kind == "stuck at full scale":
        broken[:, rows] = board.highest
    elif kind == "stops":
        at = readings // 3
        broken[at:, rows] = counts[at, rows]
    elif kind == "noisy x 10":
        own = untouched[:, rows] - rest
        broken[:, rows] += 9.0 * own
    elif kind == "absent":
        broken[:, rows] = np.nan
    elif kind == "warm":
        drift = np.cumsum(np.full((readings, len(rows)), 1.0 / readings), axis=0)
        broken[:, rows] = untouched[:, rows] + abs(board.touch) * rng.uniform(0.3, 0.6) * drift
    else:
        broken[:, rows.reshape(-1)] = counts[:, rows[::-1].reshape(-1)]
    return broken


def draw_rows(
    kind: str, patch: sf.Patch, touched: NDArray[np.bool_], rng: np.random.Generator
) -> Rows:
    """Taxels that get a fault: touched ones, or boards."""
    boards = np.unique(patch.module)
    if kind == "frozen board":
        return np.flatnonzero(patch.module == rng.choice(boards))
    if kind == "swapped boards":
        size = np.bincount(patch.module)
        alike = boards[size[boards] == np.bincount(size[boards]).argmax()]
        return np.stack([np.flatnonzero(patch.module == b) for b in rng.choice(alike, 2, False)])
    each = np.flatnonzero(touched)
    return rng.choice(each, (2, 1) if kind == "swapped" else 1, False)


def recording(
    patch: sf.Patch, board: Board, rate: float, rng: np.random.Generator, scene: str = "strokes"
) -> tuple[Numbers, Numbers, NDArray[np.bool_], Numbers]:
    """Counts before the board, untouched ones, taxels that were touched, and the load (T, L)."""
    times = np.arange(int(5.0 * rate)) / rate
    load, touched = np.zeros((len(times), len(patch))), np.zeros(len(patch), np.bool_)
    if scene in ("strokes", "strokes on a resting hand"):
        load, nearest = strokes(patch, times, max(2, len(patch) // 35), rng)
        touched = nearest < 0.6 * patch.pitch
    if scene in ("hand", "strokes on a resting hand"):
        held = hand(patch, times, rng)
        load = load + (held if scene == "hand" else 0.5 * held)
    counts, untouched = counts_of(load, board, rng)
    return counts, untouched, touched, load


def found(kind: str, name: str, patch: sf.Patch, rate: float, draws: int, seed: int) -> Numbers:
    """Faults planted, found, other taxels, lost among them, faults shown, found of these: sums."""
    board, total = BOARDS[name], np.zeros(6)
    for draw in range(draws):
        rng = np.random.default_rng([seed, draw])
        counts, untouched, touched, _ = recording(patch, board, rate, rng)
        rows = draw_rows(kind, patch, touched, rng)
        usable = sf.find_faults(
            sent(plant(kind, rows, counts, untouched, board, rng), board), patch
        ).usable
        broken = np.zeros(len(patch), np.bool_)
        broken[rows.reshape(-1)] = True
        above = np.abs(counts - untouched) > CLEAR * untouched.std(axis=0)
        shown = broken & ((above.sum(axis=0) >= READINGS) | (kind not in BY_TOUCH))
        kept = (broken, broken & ~usable, ~broken, ~broken & ~usable, shown, shown & ~usable)
        total += [each.sum() for each in kept]
    return total


def lost(scene: str, name: str, patch: sf.Patch, rate: float, draws: int, seed: int) -> Numbers:
    """Healthy taxels, and lost ones; those pressed by a third of a firm touch, and lost ones."""
    board, total = BOARDS[name], np.zeros(4)
    for draw in range(draws):
        rng = np.random.default_rng([seed, draw])
        counts, _, _, load = recording(patch, board, rate, rng, scene)
        usable = sf.find_faults(sent(counts, board), patch).usable
        pressed = load.max(axis=0) > 1.0 / 3.0
        total += len(usable), (~usable).sum(), pressed.sum(), (pressed & ~usable).sum()
    return total


def print_sums(rows: list[dict[str, Any]]) -> None:
    """Shares found by kind, board and rate, then over all, and what was lost."""
    for fast in (True, False):
        print("50-100 Hz" if fast else "10 Hz", "found, % of planted by board; of all, of shown")
        own = [row for row in rows if "fault" in row and (row["rate"] >= 50.0) == fast]
        for kind in (*KINDS, "one taxel", "all"):
            kinds = set(KINDS) - set(OF_BOARDS) if kind == "one taxel" else {kind}
            of = [row for row in own if kind == "all" or row["fault"] in kinds]
            parts = [[row for row in of if row["board"] == name] for name in BOARDS]
            shares = [share(part, "found", "planted") for part in (*parts, of)]
            shares.append(share(of, "shown found", "shown"))
            print(f"{kind:20}", " ".join(f"{100.0 * each:6.1f}" for each in shares))
    for part in ([row for row in rows if "scene" in row], [row for row in rows if "fault" in row]):
        total, lost = (sum(row.get(k, 0.0) for row in part) for k in ("healthy", "lost"))
        total += sum(row.get("others", 0.0) for row in part)
        pressed, gone = (sum(row.get(k, 0.0) for row in part) for k in ("pressed", "pressed lost"))
        print(f"healthy {total:.0f}, lost {lost:.0f}; pressed {pressed:.0f}, lost {gone:.0f}")


def share(rows: list[dict[str, Any]], part: str, whole: str) -> float:
    """Mean over kinds of fault of the share of one sum in another."""
    kinds = {row["fault"] for row in rows}
    each = [[row for row in rows if row["fault"] == kind] for kind in kinds]
    return float(np.mean([sum(r[part] for r in of) / sum(r[whole] for r in of) for of in each]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    small, large = sf.layouts.hexagon72(), large_skin()
    settings = [(small, 100.0), (small, 50.0), (small, 10.0), (large, 50.0), (large, 10.0)]
    rows = []
    for name in BOARDS:
        for patch, rate in settings:
            draws = given.draws if patch is small else max(2, given.draws // 4)
            where = {"board": name, "taxels": len(patch), "rate": rate}
            for kind in KINDS:
                planted, hits, others, false, shown, seen = found(
                    kind, name, patch, rate, draws, given.seed
                )
                rows.append(where | {"fault": kind, "planted": planted, "found": hits})
                rows[-1] |= {"others": others, "lost": false, "shown": shown, "shown found": seen}
                at = f"{name:14} {len(patch):4} at {rate:3.0f} Hz "
                out = f"{false / others * 1e3:5.2f} of 1000 others lost"
                print(f"{at} {kind:20} {hits / planted:6.1%} of {planted:4.0f} found, {out}")
            for scene in ("strokes", "hand", "strokes on a resting hand", "idle"):
                healthy, false, pressed, gone = lost(
                    scene, name, patch, rate, draws, given.seed + 1
                )
                rows.append(where | {"scene": scene, "healthy": healthy, "lost": false})
                rows[-1] |= {"pressed": pressed, "pressed lost": gone}
                out = f"{false / healthy * 1e3:5.2f} of 1000; of {pressed:5.0f} pressed {gone:.0f}"
                print(f"{at} healthy, {scene:26} lost {out}")
    print_sums(rows)
    if given.json is not None:
        given.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
