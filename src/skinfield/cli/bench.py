"""`skinfield bench`: what a reading costs on this machine, and error against time."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any, Literal

from skinfield.cli.options import OUTPUT, Force, Json, flag_of, solver_of
from skinfield.cli.report import (
    check_picture,
    console,
    finish,
    note,
    progress,
    say,
    say_notes,
)
from skinfield.errors import InputError, check_count

if TYPE_CHECKING:
    from skinfield.skin import Skin


def bench(
    *,
    size: Literal["smoke", "short", "full"] = "short",
    seed: int = 0,
    output: Annotated[str | None, OUTPUT] = None,
    force: Force = False,
    as_json: Json = False,
    jitter: bool = False,
    duration: float | None = None,
    rate_hz: float | None = None,
    busy: int | None = None,
    solver: Literal["nonnegative", "gaussian"] | None = None,
    priority: int | None = None,
) -> None:
    """Measure on this machine what a reading costs, and error against time.

    The paper's algorithm with all its work for each reading, as in its Figure 9, the operator that
    is prepared once, the non-negative field to a certified gap, and the contact fit. Then the
    any-time curve: two simulated fingers move over the patch, and each solver answers within
    deadlines from 20 µs to 50 ms; how far is it from its converged answer, and from the truth?

    Prints tables, or the numbers with --json, and draws cost and error against time with -o. It
    takes seconds (smoke), some two to three minutes (short) or about half an hour (full), on one
    core. Let nothing else run meanwhile; what ran anyway is reported.

    With --jitter it measures the live loop instead: how late the engine's process wakes, and when
    its estimates are ready, on the paper's hexagon with 40 x 40 nodes, while a virtual skin sends
    what iCub boards would and other processes keep all processors busy. Where cyclictest of
    rt-tests is installed, it runs in the same seconds on the same processor, half a period apart
    and one step higher in priority, so that neither waits for the other; it does nothing but sleep,
    and how late it wakes is the system's doing. The ratio is the loop's own.

      skinfield bench
      skinfield bench --size full -o bench.png
      skinfield bench --size smoke --json > bench.json
      skinfield bench --jitter
      skinfield bench --jitter --duration 60 --rate-hz 1000 --busy 2 --json

    Parameters
    ----------
    size : str
        How much is measured.
    seed : int
        Of noise and order.
    output : str, optional
        Picture of cost and error against time: .png, .pdf, .svg or .jpg.
    as_json : bool
        Print the numbers as JSON, not as tables.
    jitter : bool
        Measure how late the live loop wakes instead.
    duration : float, s, optional
        For jitter: how long, s. Default 20.
    rate_hz : float, 1/s, optional
        For jitter: cycles per second. Default 1000.
    busy : int, optional
        For jitter: busy processes beside it. Default 2.
    solver : str, optional
        For jitter: of the engine. Default nonnegative.
    priority : int, optional
        For jitter: of SCHED_FIFO; 0 for ordinary scheduling. Default 80.
    """
    check_count("--seed", seed, 0, 1 << 63, "of noise and order")
    of_jitter = {"duration": duration, "rate_hz": rate_hz, "busy": busy,
                 "solver": solver, "priority": priority}  # fmt: skip
    options = {name: value for name, value in of_jitter.items() if value is not None}
    if jitter:
        if output is not None:
            raise InputError("-o draws what --jitter does not measure: leave it out")
        _measure_jitter(options, as_json)
        return
    if options:
        raise InputError(f"--{flag_of(next(iter(options)))} belongs to --jitter: give both")
    check_picture("--output", output, force)  # before anything is measured
    from skinfield.cli.bench_tables import tables
    from skinfield.lab.bench.picture import machine_line, picture
    from skinfield.lab.bench.run import run_bench
    from skinfield.lab.bench.scene import BenchSettings, bench_size
    from skinfield.plot import save

    with progress("bench", 1) as step:
        measured = run_bench(
            BenchSettings(size=bench_size(size), seed=seed),
            lambda what, done, total: step(done, total, what),
        )
    if output is not None:
        save(picture(measured), output)
    say_notes(measured["warnings"])
    if not as_json:
        say(machine_line(measured))
        for each in tables(measured):
            console().print(each)
    finish(as_json, measured, [output])


@contextmanager
def virtual_boards(
    skin: "Skin", rate: float, priority: int
) -> Iterator[tuple[Any, Callable[[str], Any]]]:
    """Virtual skin of iCub's boards, idle at first, as `run_jitter` takes it."""
    from skinfield.emulator.process import start
    from skinfield.emulator.settings import VirtualSettings
    from skinfield.wire.sources.factory import source_from_options

    settings = VirtualSettings(rate=rate, scene="idle", lead_in=0.0, priority=priority)
    with start(settings) as boards:
        yield source_from_options("icub", "udp", tuple(boards.channels), skin), boards.scene


def _measure_jitter(options: dict[str, Any], as_json: bool) -> None:
    """Measure the live loop, with the settings that are not as usual, and print."""
    from skinfield.cli.bench_tables import jitter_as_json, jitter_lines, jitter_notes, jitter_table
    from skinfield.lab.bench.jitter import JitterSettings, run_jitter
    from skinfield.loop.realtime import RealTime

    if "solver" in options:
        options["solver"] = solver_of(options["solver"])
    if "priority" in options:
        check_count("--priority", options["priority"], 0, 98, "of SCHED_FIFO; 0 for none")
        options["real_time"] = RealTime(priority=options.pop("priority"))
    jitter = run_jitter(JitterSettings(**options), note, virtual_boards)
    if not as_json:
        console().print(jitter_table(jitter))
        for line in jitter_lines(jitter):
            say(line)
        say_notes(jitter_notes(jitter))
    finish(as_json, jitter_as_json(jitter))
