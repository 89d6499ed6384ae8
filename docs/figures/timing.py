"""Draw the picture of judge-a-solver.md; write its tables and that of real-time.md.

  python docs/figures/timing.py bench [short|full] [FILE]    docs/images/bench.png
  python docs/figures/timing.py jitter [SECONDS]

FILE keeps the numbers as JSON. The second takes four times as long as SECONDS, by default four
minutes; SCHED_FIFO must be permitted and cyclictest installed. Nothing else should run meanwhile.
"""

import json
import re
import sys
from collections.abc import Callable
from dataclasses import replace
from datetime import date
from io import StringIO
from pathlib import Path

from rich.box import MARKDOWN
from rich.console import Console
from rich.progress import Progress
from rich.table import Table
from threadpoolctl import threadpool_limits

from skinfield.cli.bench import virtual_boards
from skinfield.cli.bench_tables import jitter_lines, jitter_table, tables
from skinfield.cli.report import say_notes
from skinfield.lab.bench.jitter import JitterSettings, run_jitter
from skinfield.lab.bench.machine import this_machine
from skinfield.lab.bench.picture import machine_line, picture
from skinfield.lab.bench.run import run_bench
from skinfield.lab.bench.scene import SIZES
from skinfield.loop.realtime import RealTime
from skinfield.plot import save
from skinfield.solve import GaussianField

DOCS = Path(__file__).parents[1]
PAGE = DOCS / "how-to" / "judge-a-solver.md"
NODES, DEADLINES = (20, 40), (100.0, None)  # µs; of what is measured, what the page shows
HIDDEN = ("| paper, inversion alone |", "| NonNegative to 1e-4", "| ContactFit within 2 ms |")


def markdown(table: Table) -> str:
    """A table of the command as Markdown, with its title below."""
    title, table.title, table.box = table.title, None, MARKDOWN
    for row in table.rows:
        row.end_section = False
    out = StringIO()
    Console(file=out, width=1000).print(table)
    lines = [line.strip() for line in out.getvalue().splitlines() if line.strip()]
    lines = [re.sub(r"  +", " ", re.sub(r"-{4,}", " --- ", line)) for line in lines]
    return "\n".join([*lines, "", f"{title}."])


def put(page: Path, name: str, text: str) -> None:
    """Replace what stands between the marks of a table on a page."""
    pattern, marked = rf"<!-- {name} -->\n.*?<!-- end -->", f"<!-- {name} -->\n{text}\n<!-- end -->"
    before = page.read_text(encoding="utf-8")
    page.write_text(re.sub(pattern, lambda _: marked, before, flags=re.S), encoding="utf-8")


def draw_bench(size: str = "short", file: str = "") -> None:
    """Measure and write."""
    with Progress() as bar, threadpool_limits(limits=1):
        task = bar.add_task("bench")
        found = run_bench(
            SIZES[size],
            show=lambda what, done, of: bar.update(
                task, description=what, completed=done, total=of
            ),
        )
    if file:
        Path(file).write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    save(picture(found), DOCS / "images" / "bench.png")
    shown = found | {
        "grids": [row for row in found["grids"] if row["nodes"] in NODES],
        "points": [row for row in found["points"] if row["deadline_us"] in DEADLINES],
    }
    for name, table in zip(("costs", "anytime"), tables(shown), strict=True):
        lines = markdown(table).splitlines()
        put(PAGE, name, "\n".join(each for each in lines if not each.startswith(HIDDEN)))
    put(PAGE, "machine", f"{machine_line(found)}.")
    say_notes(found["warnings"])


LOOPS = {
    "engine": JitterSettings(),
    "engine, linear": JitterSettings(solver=GaussianField()),
    "engine, nothing beside it": JitterSettings(busy=0),
    "engine, ordinary scheduling": JitterSettings(real_time=RealTime(priority=0)),
}


def tell(name: str) -> Callable[[str], None]:
    """Say what happens, on stderr."""
    return lambda text: say_notes([f"{name}: {text}"])


def measure_jitter(seconds: float = 60.0) -> None:
    """Measure and write."""
    parts = []
    for name, settings in LOOPS.items():
        found = run_jitter(replace(settings, duration=seconds), tell(name), virtual_boards)
        parts += [f"**{name}**", markdown(jitter_table(found)), "; ".join(jitter_lines(found))]
        say_notes([found["no_cyclictest"]] if found["no_cyclictest"] else [])
    machine = this_machine()
    parts.append(f"{machine['processor']}, {machine['cores']} CPUs, {date.today()}.")
    put(DOCS / "explanation" / "real-time.md", "jitter", "\n\n".join(parts))


if __name__ == "__main__":
    what, *words = sys.argv[1:] or ["bench"]
    if what == "bench":
        draw_bench(*words)
    elif what == "jitter":
        measure_jitter(*map(float, words))
    else:
        raise SystemExit(f"{what!r} is neither bench nor jitter")
