"""Tables of `skinfield bench`: what a reading costs, error against time, jitter of a live loop."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.box import SIMPLE_HEAD

from skinfield.cli.report import NONE, table
from skinfield.lab.bench.run import INVERSION, PAPER, PAPER_REST_MS, Row, prepared_gain
from skinfield.plot.style import number

if TYPE_CHECKING:
    from rich.table import Table

    from skinfield.lab.bench.jitter import Jitter
    from skinfield.loop.realtime import Quantiles

TINY = 1e-5
LOOK = {"box": SIMPLE_HEAD, "padding": (0, 1)}
QUANTILES = ("p50", "p99", "p999", "max")
NAMES = {"p50": "p50", "p99": "p99", "p999": "p99.9", "max": "max"}
MEANING = {
    "wake": "from due to awake",
    "acquired": "from awake until the readings are taken in",
    "ready": "from awake until the estimate is published",
    "latency": "from the newest reading until its estimate is published",
    "cycle": "from awake until all is done",
}


def tables(bench: Mapping[str, Any]) -> Iterator["Table"]:
    """What a reading costs; error against time, of the solvers."""
    yield _costs(bench["grids"])
    yield _anytime(bench)


def _costs(grids: Sequence[Row]) -> "Table":
    nodes = list(dict.fromkeys(row["nodes"] for row in grids))
    made = table(
        "time per reading: mean ± standard deviation (99th percentile)",
        ("method",),
        tuple(f"{each} x {each}" for each in nodes),
        **LOOK,
    )
    for name in dict.fromkeys(row["name"] for row in grids):
        made.add_row(name, *(_cost(row) for row in grids if row["name"] == name))
    gains = (f"{prepared_gain(grids, each):,.0f}" for each in nodes)
    made.add_row("paper over prepared, medians", *gains)
    made.add_row("paper without its inversion, here", *(_rest(grids, each) for each in nodes))
    stated = (PAPER_REST_MS.get(each) for each in nodes)
    published = (NONE if each is None else f"{each:g} ms" for each in stated)
    made.add_row("the same, as the paper states", *published)
    return made


def _cost(row: Row) -> str:
    mean, std, p99 = (_of(row["seconds_us"], key) for key in ("mean", "std", "p99"))
    text = f"{mean} ± {std} ({p99})"
    if row["certified"] is not None and row["certified"] < 1.0:
        text += f", {100 * row['certified']:.0f} % certified"
    return text


def _rest(grids: Sequence[Row], nodes: int) -> str:
    """Of the paper's algorithm beside the inversion, by medians."""
    times = {row["name"]: row["seconds_us"]["p50"] for row in grids if row["nodes"] == nodes}
    return in_words(1e-6 * max(times[PAPER] - times[INVERSION], 0.0))


def _anytime(bench: Mapping[str, Any]) -> "Table":
    nodes = bench["nodes"]
    made = table(
        f"two moving fingers, {nodes} x {nodes} nodes, {bench['readings']} readings: "
        "error to the converged pressure and to the truth, medians",
        ("solver",),
        ("deadline", "p50", "error", "gap", "force", "place", "missed"),
        **LOOK,
    )
    for point in bench["points"]:
        place = point["place_median_mm"]
        made.add_row(
            f"{point['solver']}, {point['start']}",
            _deadline(point),
            _of(point["seconds_us"], "p50"),
            _share(point["errors"] and point["errors"]["p50"]),
            _gap(point),
            _share(point["force"] and point["force"]["p50"]),
            NONE if place is None else f"{place:.2f} mm",
            f"{point['missed']:.2f}",
            end_section=point["deadline_us"] is None,
        )
    return made


def _deadline(row: Row) -> str:
    return NONE if row["deadline_us"] is None else in_words(1e-6 * row["deadline_us"])


def _gap(row: Row) -> str:
    return NONE if row["gap"] is None else f"{row['gap']['p50']:.0e}"


def in_words(seconds: float) -> str:
    """Such as "20 µs", "1.5 ms" and "0 µs", with two or three digits."""
    if seconds <= 0.0:
        return "0 µs"
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= 0.9995 * size:
            return f"{_three(seconds / size)} {unit}"
    return f"{_three(1e6 * seconds)} µs"


