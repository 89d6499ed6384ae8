"""Tables of `skinfield bench`: what a reading costs, error against time, jitter of a live loop."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.box import SIMPLE_HEAD

from skinfield.cli.report import NONE, table
from skinfield.lab.bench.jitter import QUANTILES
from skinfield.lab.bench.run import INVERSION, PAPER, PAPER_REST_MS, Row, prepared_gain
from skinfield.loop.realtime import RealTimeStatus
from skinfield.plot import duration

if TYPE_CHECKING:
    from rich.table import Table


TINY = 1e-5
LOOK = {"box": SIMPLE_HEAD, "padding": (0, 1)}
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
    return duration(1e-6 * max(times[PAPER] - times[INVERSION], 0.0))


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
        place, until, gap = point["place_median_mm"], point["deadline_us"], point["gap"]
        made.add_row(
            f"{point['solver']}, {point['start']}",
            NONE if until is None else duration(1e-6 * until),
            _of(point["seconds_us"], "p50"),
            _share(point["errors"] and point["errors"]["p50"]),
            NONE if gap is None else f"{gap['p50']:.0e}",
            _share(point["force"] and point["force"]["p50"]),
            NONE if place is None else f"{place:.2f} mm",
            f"{point['missed']:.2f}",
            end_section=until is None,
        )
    return made


def _of(found: Mapping[str, float] | None, key: str) -> str:
    """Of a distribution of times in µs."""
    return NONE if found is None else duration(1e-6 * found[key])


def _share(value: float | None) -> str:
    if value is None:
        return NONE
    return f"< {100 * TINY:g} %" if 0.0 < value < TINY else f"{float(f'{100 * value:.2g}'):g} %"


# ---- jitter


def jitter_table(found: Mapping[str, Any]) -> "Table":
    """Times of the live loop beside those of cyclictest, as `run_jitter` has them."""
    made = table(
        f"{found['solver']}, virtual skin over UDP, {found['rate_hz']:g} cycles per second for "
        f"{found['seconds']:g} s beside {found['busy']} busy processes",
        ("time",),
        [NAMES[name] for name in QUANTILES],
    )
    made.add_row("cyclictest on the same CPU, wake", *_row(found["cyclictest_us"]))
    for name, meaning in MEANING.items():
        if found["loop"][f"{name}_us"] is not None:
            made.add_row(f"{name}: {meaning}", *_row(found["loop"][f"{name}_us"]))
    words = [NONE if each is None else f"{each:.2f}" for each in found["ratio"].values()]
    made.add_row("wake over cyclictest", *words)
    return made


def _row(times: Mapping[str, float] | None) -> list[str]:
    return [_of(times, name) for name in QUANTILES]


def jitter_lines(found: Mapping[str, Any]) -> Iterator[str]:
    """What was counted, in sentences."""
    loop = found["loop"]
    yield (
        f"{loop['cycles']} cycles, {loop['late']} late, {loop['overrun']} ended after the next was "
        f"due, {loop['skipped']} skipped"
    )
    if found["page_faults"] is not None:
        whom = "others, cyclictest among them" if found["cyclictest_us"] else "others"
        yield (
            f"{found['page_faults']} page faults, {found['interruptions']} times interrupted by "
            f"{whom}"
        )
    yield f"granted: {RealTimeStatus.from_dict(found['granted']).sentences()[0]}"


def jitter_notes(found: Mapping[str, Any]) -> Iterator[str]:
    """What makes the numbers doubtful."""
    missing, cycle, cycles = (
        found["no_cyclictest"],
        found["loop"]["cycle_us"],
        found["loop"]["cycles"],
    )
    if missing:
        yield f"{missing}; without it nobody can tell the system's lateness from the loop's"
    yield from found["granted"]["refused"]
    yield from found["granted"]["disturbances"]
    if not missing and cycle and cycle["p99"] > 0.5e6 / found["rate_hz"]:
        yield (
            f"a cycle takes up to {_of(cycle, 'p99')} (p99), more than half a period: cyclictest "
            "wakes while the loop computes, which makes it later: try a lower --rate-hz too"
        )
    stolen = found["stolen_cores"]
    if stolen is not None and stolen > 0.001:
        yield f"the host of this virtual machine kept {100 * stolen:.1f} % of a core away meanwhile"
    if cycles < 30_000:
        yield (
            f"p99.9 of {cycles} cycles rests on the {max(round(cycles / 1000), 1)} latest: "
            "measure for a minute before you trust its ratio"
        )
