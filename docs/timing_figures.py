"""Measure, draw the pictures of bench.md and real-time.md, and write their tables.

  python docs/timing_figures.py bench [short|full] [FILE]    docs/images/bench*.png
  python docs/timing_figures.py jitter [SECONDS]             docs/images/lateness.png

FILE keeps the numbers as JSON. The second takes five times as long as SECONDS, by default five
minutes; SCHED_FIFO must be permitted and cyclictest installed. Nothing else should run meanwhile.
"""

import json
import re
import sys
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.progress import Progress
from threadpoolctl import threadpool_limits

from skinfield.cli.bench import virtual_boards
from skinfield.cli.bench_tables import in_words
from skinfield.cli.report import say_notes
from skinfield.errors import Floats
from skinfield.lab.bench.jitter import Jitter, JitterSettings, run_jitter
from skinfield.lab.bench.machine import this_machine
from skinfield.lab.bench.picture import (
    machine_line,
    picture,
    picture_of_truth,
    written,
)
from skinfield.lab.bench.run import PAPER, PREPARED, prepared_gain, run_bench
from skinfield.lab.bench.scene import BenchSettings, bench_size
from skinfield.loop.realtime import Quantiles, RealTime
from skinfield.plot import save
from skinfield.plot.style import BLUE, FAINT, ORANGE, QUIET, add_title, new_figure, style
from skinfield.solve import GaussianField

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


DOCS = Path(__file__).parent
SHOWN = (None, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000)  # µs
NONE = "–"


def costs(bench: dict[str, Any]) -> str:
    """Markdown: a row per method, a column per grid."""
    grids = bench["grids"]
    nodes = list(dict.fromkeys(row["nodes"] for row in grids))
    lines = [f"| time per reading | {' | '.join(f'{n} × {n}' for n in nodes)} |"]
    lines.append("| --- |" + " --- |" * len(nodes))
    for name in dict.fromkeys(row["name"] for row in grids):
        times = [row["seconds_us"] for row in grids if row["name"] == name]
        cells = ("{} ({} ± {})".format(*_words(each, "p50", "mean", "std")) for each in times)
        lines.append(f"| {name} | {' | '.join(cells)} |")
    gains = (f"{prepared_gain(grids, n):,.0f}" for n in nodes)
    lines.append(f"| {PAPER} over {PREPARED}, medians | {' | '.join(gains)} |")
    said = f"Median (mean ± standard deviation). {machine_line(bench)}."
    return "\n".join([*lines, "", said])


def _words(times: dict[str, float], *keys: str) -> list[str]:
    return [in_words(1e-6 * times[key]) for key in keys]


def anytime(bench: dict[str, Any]) -> str:
    """Markdown: a row per solver and deadline, warm."""
    columns = ("solver", "deadline", "p50", "p99", "late", "error", "gap", "force", "place")
    lines = [f"| {' | '.join(columns)} |", "|" + " --- |" * len(columns)]
    for point in bench["points"]:
        deadline, place = point["deadline_us"], point["place_median_mm"]
        if deadline not in SHOWN or (point["start"] == "cold" and point["solver"] != PAPER):
            continue
        cells = (
            point["solver"],
            NONE if deadline is None else in_words(1e-6 * deadline),
            *_words(point["seconds_us"], "p50", "p99"),
            NONE if point["late_us"] is None else _words(point["late_us"], "p99")[0],
            written(float(f"{point['errors']['p50']:.1g}"), "share"),
            NONE if point["gap"] is None else f"{point['gap']['p50']:.0e}",
            f"{100 * point['force']['p50']:.0f} %",
            NONE if place is None else f"{place:.2f} mm",
        )
        lines.append(f"| {' | '.join(cells)} |")
    said = (
        f"{bench['nodes']} × {bench['nodes']} nodes, {bench['readings']} readings, warm; error to "
        "the converged pressure, of the sum of forces and of the place: medians."
    )
    return "\n".join([*lines, "", said])


def put(text: str, name: str, table: str) -> str:
    """Replace what stands between the marks of a table."""
    pattern = rf"<!-- {name} -->\n.*?<!-- end -->"
    return re.sub(pattern, lambda _: f"<!-- {name} -->\n{table}\n<!-- end -->", text, flags=re.S)


