"""`skinfield record`: a running skin into a file."""

import signal
import threading
import time
from pathlib import Path
from typing import Any

import click
from rich.console import Console

from skinfield.errors import InputError

COMPRESSIONS = ("zstd", "lz4", "none")


@click.command(
    short_help="Record a running skin into one MCAP file.",
    help="""Record the running skin NAME: every reading, every cycle, its timing and what happened.

The skin runs in another terminal ('skinfield run') and never waits for the recorder. The file
holds all that is needed to look at it elsewhere: layout, calibration and configuration are
enclosed. What was recorded is out of this process within 0.2 s and on the disk within 2 s. If
the disk does not keep up, what is dropped is counted, here and in the file.

Ctrl-C finishes the file. After a crash, 'skinfield recover' makes a whole file of what is left.

\b
  skinfield run                                    # in one terminal
  skinfield record -o touch.mcap --duration 60     # in another
  skinfield info touch.mcap
  skinfield replay touch.mcap
  skinfield export touch.mcap -o touch.h5
""",
)
@click.argument("name", default="skin")
@click.option(
    "-o", "--output", required=True, type=click.Path(path_type=Path), help="File, ends in .mcap."
)
@click.option("--duration", type=float, help="Seconds; default until Ctrl-C, or the skin stops.")
@click.option(
    "--compression",
    type=click.Choice(COMPRESSIONS),
    default="zstd",
    show_default=True,
    help="Of the file's chunks; noisy 16-bit counts hardly shrink.",
)
@click.option("--overwrite", is_flag=True, help="Replace a file of that name.")
@click.option("--ros", is_flag=True, help="Also channels that ROS 2 reads: taxels, forces.")
@click.option("--foxglove", is_flag=True, help="Also channels that Foxglove draws.")
@click.option(
    "--view-rate", default=20.0, show_default=True, help="Of these channels, messages a second."
)
def record(name: str, output: Path, duration: float | None, **options: Any) -> None:
    """Run the command."""
    from skinfield.live.recorder import Recorder
    from skinfield.live.recorder_state import RecorderState, forget_state

    settings = _settings(name, output, options)
    if duration is not None and not 0 < duration < 1e9:
        raise InputError(f"--duration is {duration!r}, expected seconds above 0")
    shown = Console(stderr=True)
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    before: list[RecorderState] = []

    def told(state: RecorderState) -> None:
        if shown.is_terminal:
            shown.print(_line(state, before[-1] if before else None), end="\r", highlight=False)
        before[:] = [state]

    recorder = Recorder(
        settings, lambda text: shown.print(f"{text:<100}", style="yellow"), first=True
    )
    try:
        state = recorder.run(stop, duration, told)
    finally:
        forget_state(name)
    _finish(state, shown)


def _settings(name: str, output: Path, options: dict[str, Any]) -> Any:
    from skinfield.live.recorder_settings import RecorderSettings
    from skinfield.sinks.mcap import (
        FoxgloveViews,
        Lz4,
        NoCompression,
        RecordingSettings,
        RosViews,
        Zstd,
    )

    if options["ros"] and options["foxglove"]:
        raise InputError(
            "--ros and --foxglove are both given, expected one: readers of ROS 2 bags refuse files "
            "with Foxglove's channels, and Foxglove shows those of ROS too"
        )
    if output.suffix.lower() != ".mcap":
        raise InputError(f"--output is {str(output)!r}, expected a name that ends in .mcap")
    classes: tuple[type[Zstd | Lz4 | NoCompression], ...] = (Zstd, Lz4, NoCompression)
    kinds = dict(zip(COMPRESSIONS, classes, strict=True))
    return RecorderSettings(
        name=name,
        path=output,
        since_ns=time.time_ns(),
        views=tuple(
            kind
            for kind, wanted in (
                (RosViews, options["ros"]),
                (FoxgloveViews, options["foxglove"]),
            )
            if wanted
        ),
        view_rate=options["view_rate"],
        file=RecordingSettings(kinds[options["compression"]](), overwrite=options["overwrite"]),
    )


def _line(state: Any, before: Any) -> str:
    """One line on how it is going."""
    seconds = state.seconds - (before.seconds if before else 0.0)
    cycles = (state.cycles - (before.cycles if before else 0)) / max(seconds, 1e-3)
    rate = (state.bytes_written - (before.bytes_written if before else 0)) / max(seconds, 1e-3)
    lost = f"{state.lost:,} bytes lost" if state.lost else "nothing lost"
    return (
        f"{state.seconds:7.0f} s  {state.bytes_written / 1e6:9.1f} MB  {rate / 1e6:6.2f} MB/s  "
        f"{cycles:6.0f} cycles/s  lag {state.lag * 1e3:5.0f} ms  {lost}   "
    )


def _finish(state: Any, shown: Console) -> None:
    """What came of it; an exit code that tells whether all is in the file."""
    shown.print(
        f"{state.path}: {state.seconds:.1f} s, {state.cycles:,} cycles, "
        f"{state.bytes_written / 1e6:.1f} MB; {state.ended}",
        highlight=False,
    )
    if state.overrun_cycles or state.dropped_cycles or state.lost:
        shown.print(
            f"lost: {state.lost:,} bytes of readings and "
            f"{state.overrun_cycles + state.dropped_cycles:,} cycles; the file says where",
            style="yellow",
            highlight=False,
        )
    if not state.finished:
        raise InputError(
            f"{state.path} has no end, as it could not be written ({state.failure}); make room, "
            f"then: skinfield recover {state.path} -o GOOD.mcap"
        )
