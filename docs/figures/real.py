r"""Write the table of judge-a-solver.md on fingers on skins with real habits.

  skinfield cases DIR --habits real --count 48 --seed 1 \
    --skin rectangular:rows=24,columns=24,pitch_mm=6
  python docs/figures/real.py DIR [SOLVER ...]

Solvers are those of `skinfield validate`, by default auto; the trivial answer comes first: blobs of
neighbouring taxels above a threshold, their force in proportion to the sum of their readings.
"""

import sys
from collections.abc import Sequence

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

import skinfield as sf
from skinfield.cli import options
from skinfield.errors import Floats
from skinfield.lab.case_files import case_paths, load_case
from skinfield.lab.cases import Case
from skinfield.lab.score import GATE, Row, column, summarise, where
from skinfield.lab.validation import Entrant

THRESHOLD = 0.15  # ΔC/C₀: 3000 counts of CySkin's
FINGERS = range(6)


def blobs(case: Case, reading: Floats) -> list[Floats]:
    """Rows of the taxels of each blob of a reading (L,)."""
    high = np.flatnonzero(np.nan_to_num(reading) > THRESHOLD)
    pairs = case.patch.neighbours
    pairs = pairs[np.isin(pairs, high).all(axis=1)]
    count = len(case.patch)
    graph = coo_array((np.ones(len(pairs)), pairs.T), (count, count))
    labels = connected_components(graph, directed=False)[1]
    return [high[labels[high] == label] for label in np.unique(labels[high])]


def trivial_rows(cases: Sequence[Case]) -> list[Row]:
    """Scores of blobs, as those of a solver; newtons per reading are those that fit best."""
    found = []
    for case in cases:
        for reading in case.draws:
            sums = [float(reading[blob].sum()) for blob in blobs(case, reading)]
            found.append((case, reading, blobs(case, reading), sums))
    known = [
        case.truth.force / sum(sums) for case, _, _, sums in found if case.truth.force and sums
    ]
    scale = float(np.median(known))
    return [_scored(case, reading, parts, sums, scale) for case, reading, parts, sums in found]


def _scored(
    case: Case, reading: Floats, parts: list[Floats], sums: list[float], scale: float
) -> Row:
    from scipy.optimize import linear_sum_assignment

    plane, true = case.patch.plane, case.truth.contacts
    places = np.array([np.average(plane[part], axis=0, weights=reading[part]) for part in parts])
    apart = np.full((len(true), len(parts)), np.inf)
    for row, contact in enumerate(true):
        if parts:
            apart[row] = np.linalg.norm(places - contact.position, axis=1)
    rows, columns = linear_sum_assignment(np.where(apart <= GATE, apart, 10.0))
    pairs = [(i, j) for i, j in zip(rows, columns, strict=True) if apart[i, j] <= GATE]
    truth = case.truth.force
    return {
        "case": case.name,
        "contacts": len(true),
        "matched": len(pairs),
        "missed": len(true) - len(pairs),
        "false": len(parts) - len(pairs),
        "force_error": scale * sum(sums) / truth - 1 if truth else np.nan,
        "place_error_mm": float(np.mean([1e3 * apart[p] for p in pairs])) if pairs else np.nan,
        "contact_force_error": float(
            np.mean([abs(scale * sums[j] / true[i].force - 1) for i, j in pairs])
        )
        if pairs
        else np.nan,
    }


def line(name: str, rows: Sequence[Row]) -> str:
    """A row of the table."""
    all_ = summarise(rows)
    matched = sum(row["matched"] for row in rows)
    held = sum(row["force_held"] for row in rows) / matched if "force_held" in rows[0] else np.nan
    right = [
        100 * np.mean([row["matched"] + row["false"] == n for row in where(rows, contacts=n)])
        for n in FINGERS
    ]
    errors = np.abs(
        column(rows, "matched") + column(rows, "false") - column(rows, "contacts")
    ).mean()
    cells = [
        name,
        f"{100 * all_['force_error_median']:.0f} [{100 * all_['force_error_p90']:.0f}]",
        f"{all_['place_error_mm_median']:.1f} [{all_['place_error_mm_p90']:.1f}]",
        f"{100 * all_['contact_force_error_median']:.0f}",
        f"{100 * all_['missed']:.0f}",
        f"{all_['false_per_reading']:.2f}",
        f"{100 * all_['idle_touched']:.0f}",
        "-" if np.isnan(held) else f"{100 * held:.0f}",
        f"{100 * all_['count_right']:.0f} ({', '.join(f'{each:.0f}' for each in right)})",
        f"{errors:.2f}",
    ]
    return f"| {' | '.join(cells)} |"


def main(folder: str, *solvers: str) -> None:
    """Score and print."""
    cases = [load_case(path) for path in case_paths(folder)]
    sys.stdout.write(line("threshold, sum of readings", trivial_rows(cases)) + "\n")
    for name in solvers or (options.USUAL_SOLVER,):
        entrant = Entrant(solver=getattr(sf, options.SOLVERS[name])(), name=name)
        rows = [row for case in cases for row in entrant.rows(case)]
        sys.stdout.write(line(name, rows) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
