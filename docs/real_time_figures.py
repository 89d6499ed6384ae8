"""Measure, draw docs/images/lateness.png and write the table of docs/real-time.md.

  python docs/real_time_figures.py [SECONDS]

Takes five times as long, by default five minutes. Nothing else should run meanwhile. SCHED_FIFO
must be permitted and cyclictest installed.
"""

import sys
from collections.abc import Callable
from datetime import date
from pathlib import Path

from bench_figures import put

from skinfield.cli.bench_tables import in_words
from skinfield.cli.jitter_run import Jitter, JitterSettings, run_jitter
from skinfield.cli.report import say_notes
from skinfield.experiments.bench.machine import this_machine
from skinfield.figures import save
from skinfield.figures.lateness import Late, draw_lateness
from skinfield.inverse import GaussianField
from skinfield.realtime import Quantiles, RealTime

DOCS = Path(__file__).parent
ROWS = {
    "wakes only": {"load": "none"},
    "engine": {},
    "engine, linear": {"solver": GaussianField()},
    "engine, nothing beside it": {"busy": 0},
    "engine, ordinary scheduling": {"real_time": RealTime(priority=0)},
}
NONE = "–"


def table(found: dict[str, Jitter]) -> str:
    """Markdown: a row per loop and time."""
    lines = ["| loop | time | p50 | p99 | p99.9 | max |", "| --- | --- | --- | --- | --- | --- |"]
    for name, each in found.items():
        timing = each.timing
        rows: dict[str, Quantiles | None] = {"cyclictest": each.paired, "wake": timing.wake}
        if each.settings.load != "none":
            rows["ready"] = timing.ready
        for what, times in rows.items():
            lines.append(f"| {name} | {what} | {cells(times)} |")
            name = ""
        ratios = [each.ratio(quantile) for quantile in ("p50", "p99", "p999", "max")]
        words = [NONE if ratio is None else f"{ratio:.2f}" for ratio in ratios]
        lines.append(f"| | wake over cyclictest | {' | '.join(words)} |")
    return "\n".join(lines)


def cells(times: Quantiles | None) -> str:
    """Four cells."""
    if times is None:
        return " | ".join([NONE] * 4)
    return " | ".join(map(in_words, (times.p50, times.p99, times.p999, times.max)))


def counts(found: dict[str, Jitter]) -> str:
    """What came late, in a sentence each."""
    said = []
    for name, each in found.items():
        timing = each.timing
        said.append(
            f"{name}: {timing.cycles:,} cycles, {timing.late} late, {timing.skipped} skipped"
        )
    return "; ".join(said)


def tell(name: str) -> Callable[[str], None]:
    """Say what happens, on stderr."""
    return lambda text: say_notes([f"{name}: {text}"])


def main(seconds: float = 60.0) -> None:
    """Measure and write."""
    found = {}
    for name, more in ROWS.items():
        settings = JitterSettings(seconds=seconds, **more)  # type: ignore[arg-type]
        found[name] = run_jitter(settings, tell(name))
    machine = this_machine()
    foot = f"{machine.processor}, {machine.cores} CPUs, {machine.system}, {date.today()}"
    left = [Late("wakes only", *found["wakes only"].late, 2)]
    right = [
        Late("engine, SCHED_FIFO", *found["engine"].late, 2),
        Late("engine, ordinary scheduling", *found["engine, ordinary scheduling"].late, 0),
    ]
    for loops, name in ((left, "wakes only"), (right, "engine")):
        paired = found[name].paired_late
        if paired is not None:
            loops.insert(0, Late("cyclictest beside it", *paired, 1, "dashed"))
    note = "beside two busy processes, 1 kHz"
    figure = draw_lateness(
        ("A loop that only wakes", f"SCHED_FIFO, {note}", left), ("The engine", note, right), foot
    )
    save(figure, DOCS / "images" / "lateness.png")
    page = DOCS / "real-time.md"
    said = (
        f"{seconds:g} s each at 1 kHz beside two busy processes, cyclictest on the same CPU; "
        f"{counts(found)}; load of the machine before: {found['engine'].company.load:.1f}"
    )
    text = f"{table(found)}\n\n{said}. {foot}."
    page.write_text(put(page.read_text(encoding="utf-8"), "jitter", text), encoding="utf-8")
    say_notes({each.no_pair for each in found.values() if each.no_pair})


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