def draw_bench(size: str = "short", file: str = "") -> None:
    """Measure and write."""
    with Progress() as bar, threadpool_limits(limits=1):
        task = bar.add_task("bench")
        found = run_bench(
            BenchSettings(size=bench_size(size)),
            lambda what, done, of: bar.update(task, description=what, completed=done, total=of),
        )
    if file:
        Path(file).write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    save(picture(found), DOCS / "images" / "bench.png")
    save(picture_of_truth(found), DOCS / "images" / "bench-truth.png")
    page = DOCS / "bench.md"
    text = put(page.read_text(encoding="utf-8"), "costs", costs(found))
    page.write_text(put(text, "anytime", anytime(found)), encoding="utf-8")
    say_notes(found["warnings"])


ROWS = {
    "wakes only": {"load": "none"},
    "engine": {},
    "engine, linear": {"solver": GaussianField()},
    "engine, nothing beside it": {"busy": 0},
    "engine, ordinary scheduling": {"real_time": RealTime(priority=0)},
}


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


def draw_lateness(
    found: dict[str, Jitter], panels: dict[str, dict[str, str]], foot: str
) -> "Figure":
    """Share of wakes that were later than a time, beside cyclictest, on logarithmic axes."""
    latest = max(float(each.late[0][-1]) for each in found.values())
    with style():
        figure = new_figure(9.6, 4.0)
        for n, (title, lines) in enumerate(panels.items()):
            axes = figure.add_axes((0.075 + 0.495 * n, 0.17, 0.4, 0.66))
            paired = found[next(iter(lines))].paired_late
            if paired is not None:
                draw_line(axes, paired, BLUE, "cyclictest beside it", dashes=(4, 2))
            for (name, label), colour in zip(lines.items(), ("#009e73", ORANGE), strict=False):
                draw_line(axes, found[name].late, colour, label)
            axes.set(xscale="log", yscale="log", xlim=(5e-6, 1.3 * latest), ylim=(1e-5, 1.3))
            axes.set_yticks([1.0, 0.1, 0.01, 1e-3, 1e-4], ["all", "10 %", "1 %", "0.1 %", "0.01 %"])
            times = [time for time in (1e-5, 1e-4, 1e-3, 1e-2, 1e-1) if time <= latest]
            axes.set_xticks(times, [written(time, "time") for time in times])
            axes.minorticks_off()
            axes.set(xlabel="time after it was due", ylabel="wakes that are later")
            axes.grid(color=FAINT, lw=0.5, alpha=0.7)
            axes.spines[["top", "right"]].set_visible(False)
            axes.legend(frameon=False, fontsize=8, loc="lower left")
            add_title(axes, "ab"[n], title, "beside two busy processes, 1 kHz")
        figure.text(0.985, 0.012, foot, ha="right", va="bottom", fontsize=6.5, color=QUIET)
    return figure


def draw_line(
    axes: "Axes", late: tuple[Floats, Floats], colour: str, label: str, dashes: tuple[int, ...] = ()
) -> None:
    """From the first wake to the latest, which none is later than."""
    time, share = late
    some = share > 0
    x, y = np.append(time[some], time[-1]), np.append(share[some], share[some][-1:])
    axes.plot(x, y, color=colour, ls=(0, dashes) if dashes else "-", lw=1.6, label=label)


def tell(name: str) -> Callable[[str], None]:
    """Say what happens, on stderr."""
    return lambda text: say_notes([f"{name}: {text}"])


def draw_jitter(seconds: float = 60.0) -> None:
    """Measure and write."""
    found = {}
    for name, more in ROWS.items():
        settings = JitterSettings(duration=seconds, **more)  # type: ignore[arg-type]
        found[name] = run_jitter(settings, tell(name), virtual_boards)
    machine = this_machine()
    foot = f"{machine.processor}, {machine.cores} CPUs, {machine.system}, {date.today()}"
    lines = {
        "A loop that only wakes": {"wakes only": "wakes only"},
        "The engine": {
            "engine": "engine, SCHED_FIFO",
            "engine, ordinary scheduling": "engine, ordinary scheduling",
        },
    }
    save(draw_lateness(found, lines, foot), DOCS / "images" / "lateness.png")
    page = DOCS / "real-time.md"
    said = (
        f"{seconds:g} s each at 1 kHz beside two busy processes, cyclictest on the same CPU; "
        f"{counts(found)}; load of the machine before: {found['engine'].company.load:.1f}"
    )
    text = f"{table(found)}\n\n{said}. {foot}."
    page.write_text(put(page.read_text(encoding="utf-8"), "jitter", text), encoding="utf-8")
    say_notes({each.no_pair for each in found.values() if each.no_pair})


if __name__ == "__main__":
    what, *words = sys.argv[1:] or ["bench"]
    if what == "bench":
        draw_bench(*words)
    elif what == "jitter":
        draw_jitter(*map(float, words))
    else:
        raise SystemExit(f"{what!r} is neither bench nor jitter")
