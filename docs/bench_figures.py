"""Measure, draw docs/images/bench*.png and write the tables of docs/bench.md.

  python docs/bench_figures.py [short|full] [FILE]

FILE keeps the numbers as JSON. Nothing else should run meanwhile.
"""

import re
import sys
from pathlib import Path

from rich.progress import Progress
from threadpoolctl import threadpool_limits

from skinfield.cli.bench_tables import in_words
from skinfield.cli.report import say_notes
from skinfield.experiments.bench.files import write_bench
from skinfield.experiments.bench.grids import PAPER, PREPARED
from skinfield.experiments.bench.picture import (
    machine_line,
    picture,
    picture_of_truth,
    prepared_gain,
)
from skinfield.experiments.bench.run import Bench, run_bench
from skinfield.experiments.bench.settings import BenchSettings, bench_size
from skinfield.figures import save
from skinfield.figures.bench import written

DOCS = Path(__file__).parent
SHOWN = (None, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000)  # µs
NONE = "–"


def costs(bench: Bench) -> str:
    """Markdown: a row per method, a column per grid."""
    nodes = list(dict.fromkeys(row.nodes for row in bench.grids))
    lines = [f"| time per reading | {' | '.join(f'{n} × {n}' for n in nodes)} |"]
    lines.append("| --- |" + " --- |" * len(nodes))
    for name in dict.fromkeys(row.name for row in bench.grids):
        found = [row.seconds for row in bench.grids if row.name == name]
        cells = (
            f"{in_words(each['p50'])} ({in_words(each['mean'])} ± {in_words(each['std'])})"
            for each in found
        )
        lines.append(f"| {name} | {' | '.join(cells)} |")
    gains = (f"{prepared_gain(bench.grids, n):,.0f}" for n in nodes)
    lines.append(f"| {PAPER} over {PREPARED}, medians | {' | '.join(gains)} |")
    said = f"Median (mean ± standard deviation). {machine_line(bench)}."
    return "\n".join([*lines, "", said])


def anytime(bench: Bench) -> str:
    """Markdown: a row per solver and deadline, warm."""
    columns = ("solver", "deadline", "p50", "p99", "late", "error", "gap", "force", "place")
    lines = [f"| {' | '.join(columns)} |", "|" + " --- |" * len(columns)]
    for point in bench.points:
        deadline = None if point.deadline is None else round(1e6 * point.deadline)
        if deadline not in SHOWN or (point.start == "cold" and point.solver != PAPER):
            continue
        assert point.seconds is not None
        assert point.errors is not None
        assert point.force is not None
        cells = (
            point.solver,
            NONE if point.deadline is None else in_words(point.deadline),
            in_words(point.seconds["p50"]),
            in_words(point.seconds["p99"]),
            NONE if point.late is None else in_words(point.late["p99"]),
            written(float(f"{point.errors['p50']:.1g}"), "share"),
            NONE if point.gap is None else f"{point.gap['p50']:.0e}",
            f"{100 * point.force['p50']:.0f} %",
            NONE if point.place_median is None else f"{1e3 * point.place_median:.2f} mm",
        )
        lines.append(f"| {' | '.join(cells)} |")
    said = (
        f"{bench.nodes} × {bench.nodes} nodes, {bench.readings} readings, warm; error to the "
        "converged pressure, of the sum of forces and of the place: medians."
    )
    return "\n".join([*lines, "", said])


def put(text: str, name: str, table: str) -> str:
    """Replace what stands between the marks of a table."""
    pattern = rf"<!-- {name} -->\n.*?<!-- end -->"
    return re.sub(pattern, lambda _: f"<!-- {name} -->\n{table}\n<!-- end -->", text, flags=re.S)


def main(size: str = "short", file: str = "") -> None:
    """Measure and write."""
    with Progress() as bar, threadpool_limits(limits=1):
        task = bar.add_task("bench")
        found = run_bench(
            BenchSettings(size=bench_size(size)),
            lambda what, done, of: bar.update(task, description=what, completed=done, total=of),
        )
    if file:
        write_bench(found, file)
    save(picture(found), DOCS / "images" / "bench.png")
    save(picture_of_truth(found), DOCS / "images" / "bench-truth.png")
    page = DOCS / "bench.md"
    text = put(page.read_text(encoding="utf-8"), "costs", costs(found))
    page.write_text(put(text, "anytime", anytime(found)), encoding="utf-8")
    say_notes(found.warnings)


if __name__ == "__main__":
    main(*sys.argv[1:])
