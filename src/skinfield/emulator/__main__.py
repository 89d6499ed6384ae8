"""Virtual skin that another process has started: settings come as a line, words go back."""

import gc
import json
import os
import signal
import sys
from typing import Any

from skinfield.emulator.settings import VirtualSettings
from skinfield.emulator.skin import VirtualSkin
from skinfield.errors import SkinfieldError
from skinfield.settings import value_from_json


def main() -> int:
    """Play until the process that started this one ends, or says so.

    From stdin: one line of settings; its end means to stop. To stdout: one line when the skin is
    there, ``{"ready": true, "channels": [...], "control": "..."}`` or false with the error, and
    one at the end, ``{"counts": {...}}``.
    """
    try:
        skin = VirtualSkin(value_from_json(VirtualSettings, sys.stdin.readline()))
    except SkinfieldError as error:
        _say({"ready": False, "error": str(error)})
        return 2
    for name in (signal.SIGTERM, signal.SIGINT):
        signal.signal(name, lambda *_: skin.stop())
    _say({"ready": True, "pid": os.getpid(), **skin.description()})
    parent = os.getppid()
    gc.collect()
    gc.freeze()
    try:
        skin.run(watch=[sys.stdin.fileno()], each_second=lambda each: stop_if_alone(each, parent))
    finally:
        counts = skin.counts()
        skin.close()
        _say({"counts": counts})
    return 0


def stop_if_alone(skin: VirtualSkin, parent: int) -> None:
    """Stop once the parent is gone, even if a process that it forked keeps the pipe open."""
    if os.getppid() != parent:
        skin.stop()


def _say(what: dict[str, Any]) -> None:
    try:
        sys.stdout.write(json.dumps(what) + "\n")
        sys.stdout.flush()
    except OSError:
        os._exit(0)  # nobody is left to hear it


if __name__ == "__main__":
    os._exit(main())  # whoever started it waits: to tear Numba down takes 0.1 s
