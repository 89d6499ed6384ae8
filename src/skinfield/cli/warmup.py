"""Warm-up: compiling the kernels of a first run before it, with the progress."""

import os
import threading
import time
from collections.abc import Callable
from contextlib import closing
from typing import TYPE_CHECKING

from skinfield.cli.options import Json
from skinfield.cli.report import finish, progress, say
from skinfield.errors import InputError

if TYPE_CHECKING:
    from skinfield.emulator.skin import VirtualSkin
    from skinfield.loop.engine_process import EngineProcess

RATE = 100.0  # readings per second of the virtual skin
SETTLE = 3.0  # s that the engine answers a press, and the fit beside it
PATIENCE = 900.0  # s


def warmup(*, as_json: Json = False) -> None:
    """Compile, once for this machine, what a first `skinfield run` needs.

    A virtual skin is pressed, and the engine and the fit answer, in this process. What they compile
    stays in the user's cache folder, so that the next run starts within seconds. Where all is
    compiled already this takes a few seconds.

      skinfield warmup

    Parameters
    ----------
    as_json : bool
        How many functions were compiled, as one JSON object.
    """
    with progress("compiling once for this machine, a minute or two") as step:
        count = warm_up(lambda name, number: step(number, what=f"compiling {name}"))
    if not as_json:
        say(f"compiled {count} functions" if count else "all is compiled already")
    finish(as_json, {"compiled": count})


def warm_up(progress: Callable[[str, int], None]) -> int:
    """Run a virtual skin, the engine and the fit until they have answered a press.

    Parameters
    ----------
    progress : function
        Called with each function that is compiled, and its number, from 1 on.

    Returns
    -------
    int
        How many functions were compiled; 0 if all were already.

    Raises
    ------
    InputError
        If there is no answer after 15 minutes.
    """
    from skinfield.compiled import reported
    from skinfield.emulator.settings import VirtualSettings
    from skinfield.emulator.skin import VirtualSkin

    with reported(progress) as compiled:
        skin = VirtualSkin(
            VirtualSettings(
                hardware="icub", skin="hexagon72", bus="udp", rate=RATE, noise=0.1, scene="idle"
            )
        )
        player = threading.Thread(target=skin.run, name="virtual skin", daemon=True)
        player.start()
        try:
            _answer(skin)
        finally:
            skin.stop()
            player.join()
            skin.close()
        return compiled.count


def _answer(skin: "VirtualSkin") -> None:
    """Run the engine and the fit in this process, on a press."""
    from skinfield.loop.engine_process import EngineProcess
    from skinfield.loop.fit_process import SkinFit
    from skinfield.loop.realtime import RealTime
    from skinfield.loop.settings import LiveSettings
    from skinfield.ring import RingReader
    from skinfield.signal import ICubByte
    from skinfield.wire.sources.factory import source_from_options

    name, begun = f"warmup-{os.getpid()}", time.monotonic()
    extra = {"period_ms": f"{1e3 / RATE:.0f}", "shift": "1"}
    channels = tuple(skin.description()["channels"])
    source = source_from_options("icub", "udp", channels, skin.skin, extra)
    settings = LiveSettings(
        skin=skin.skin,
        sources=(source,),
        name=name,
        board=ICubByte(shift=1),
        rate=RATE,
        real_time=RealTime(priority=0, lock_memory=False),
    )
    with closing(EngineProcess(settings)) as engine:
        while engine.updater is None:
            _step(engine)
            if time.monotonic() - begun > PATIENCE:
                raise InputError(f"no answer within {PATIENCE:.0f} s: is the machine very busy?")
        skin.play("press")
        answered = time.monotonic()
        with RingReader(name) as reader, SkinFit(name, reader) as fit:
            while time.monotonic() - answered < SETTLE:
                _step(engine)
                fit.look()


def _step(engine: "EngineProcess") -> None:
    """One cycle, when it is due."""
    engine.one(*engine.waiter.wait())
