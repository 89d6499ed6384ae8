"""`skinfield record`, `recover` and `info`: a running skin into a file, and what the file holds."""

import signal
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any

from rich.console import Console

from skinfield.cli import options, report
from skinfield.cli.report import Column
from skinfield.errors import InputError
from skinfield.plot import plural
from skinfield.settings import Range

MOST_EVENTS = 12
PATCH = (
    Column("patch", "name"), Column("taxels", "taxels", decimals=0),
    Column("readings", "readings", decimals=0), Column("per second", "rate", decimals=1),
)  # fmt: skip


def record(
    name: str = "skin",
    /,
    *,
    output: Annotated[str, options.OUTPUT],
    duration: options.Duration = None,
    view_rate_hz: Annotated[float, Range(0.0, 1e3, "messages a second")] = 20.0,
    force: options.Force = False,
    as_json: options.Json = False,
) -> None:
    """Record the running skin NAME: every reading, every cycle, its timing and what happened.

    The skin runs in another terminal ('skinfield run') and never waits for the recorder. The file
    holds all that is needed to look at it elsewhere: layout, calibration and configuration are
    enclosed. What was recorded is out of this process within 0.2 s and on the disk within 2 s. If
    the disk does not keep up, what is dropped is counted, here and in the file.

    Ctrl-C finishes the file. After a crash, 'skinfield recover' makes a whole file of what is left;
    'skinfield info' says what a file holds.

      skinfield run                                    # in one terminal
      skinfield record -o touch.mcap --duration 60     # in another
      skinfield info touch.mcap
      skinfield replay touch.mcap
      skinfield export touch.mcap -o touch.parquet

    Parameters
    ----------
    name : str
        Of the running skin.
    output : str
        File to write (.mcap).
    view_rate_hz : float, 1/s
        Of what all taxels read and the pressure, messages a second.
    """
    from skinfield.loop.process_supervisor import stop_on
    from skinfield.record.recorder import Recorder, RecorderState, forget_state

    report.check_output("--output", output, force, ".mcap")
    since_ns = time.time_ns()
    out = Console(stderr=True)
    stop = stop_on(signal.SIGINT, signal.SIGTERM)
    before = [RecorderState()]

    def on_state(state: RecorderState) -> None:
        if out.is_terminal:
            out.print(_line(state, before[-1]), end="\r", highlight=False)
        before[:] = [state]

    recorder = Recorder(
        name,
        Path(output),
        lambda text: report.note(f"{text:<100}", "yellow", out),
        since_ns=since_ns,
        view_rate=view_rate_hz,
        overwrite=force,
        first=True,
    )
    try:
        state = recorder.run(stop, duration, on_state)
    finally:
        forget_state(name)
    lost_cycles = state.overrun_cycles + state.dropped_cycles
    result = {
        "file": str(state.path),
        "seconds": state.seconds,
        "cycles": state.cycles,
        "bytes": state.bytes_written,
        "lost_bytes": state.lost,
        "lost_cycles": lost_cycles,
        "finished": state.finished,
    }
    report.finish(as_json, result)
    _report(state, lost_cycles)


def _line(state: Any, before: Any) -> str:
    """One line on how it is going."""
    seconds = max(state.seconds - before.seconds, 1e-3)
    cycles = (state.cycles - before.cycles) / seconds
    rate = (state.bytes_written - before.bytes_written) / seconds
    lost = f"{state.lost:,} bytes lost" if state.lost else "nothing lost"
    return (
        f"{state.seconds:7.0f} s  {state.bytes_written / 1e6:9.1f} MB  {rate / 1e6:6.2f} MB/s  "
        f"{cycles:6.0f} cycles/s  lag {state.lag * 1e3:5.0f} ms  {lost}   "
    )


def _report(state: Any, cycles: int) -> None:
    """What came of it; an error if not all is in the file."""
    report.note(
        f"{state.path}: {state.seconds:.1f} s, {state.cycles:,} cycles, "
        f"{state.bytes_written / 1e6:.1f} MB; {state.ended}",
        "",
    )
    if cycles or state.lost:
        text = f"lost: {state.lost:,} bytes of readings and {cycles:,} cycles; the file says where"
        report.note(text, "yellow")
    if not state.finished:
        raise InputError(
            f"{state.path} has no end, as it could not be written ({state.failure}); make room, "
            f"then: skinfield recover {state.path} -o GOOD.mcap"
        )


def recover(
    bad: str,
    /,
    *,
    output: Annotated[str, options.OUTPUT],
    force: options.Force = False,
    as_json: options.Json = False,
) -> None:
    """Write what can be read of BAD into a new, whole file; BAD stays as it is.

    A recorder that was killed, a battery that ran out, or a full disk leave a file without its end:
    most programs refuse it. Everything up to the last flush, 0.2 s before, is in it. What is whole
    is written; what is damaged is left out and named by its byte in the file.

      skinfield recover crashed.mcap -o good.mcap

    Parameters
    ----------
    bad : str
        Damaged recording.
    output : str
        File to write (.mcap).
    """
    from skinfield.record.recover import recover as save

    report.check_output("--output", output, force)
    with report.progress("recovering") as step:
        result = save(Path(bad), Path(output), overwrite=force, progress=step)
    plain = {
        "file": output,
        "was_whole": result.was_whole,
        "messages": dict(result.messages),
        "dropped_bytes": result.dropped_bytes,
        "damage": [{"byte": each.byte, "why": each.why} for each in result.damage],
    }
    report.finish(as_json, plain, lines=_recovered_lines(result, bad, output))


