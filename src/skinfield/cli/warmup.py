"""Warm-up: compiling the kernels of a first run before it, with the progress."""

import os
import time
from contextlib import ExitStack

from rich.console import Console

from skinfield.cli.options import Json
from skinfield.cli.report import end_undisturbed, finish, say, signals_end
from skinfield.cli.run import start_all, watch
from skinfield.settings import LoopSettings, PageSettings, Settings

SETTLE = 3.0  # s that the engine answers a press, and the fit beside it


def warmup(*, as_json: Json = False) -> None:
    """Compile, once for this machine, what a first `skinfield run` needs.

    It is such a run, of a virtual skin that is pressed, until engine and fit have answered. What
    they compile stays in the user's cache folder, so that the next run starts within seconds. Where
    all is compiled already this takes a few seconds.

      skinfield warmup

    Parameters
    ----------
    as_json : bool
        How long it took, as one JSON object.
    """
    loop = LoopSettings(name=f"warmup-{os.getpid()}", priority=0)
    wanted, console = Settings(loop=loop, page=PageSettings(port=0)), Console(stderr=True)
    began = time.monotonic()
    with signals_end(), ExitStack() as parts:
        try:
            summary = watch(start_all(wanted, parts, console), SETTLE, None, console)
        finally:
            end_undisturbed()
    seconds = time.monotonic() - began
    if not as_json:
        say(f"a run starts and answers: {summary['cycles']:,} cycles, {seconds:.0f} s in all")
    finish(as_json, {"seconds": seconds, "cycles": summary["cycles"]})
