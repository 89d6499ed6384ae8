"""`skinfield bench --jitter`: how late the live loop wakes, and when its estimates are ready."""

import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import click
from rich.table import Table

from skinfield.cli.bench_tables import NONE, in_words
from skinfield.cli.report import console, say_notes

if TYPE_CHECKING:
    from skinfield.cli.jitter_run import Jitter, JitterSettings, Target
    from skinfield.realtime import Quantiles

QUANTILES = ("p50", "p99", "p999", "max")
NAMES = {"p50": "p50", "p99": "p99", "p999": "p99.9", "max": "max"}
MEANING = {
    "wake": "from due to awake",
    "acquired": "from awake until the readings are taken in",
    "ready": "from awake until the estimate is published",
    "latency": "from the newest reading until its estimate is published",
    "cycle": "from awake until all is done",
}


def jitter_settings(given: Mapping[str, object]) -> "JitterSettings":
    """Settings of what was given; the others are as usual."""
    from skinfield.cli.jitter_run import JitterSettings
    from skinfield.cli.options import SOLVERS
    from skinfield.realtime import RealTime

    more: dict[str, Any] = dict(given)
    if "solver" in more:
        more["solver"] = SOLVERS[more["solver"]]()
    if "priority" in more:
        more["real_time"] = RealTime(priority=more.pop("priority"))
    return JitterSettings(**more)


def measure_jitter(settings: "JitterSettings", as_json: bool) -> None:
    """Measure and print."""
    from skinfield.cli.jitter_run import run_jitter

    shown = console() if not as_json else None
    with shown.status("starting") if shown else _Silent() as status:
        found = run_jitter(settings, lambda text: status.update(text))
    if as_json:
        click.echo(json.dumps(jitter_as_json(found), allow_nan=False))
        return
    assert shown is not None  # only JSON goes without it
    shown.print(_table(found))
    for line in _lines(found):
        shown.print(line, highlight=False, markup=False, soft_wrap=True)
    say_notes(_notes(found))


class _Silent:
    """In place of a line that turns."""

    def __enter__(self) -> "_Silent":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def update(self, text: str) -> None:
        """Say nothing."""


def _table(found: "Jitter") -> Table:
    settings = found.settings
    table = Table(
        title=f"{_what(found)}, {settings.rate:g} cycles per second for {settings.seconds:g} s "
        f"beside {settings.busy} busy processes",
        title_justify="left",
    )
    table.add_column("time")
    for name in QUANTILES:
        table.add_column(NAMES[name], justify="right")
    table.add_row(f"cyclictest on the {settings.pair} CPU, wake", *_row(found.paired))
    for name, meaning in MEANING.items():
        if getattr(found.timing, name) is not None and (name == "wake" or _loaded(found)):
            table.add_row(f"{name}: {meaning}", *_row(getattr(found.timing, name)))
    ratios = [found.ratio(name) for name in QUANTILES]
    words = [NONE if each is None else f"{each:.2f}" for each in ratios]
    table.add_row("wake over cyclictest", *words)
    return table


def _what(found: "Jitter") -> str:
    if not _loaded(found):
        return "waking only"
    source = {"skin": "virtual skin over UDP", "engine": "readings made before"}
    return f"{type(found.settings.solver).__name__}, {source[found.settings.load]}"


def _loaded(found: "Jitter") -> bool:
    return found.settings.load != "none"


def _row(found: "Quantiles | None") -> list[str]:
    if found is None:
        return [NONE] * len(QUANTILES)
    return [in_words(getattr(found, name)) for name in QUANTILES]


def _lines(found: "Jitter") -> Iterator[str]:
    timing = found.timing
    yield (
        f"{timing.cycles} cycles, {timing.late} late, {timing.overrun} ended after the next was "
        f"due, {timing.skipped} skipped"
    )
    if found.faults is not None:
        whom = "others, cyclictest among them" if found.paired else "others"
        yield f"{found.faults} page faults, {found.interruptions} times interrupted by {whom}"
    yield f"granted: {found.granted.sentences()[0]}"
    for target in found.targets():
        yield f"target: {_target(target)}"


def _target(target: "Target") -> str:
    limit = f"{target.limit:g}" if target.unit == "" else in_words(target.limit)
    if target.value is None:
        return f"{target.name} ≤ {limit}: not measured, {target.why}"
    value = f"{target.value:.2f}" if target.unit == "" else in_words(target.value)
    return f"{target.name} ≤ {limit}: {value}, {'met' if target.met else 'missed'}"


def _notes(found: "Jitter") -> Iterator[str]:
    if found.no_pair:
        yield f"{found.no_pair}; without it nobody can tell the system's lateness from the loop's"
    yield from found.granted.refused
    yield from found.granted.disturbances
    cycle = found.timing.cycle
    if found.paired and cycle and cycle.p99 > 0.5 / found.settings.rate:
        yield (
            f"a cycle takes up to {in_words(cycle.p99)} (p99), more than half a period: cyclictest "
            "wakes while the loop computes, which makes it later; compare with --pair other"
        )
    stolen = found.company.stolen
    if stolen is not None and stolen > 0.001:
        yield f"the host of this virtual machine kept {100 * stolen:.1f} % of a core away meanwhile"
    beyond = found.timing.cycles / 1000
    if beyond < 30:
        yield (
            f"p99.9 of {found.timing.cycles} cycles rests on the {max(round(beyond), 1)} latest: "
            "measure for a minute before you trust its ratio"
        )


def jitter_as_json(found: "Jitter") -> dict[str, Any]:
    """Plain numbers, times in µs."""
    settings = found.settings
    paired = None if found.paired is None else found.paired.as_micros()
    return {
        "seconds": settings.seconds,
        "rate_hz": settings.rate,
        "busy": settings.busy,
        "load": settings.load,
        "solver": type(settings.solver).__name__,
        "pair": settings.pair,
        "granted": found.granted.as_dict(),
        "loop": found.timing.as_dict(),
        "cyclictest_us": paired,
        "no_cyclictest": found.no_pair or None,
        "ratio": {name: found.ratio(name) for name in QUANTILES},
        "targets": [
            {"name": each.name, "limit": each.limit, "value": each.value, "met": each.met}
            for each in found.targets()
        ],
        "page_faults": found.faults,
        "interruptions": found.interruptions,
        "stolen_cores": found.company.stolen,
    }
