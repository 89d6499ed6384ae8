"""Tables of `skinfield bench`."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from skinfield.lab.bench.picture import written
from skinfield.lab.bench.run import INVERSION, PAPER, PAPER_REST_MS, Row, prepared_gain
from skinfield.plot.style import number

NONE, TINY = "–", 1e-5


def tables(bench: Mapping[str, Any]) -> Iterator[Table]:
    """What a reading costs; error against time, of the solvers; whole calls."""
    yield _costs(bench["grids"])
    yield _anytime(bench)
    yield _calls(bench)


def _costs(grids: Sequence[Row]) -> Table:
    nodes = list(dict.fromkeys(row["nodes"] for row in grids))
    table = _table(
        "time per reading: mean ± standard deviation (99th percentile)",
        ("method",),
        tuple(f"{each} x {each}" for each in nodes),
    )
    for name in dict.fromkeys(row["name"] for row in grids):
        table.add_row(name, *(_cost(row) for row in grids if row["name"] == name))
    gains = (f"{prepared_gain(grids, each):,.0f}" for each in nodes)
    table.add_row("paper over prepared, medians", *gains)
    table.add_row("paper without its inversion, here", *(_rest(grids, each) for each in nodes))
    stated = (PAPER_REST_MS.get(each) for each in nodes)
    said = (NONE if each is None else f"{each:g} ms" for each in stated)
    table.add_row("the same, as the paper states", *said)
    return table


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


def _anytime(bench: Mapping[str, Any]) -> Table:
    nodes = bench["nodes"]
    table = _table(
        f"two moving fingers, {nodes} x {nodes} nodes, {bench['readings']} readings: "
        "error to the converged pressure and to the truth, medians",
        ("solver",),
        ("deadline", "p50", "error", "gap", "force", "place", "missed"),
    )
    for point in bench["points"]:
        place = point["place_median_mm"]
        table.add_row(
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
    return table


def _calls(bench: Mapping[str, Any]) -> Table:
    nodes = bench["nodes"]
    table = _table(
        f"whole calls rec(readings, deadline=...), warm, {nodes} x {nodes} nodes",
        ("solver",),
        ("deadline", "p50", "p99", "late p99", "latency p50", "gap", "deadline met"),
    )
    for call in bench["calls"]:
        table.add_row(
            call["solver"],
            _deadline(call),
            _of(call["seconds_us"], "p50"),
            _of(call["seconds_us"], "p99"),
            _of(call["late_us"], "p99"),
            _of(call["latency_us"], "p50"),
            _gap(call),
            _share(call["reported"]),
            end_section=call["deadline_us"] is None,
        )
    return table


def _deadline(row: Row) -> str:
    return NONE if row["deadline_us"] is None else in_words(1e-6 * row["deadline_us"])


def _gap(row: Row) -> str:
    return NONE if row["gap"] is None else f"{row['gap']['p50']:.0e}"


def _table(title: str, words: Sequence[str], *numbers: Sequence[str]) -> Table:
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1))
    for column in words:
        table.add_column(column, no_wrap=True)
    for column in (each for part in numbers for each in part):
        table.add_column(column, justify="right", no_wrap=True)
    return table


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
    return f"< {100 * TINY:g} %" if 0.0 < value < TINY else written(float(f"{value:.2g}"), "share")
