"""`skinfield bench`: what a reading costs on this machine, and error against time."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any, Literal

from skinfield.cli import options, report
from skinfield.errors import InputError
from skinfield.settings import Range

if TYPE_CHECKING:
    from skinfield.skin import Skin


def bench(
    *,
    size: Literal["smoke", "short", "full"] = "short",
    seed: options.Seed = 0,
    output: Annotated[str | None, options.OUTPUT] = None,
    force: options.Force = False,
    as_json: options.Json = False,
    jitter: bool = False,
    duration: Annotated[float | None, Range(1.0, 86_400.0, "seconds")] = None,
    rate_hz: Annotated[float | None, Range(1.0, 20_000.0, "cycles per second")] = None,
    busy: Annotated[int | None, Range(0, 1024, "processes that compute")] = None,
    solver: Literal["auto", "nonnegative", "gaussian"] | None = None,
    priority: Annotated[int | None, Range(0, 98, "of SCHED_FIFO; 0 for none")] = None,
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
    output : str, optional
        Picture of cost and error against time: .png, .pdf, .svg or .jpg.
    jitter : bool
        Measure how late the live loop wakes instead.
    duration : float, s, optional
        For jitter: how long, s. Default 20.
    rate_hz : float, 1/s, optional
        For jitter: cycles per second. Default 1000.
    busy : int, optional
        For jitter: busy processes beside it. Default 2.
    solver : str, optional
        For jitter: of the engine. Default auto.
    priority : int, optional
        For jitter: of SCHED_FIFO; 0 for ordinary scheduling. Default 80.
    """
    of_jitter = {"duration": duration, "rate_hz": rate_hz, "busy": busy,
                 "solver": solver, "priority": priority}  # fmt: skip
    chosen = {name: value for name, value in of_jitter.items() if value is not None}
    if jitter:
        if output is not None:
            raise InputError("-o draws what --jitter does not measure: leave it out")
        _measure_jitter(chosen, as_json)
        return
    if chosen:
        raise InputError(f"--{options.flag_of(next(iter(chosen)))} belongs to --jitter: give both")
    report.check_picture("--output", output, force)  # before anything is measured
    from skinfield.cli.bench_tables import tables
    from skinfield.lab.bench.picture import machine_line, picture
    from skinfield.lab.bench.run import run_bench
    from skinfield.lab.bench.scene import SIZES
    from skinfield.plot import save

    with report.progress("bench", 1) as step:
        measured = run_bench(SIZES[size], seed, lambda what, done, total: step(done, total, what))
    if output is not None:
        save(picture(measured), output)
    report.say_notes(measured["warnings"])
    lines: list[report.Shown] = [machine_line(measured), *tables(measured)]
    report.finish(as_json, measured, [output], lines)


@contextmanager
def virtual_boards(
    skin: "Skin", rate: float, priority: int
) -> Iterator[tuple[Any, Callable[[str], Any]]]:
    """Virtual skin of iCub's boards, idle at first, as `run_jitter` takes it."""
    from skinfield.cli.sources import source_from_options
    from skinfield.emulator.process import start
    from skinfield.emulator.settings import VirtualSettings

    settings = VirtualSettings(rate=rate, scene="idle", lead_in=0.0, priority=priority)
    with start(settings) as boards:
        yield source_from_options("icub", "udp", tuple(boards.channels), skin), boards.scene


def _measure_jitter(chosen: dict[str, Any], as_json: bool) -> None:
    """Measure the live loop, with the settings that are not as usual, and print."""
    from skinfield.cli.bench_tables import jitter_lines, jitter_notes, jitter_table
    from skinfield.lab.bench.jitter import JitterSettings, run_jitter
    from skinfield.loop.realtime import RealTime

    if "solver" in chosen:
        chosen["solver"] = options.solver_of(chosen["solver"])
    if "priority" in chosen:
        chosen["real_time"] = RealTime(priority=chosen.pop("priority"))
    jitter = run_jitter(JitterSettings(**chosen), report.note, virtual_boards)
    report.say_notes(jitter_notes(jitter))
    lines: list[report.Shown] = [jitter_table(jitter), *jitter_lines(jitter)]
    report.finish(as_json, jitter, lines=lines)
