"""The process of a recorder: begins at once, or stands ready until it is told its file."""

import argparse
import contextlib
import json
import os
import signal
import sys
import threading
from pathlib import Path

from skinfield.errors import InputError, SkinfieldError
from skinfield.live.parent import end_with
from skinfield.live.recorder import Recorder, come_first
from skinfield.live.recorder_settings import RecorderSettings
from skinfield.live.recorder_state import forget_state

READY = b"ready\n"  # told on the standard output by one that waits


class Nowhere:
    """An output for a recording that nobody wants."""

    end = 0

    def append(self, piece: bytes | bytearray | memoryview) -> None:
        """See `Output`."""
        self.end += len(piece)

    def sync(self) -> None:
        """See `Output`."""

    def close(self) -> None:
        """See `Output`."""


def order_of(path: Path, since_ns: int) -> bytes:
    """What a recorder that waits is told on its standard input.

    Parameters
    ----------
    path : Path
    since_ns : int, ns
        As of `RecorderSettings`.
    """
    return json.dumps({"path": str(path.absolute()), "since_ns": since_ns}).encode() + b"\n"


def main() -> None:
    """Record until SIGTERM or Ctrl-C."""
    given = _given()
    if given.parent is not None:
        end_with(given.parent)
    try:
        path, since_ns = given.path, given.since_ns
        if given.wait:
            if rehearse(given.name):
                come_first()  # now, as all is loaded: on a busy machine the order is read at once
            ordered = _wait()
            if ordered is None:
                return  # it is not wanted any more
            path, since_ns = ordered
        settings = RecorderSettings(name=given.name, path=path, since_ns=since_ns)
        good = _record(settings, given.seconds)
    except SkinfieldError as error:
        raise SystemExit(f"recorder: {error}") from error
    raise SystemExit(0 if good else 1)


def _given() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m skinfield.live.recorder")
    parser.add_argument("name")
    parser.add_argument("path", type=Path, nargs="?")
    parser.add_argument("--seconds", type=float)
    parser.add_argument(
        "--since-ns",
        type=int,
        default=0,
        help="Time since the epoch to begin at, if the ring goes back.",
    )
    parser.add_argument(
        "--wait", action="store_true", help="Get ready; the path comes on the standard input."
    )
    parser.add_argument("--parent", type=int, help="Process with which it ends.")
    given = parser.parse_args()
    if given.wait == (given.path is not None):
        parser.error("expected either a path or --wait")
    return given


def rehearse(name: str) -> bool:
    """Record a moment into nowhere: all that a recording needs is loaded afterwards.

    Nothing of the ring is kept, as it may be another one until a recording is wanted.

    Returns
    -------
    bool
        False if there is no such ring now: less is loaded then.
    """
    settings = RecorderSettings(name=name, path=Path(os.devnull), since_ns=1)
    try:
        recorder = Recorder(settings, output=Nowhere(), rehearsal=True)
    except SkinfieldError:  # it is being made anew
        return False
    try:
        recorder.step()
    finally:
        recorder.close()
    return True


def _wait() -> tuple[Path, int] | None:
    """Where to record, and since when; None if whoever would have said so is gone."""
    with contextlib.suppress(BrokenPipeError):  # nobody waits for that any more
        os.write(sys.stdout.fileno(), READY)
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # nothing has begun that would have to be finished
    line = sys.stdin.buffer.readline()
    return read_order(line) if line else None


def read_order(line: bytes) -> tuple[Path, int]:
    """The path and the time, ns, of `order_of`; raises InputError."""
    try:
        order = json.loads(line)
        return Path(order["path"]), int(order["since_ns"])
    except (ValueError, TypeError, KeyError) as error:
        raise InputError(f"order is {line[:80]!r}, expected JSON of path and since_ns") from error


def _record(settings: RecorderSettings, seconds: float | None) -> bool:
    """Record until told to stop; whether all that was taken is in the file, and it is whole."""
    stop = threading.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: stop.set())
    state = Recorder(settings, _say, first=True).run(stop, seconds)
    forget_state(settings.name)
    return state.finished and not state.given_up


def _say(text: str) -> None:
    with contextlib.suppress(OSError):  # the terminal is gone: the file is not
        sys.stderr.write(f"recorder: {text}\n")
        sys.stderr.flush()
