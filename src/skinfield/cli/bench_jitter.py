"""`skinfield bench --jitter`: how late the live loop wakes, and when its estimates are ready."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from rich.table import Table

from skinfield.cli.bench_tables import NONE, in_words
from skinfield.cli.report import console, print_json, say_notes
from skinfield.errors import check_count

if TYPE_CHECKING:
    from skinfield.cli.jitter import Jitter, JitterSettings
    from skinfield.loop.realtime import Quantiles

QUANTILES = ("p50", "p99", "p999", "max")
NAMES = {"p50": "p50", "p99": "p99", "p999": "p99.9", "max": "max"}
MEANING = {
    "wake": "from due to awake",
    "acquired": "from awake until the readings are taken in",
    "ready": "from awake until the estimate is published",
    "latency": "from the newest reading until its estimate is published",
    "cycle": "from awake until all is done",
}


def jitter_settings(options: Mapping[str, object]) -> "JitterSettings":
    """Settings from options of the command line; the others are as usual."""
    from skinfield.cli.jitter import JitterSettings
    from skinfield.cli.options import solver_of
    from skinfield.loop.realtime import RealTime

    more: dict[str, Any] = dict(options)
    if "solver" in more:
        more["solver"] = solver_of(more["solver"])
    if "priority" in more:
        check_count("--priority", more["priority"], 0, 98, "of SCHED_FIFO; 0 for none")
        more["real_time"] = RealTime(priority=more.pop("priority"))
    return JitterSettings(**more)


def measure_jitter(settings: "JitterSettings", as_json: bool) -> None:
    """Measure and print."""
    from skinfield.cli.jitter import run_jitter

    shown = console() if not as_json else None
    with shown.status("starting") if shown else _Silent() as status:
        jitter = run_jitter(settings, lambda text: status.update(text))
    if as_json:
        print_json(jitter_as_json(jitter))
        return
    assert shown is not None  # only JSON goes without it
    shown.print(_table(jitter))
    for line in _lines(jitter):
        shown.print(line, highlight=False, markup=False, soft_wrap=True)
    say_notes(_notes(jitter))


class _Silent:
    """In place of a line that turns."""

    def __enter__(self) -> "_Silent":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def update(self, text: str) -> None:
        """Say nothing."""


def _table(jitter: "Jitter") -> Table:
    settings = jitter.settings
    table = Table(
        title=f"{_what(jitter)}, {settings.rate_hz:g} cycles per second for "
        f"{settings.duration:g} s beside {settings.busy} busy processes",
        title_justify="left",
    )
    table.add_column("time")
    for name in QUANTILES:
        table.add_column(NAMES[name], justify="right")
    table.add_row("cyclictest on the same CPU, wake", *_row(jitter.paired))
    for name, meaning in MEANING.items():
        if getattr(jitter.timing, name) is not None and (name == "wake" or _loaded(jitter)):
            table.add_row(f"{name}: {meaning}", *_row(getattr(jitter.timing, name)))
    ratios = [jitter.ratio(name) for name in QUANTILES]
    words = [NONE if each is None else f"{each:.2f}" for each in ratios]
    table.add_row("wake over cyclictest", *words)
    return table


def _what(jitter: "Jitter") -> str:
    if not _loaded(jitter):
        return "waking only"
    return f"{type(jitter.settings.solver).__name__}, virtual skin over UDP"


def _loaded(jitter: "Jitter") -> bool:
    return jitter.settings.load != "none"


def _row(jitter: "Quantiles | None") -> list[str]:
    if jitter is None:
        return [NONE] * len(QUANTILES)
    return [in_words(getattr(jitter, name)) for name in QUANTILES]


def _lines(jitter: "Jitter") -> Iterator[str]:
    timing = jitter.timing
    yield (
        f"{timing.cycles} cycles, {timing.late} late, {timing.overrun} ended after the next was "
        f"due, {timing.skipped} skipped"
    )
    if jitter.faults is not None:
        whom = "others, cyclictest among them" if jitter.paired else "others"
        yield f"{jitter.faults} page faults, {jitter.interruptions} times interrupted by {whom}"
    yield f"granted: {jitter.granted.sentences()[0]}"


def _notes(jitter: "Jitter") -> Iterator[str]:
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
    stolen = jitter.company.stolen
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
        "load": settings.load,
        "solver": type(settings.solver).__name__,
        "granted": jitter.granted.as_dict(),
        "loop": jitter.timing.as_dict(),
        "cyclictest_us": paired,
        "no_cyclictest": jitter.no_pair or None,
        "ratio": {name: jitter.ratio(name) for name in QUANTILES},
        "page_faults": jitter.faults,
        "interruptions": jitter.interruptions,
        "stolen_cores": jitter.company.stolen,
    }