def _three(value: float) -> str:
    """Three digits, also where they round up to the next power of ten."""
    return number(float(f"{value:.3g}"))


def _of(found: Mapping[str, float] | None, key: str) -> str:
    """Of a distribution of times in µs."""
    return NONE if found is None else in_words(1e-6 * found[key])


def _share(value: float | None) -> str:
    if value is None:
        return NONE
    return f"< {100 * TINY:g} %" if 0.0 < value < TINY else f"{float(f'{100 * value:.2g}'):g} %"


# ---- jitter


def jitter_table(jitter: "Jitter") -> "Table":
    """Times of the live loop beside those of cyclictest."""
    settings = jitter.settings
    solver = f"{type(settings.solver).__name__}, virtual skin over UDP"
    made = table(
        f"{solver}, {settings.rate_hz:g} cycles per second for "
        f"{settings.duration:g} s beside {settings.busy} busy processes",
        ("time",),
        [NAMES[name] for name in QUANTILES],
    )
    made.add_row("cyclictest on the same CPU, wake", *_row(jitter.paired))
    for name, meaning in MEANING.items():
        if getattr(jitter.timing, name) is not None:
            made.add_row(f"{name}: {meaning}", *_row(getattr(jitter.timing, name)))
    ratios = [jitter.ratio(name) for name in QUANTILES]
    words = [NONE if each is None else f"{each:.2f}" for each in ratios]
    made.add_row("wake over cyclictest", *words)
    return made


def _row(times: "Quantiles | None") -> list[str]:
    if times is None:
        return [NONE] * len(QUANTILES)
    return [in_words(getattr(times, name)) for name in QUANTILES]


def jitter_lines(jitter: "Jitter") -> Iterator[str]:
    """What was counted, in sentences."""
    timing = jitter.timing
    yield (
        f"{timing.cycles} cycles, {timing.late} late, {timing.overrun} ended after the next was "
        f"due, {timing.skipped} skipped"
    )
    if jitter.faults is not None:
        whom = "others, cyclictest among them" if jitter.paired else "others"
        yield f"{jitter.faults} page faults, {jitter.interruptions} times interrupted by {whom}"
    yield f"granted: {jitter.granted.sentences()[0]}"


def jitter_notes(jitter: "Jitter") -> Iterator[str]:
    """What makes the numbers doubtful."""
    if jitter.no_pair:
        yield f"{jitter.no_pair}; without it nobody can tell the system's lateness from the loop's"
    yield from jitter.granted.refused
    yield from jitter.granted.disturbances
    cycle = jitter.timing.cycle
    if jitter.paired and cycle and cycle.p99 > 0.5 / jitter.settings.rate_hz:
        yield (
            f"a cycle takes up to {in_words(cycle.p99)} (p99), more than half a period: cyclictest "
            "wakes while the loop computes, which makes it later: try a lower --rate-hz too"
        )
    stolen = jitter.stolen
    if stolen is not None and stolen > 0.001:
        yield f"the host of this virtual machine kept {100 * stolen:.1f} % of a core away meanwhile"
    beyond = jitter.timing.cycles / 1000
    if beyond < 30:
        yield (
            f"p99.9 of {jitter.timing.cycles} cycles rests on the {max(round(beyond), 1)} latest: "
            "measure for a minute before you trust its ratio"
        )


def jitter_as_json(jitter: "Jitter") -> dict[str, Any]:
    """Plain numbers, times in µs."""
    settings = jitter.settings
    paired = None if jitter.paired is None else jitter.paired.as_micros()
    return {
        "seconds": settings.duration,
        "rate_hz": settings.rate_hz,
        "busy": settings.busy,
        "solver": type(settings.solver).__name__,
        "granted": jitter.granted.as_dict(),
        "loop": jitter.timing.as_dict(),
        "cyclictest_us": paired,
        "no_cyclictest": jitter.no_pair or None,
        "ratio": {name: jitter.ratio(name) for name in QUANTILES},
        "page_faults": jitter.faults,
        "interruptions": jitter.interruptions,
        "stolen_cores": jitter.stolen,
    }