def _recovered_lines(result: Any, bad: str, output: str) -> Iterator[report.Shown]:
    if result.was_whole:
        yield f"{bad} is whole: nothing was wrong with it; {output} is a copy"
    counts = ", ".join(f"{count} on {topic}" for topic, count in sorted(result.messages.items()))
    seconds = (result.last_ns - result.first_ns) * 1e-9
    saved = f"saved {plural(result.messages.total(), 'message')} of {seconds:.3f} s"
    yield f"{saved}: {counts}" if counts else saved
    if not result.was_whole and not result.dropped_bytes and not result.damage:
        yield f"{bad} had no end; nothing had to be left out"
    if result.dropped_bytes:
        what = ", the beginning of a chunk that was never finished" if result.chunk_was_cut else ""
        yield f"dropped {result.dropped_bytes} of {result.size} bytes at the end{what}"
    yield from (f"byte {damage.byte}: {damage.why}" for damage in result.damage)


def info(file: options.McapFile, /, *, as_json: options.Json = False) -> None:
    """Say what FILE holds, a recording that 'skinfield record' or 'run --record' made.

    Which skin, how long, how many readings and cycles, how late, what was lost and why, how many
    contacts, what happened, and how large its parts are. A file that was not finished is read as
    far as it goes.

      skinfield info touch.mcap
      skinfield info touch.mcap --json | jq .lost
    """
    from skinfield.files.mcap.live import LiveRecording
    from skinfield.files.mcap.summary import summary_of

    with report.progress("reading") as step:
        summary = summary_of(LiveRecording.open(Path(file)), step)
    report.finish(as_json, summary, lines=_info_lines(summary))


def _info_lines(summary: dict[str, Any]) -> Iterator[report.Shown]:
    yield from (f"{name:<16}{text}" for name, text in _lines(summary))
    if summary["patches"]:
        yield report.table_of(None, summary["patches"], PATCH)
    for event in summary["last_events"][-MOST_EVENTS:]:
        when = (event.get("wall_ns", 0) - (summary["began_ns"] or 0)) * 1e-9
        yield f"{when:10.3f} s  {event.get('text')}"
    for damage in summary["damage"][:MOST_EVENTS]:
        yield f"byte {damage['byte']}: {damage['why']}"


def _lines(summary: dict[str, Any]) -> list[tuple[str, str]]:
    when = "never"
    if summary["began_ns"]:
        began = datetime.fromtimestamp(summary["began_ns"] * 1e-9, UTC)
        when = began.strftime("%Y-%m-%d %H:%M:%S UTC")
    lost, contacts = summary["lost"], summary["contacts"]
    fields = summary["fields"]
    rate = "?" if summary["cycle_rate"] is None else f"{summary['cycle_rate']:,.1f}"
    whole = "" if summary["finished"] else "; not finished: skinfield recover makes a whole file"
    enclosed = ", ".join(
        f"{name} ({size:,} bytes)" for name, size in summary["attachments"].items()
    )
    return [
        ("file", f"{summary['path']}, {summary['bytes'] / 1e6:.1f} MB{whole}"),
        ("recorded", f"{when}, {summary['seconds']:.3f} s"),
        ("skin", f"{summary['skin'] or 'layout not enclosed'}, {summary['taxels'] or '?'} taxels"),
        ("readings", f"{summary['readings']['bytes'] / 1e6:.1f} MB of blocks, "
                     f"{summary['readings']['missing_bytes']:,} bytes missing in between"),
        ("cycles", f"{summary['cycles']:,} ({rate}/s), "
                   f"{summary['cycles_missing']:,} missing, {summary['late']:,} late, "
                   f"{summary['restarts']} restarts"),
        ("woke late by", _quantiles(summary["wake_us"])),
        ("answered after", _quantiles(summary["ready_us"])),
        ("contacts", f"{contacts['tracks']:,} tracks in {contacts['cycles']:,} cycles, at most "
                     f"{contacts['most_at_once']} at once"),
        ("fields", f"{fields['messages']:,}, {fields['bytes'] / 1e6:.2f} MB"),
        ("settings", f"{len(summary['settings'])} times told"),
        ("lost", f"{lost['messages']:,} messages before the host; in the ring "
                 f"{lost['overrun_bytes']:,} bytes, {lost['overrun_cycles']:,} cycles; for the "
                 f"disk {lost['dropped_bytes']:,} bytes, {lost['dropped_cycles']:,} cycles"),
        ("enclosed", enclosed or "nothing"),
    ]  # fmt: skip


def _quantiles(micros: dict[str, float] | None) -> str:
    if micros is None:
        return "not known"
    return ", ".join(f"{name} {value:,.0f} µs" for name, value in micros.items())
