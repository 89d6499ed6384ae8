"""Fits contacts beside a live skin's engine: python -m skinfield.live.fit_process NAME.

It reads the ring like any other reader, at low priority, so that the engine never waits for it, and
publishes better contacts into a ring of its own.
"""

import argparse
import contextlib
import importlib
import os
import signal
import sys
import time
from typing import NoReturn

from skinfield.errors import InputError, SkinfieldError
from skinfield.live.fit import SkinFit
from skinfield.live.parent import end_with
from skinfield.ring import RingReader

NICE = 2  # behind the engine and the page, and not starved by them
STEP = 0.02  # s from one look at the skin to the next
PAUSE = 0.2  # s between looks for a skin that is not there
NEEDED = ("skinfield.inverse.atoms.fitter", "scipy.interpolate", "scipy.linalg", "scipy.ndimage")


def serve(name: str, end: float) -> None:
    """Fit what touches a skin, for as long as its ring is there, or until a monotonic time."""
    while time.monotonic() < end:
        try:
            reader = RingReader(name)
        except InputError:
            _load()
            time.sleep(PAUSE)
            continue
        with reader:
            if not reader.alive or "skinfield_live" not in reader.description:
                time.sleep(PAUSE)
                continue
            with SkinFit(name, reader) as fit:
                _follow(fit, reader, end)


def _load() -> None:
    """Import what preparing needs, as long as there is nothing to prepare for."""
    for module in NEEDED:
        importlib.import_module(module)


def _follow(fit: SkinFit, reader: RingReader, end: float) -> None:
    """Look again and again, until the ring belongs to another skin."""
    looked = time.monotonic()
    while time.monotonic() < end:
        due = time.monotonic() + STEP
        fit.look()
        now = time.monotonic()
        if now - looked > PAUSE:
            looked = now
            if reader.replaced():
                return
            fit.tell()
        time.sleep(max(due - time.monotonic(), 0.001))


def _end(*_: object) -> NoReturn:
    raise SystemExit(0)


def main() -> int:
    """Fit until told to end, or until whoever started this process is gone."""
    parser = argparse.ArgumentParser(description="Fits contacts beside a live skin's engine.")
    parser.add_argument("name", help="of the live skin")
    parser.add_argument("--parent", type=int, help="process to end with")
    parser.add_argument("--seconds", type=float, default=1e9, help="to go on for")
    given = parser.parse_args()
    signal.signal(signal.SIGTERM, _end)
    signal.signal(signal.SIGINT, _end)
    if given.parent is not None:
        end_with(given.parent)
    with contextlib.suppress(OSError):
        os.nice(NICE)
    try:
        serve(given.name, time.monotonic() + given.seconds)
    except SkinfieldError as error:
        sys.stderr.write(f"the fit of {given.name} ended: {error}\n")
        return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
