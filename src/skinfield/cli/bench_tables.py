"""Tables of `skinfield bench`."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.table import Table

from skinfield.lab.bench.costs import INVERSION, PAPER, PAPER_REST_MS
from skinfield.lab.bench.picture import prepared_gain, written
from skinfield.plot.style import number

if TYPE_CHECKING:
    from skinfield.lab.bench.costs import Call, GridTime
    from skinfield.lab.bench.machine import Spread
    from skinfield.lab.bench.run import Bench, Point

NONE, TINY = "–", 1e-5


def tables(bench: "Bench") -> Iterator[Table]:
    """What a reading costs; error against time, of the solvers; whole calls."""
    yield _costs(bench)
    yield _anytime(bench)
    yield _calls(bench)


def _costs(bench: "Bench") -> Table:
    table = _table(
        "time per reading: mean ± standard deviation (99th percentile)",
        ("method",),
        tuple(f"{nodes} x {nodes}" for nodes in _nodes(bench.grids)),
    )
    for name in dict.fromkeys(row.name for row in bench.grids):
        rows = [row for row in bench.grids if row.name == name]
        table.add_row(name, *map(_cost, rows))
    gains = (f"{prepared_gain(bench.grids, nodes):,.0f}" for nodes in _nodes(bench.grids))
    table.add_row("paper over prepared, medians", *gains)
    rest = [_rest(bench.grids, nodes) for nodes in _nodes(bench.grids)]
    table.add_row("paper without its inversion, here", *rest)
    stated = (PAPER_REST_MS.get(nodes) for nodes in _nodes(bench.grids))
    said = (NONE if each is None else f"{each:g} ms" for each in stated)
    table.add_row("the same, as the paper states", *said)
    return table


def _nodes(grids: Sequence["GridTime"]) -> list[int]:
    return list(dict.fromkeys(row.nodes for row in grids))


def _cost(row: "GridTime") -> str:
    found = row.seconds
    text = f"{in_words(found['mean'])} ± {in_words(found['std'])} ({in_words(found['p99'])})"
    if row.certified is not None and row.certified < 1.0:
        text += f", {100 * row.certified:.0f} % certified"
    return text


def _rest(grids: Sequence["GridTime"], nodes: int) -> str:
    """Of the paper's algorithm beside the inversion, by medians."""
    times = {row.name: row.seconds["p50"] for row in grids if row.nodes == nodes}
    return in_words(max(times[PAPER] - times[INVERSION], 0.0))


def _anytime(bench: "Bench") -> Table:
    table = _table(
        f"two moving fingers, {bench.nodes} x {bench.nodes} nodes, {bench.readings} readings: "
        "error to the converged pressure and to the truth, medians",
        ("solver",),
        ("deadline", "p50", "error", "gap", "force", "place", "missed"),
    )
    for point in bench.points:
        table.add_row(*_point(point), end_section=point.deadline is None)
    return table


def _point(point: "Point") -> tuple[str, ...]:
    return (
        f"{point.solver}, {point.start}",
        NONE if point.deadline is None else in_words(point.deadline),
        _of(point.seconds, "p50"),
        _share(None if point.errors is None else point.errors["p50"]),
        NONE if point.gap is None else f"{point.gap['p50']:.0e}",
        _share(None if point.force is None else point.force["p50"]),
        NONE if point.place_median is None else f"{1e3 * point.place_median:.2f} mm",
        f"{point.missed:.2f}",
    )


def _calls(bench: "Bench") -> Table:
    table = _table(
        f"whole calls rec(readings, deadline=...), warm, {bench.nodes} x {bench.nodes} nodes",
        ("solver",),
        ("deadline", "p50", "p99", "late p99", "latency p50", "gap", "deadline met"),
    )
    for call in bench.calls:
        table.add_row(*_call(call), end_section=call.deadline is None)
    return table


def _call(call: "Call") -> tuple[str, ...]:
    return (
        call.solver,
        NONE if call.deadline is None else in_words(call.deadline),
        _of(call.seconds, "p50"),
        _of(call.seconds, "p99"),
        _of(call.late, "p99"),
        _of(call.latency, "p50"),
        NONE if call.gap is None else f"{call.gap['p50']:.0e}",
        _share(call.reported),
    )


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


def _of(found: "Spread | None", percentile: str) -> str:
    return NONE if found is None else in_words(found[percentile])


def _share(value: float | None) -> str:
    if value is None:
        return NONE
    return f"< {100 * TINY:g} %" if 0.0 < value < TINY else written(float(f"{value:.2g}"), "share")
