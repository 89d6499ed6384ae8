"""The processes that `skinfield run` starts, and how they end."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from skinfield.errors import InputError

BEGINS = 30.0  # s for a recorder to begin
ENDS = 15.0  # s for a recorder to finish its file
LOOK = 0.01  # s between looks whether a recorder records
# The virtual skin has a tenth of the noise of a robot's boards, 0.002 in ΔC/C₀, and its boards
# drop one bit, not two: the noise then outweighs the rounding, and averages go on getting better.
VIRTUAL_NOISE, VIRTUAL_SHIFT = 0.1, 1


def virtual_extra(rate: float) -> tuple[str, ...]:
    """What the boards of the virtual skin are told, as ``--set`` has it."""
    return f"period_ms={max(round(1e3 / rate), 1)}", f"shift={VIRTUAL_SHIFT}"


@contextmanager
def virtual_skin(given: dict[str, Any]) -> Iterator[Any]:
    """The virtual skin that is there when no hardware is."""
    from skinfield.cli.options import layer_from_options
    from skinfield.virtual.process import start
    from skinfield.virtual.settings import VirtualSettings

    settings = VirtualSettings(
        hardware="icub",
        skin=given["skin_text"],
        bus=given["bus"] or "udp",
        channels=given["channel"],
        rate=given["virtual_rate"],
        layer=layer_from_options(given["thickness_mm"], given["modulus_kpa"], given["poisson"]),
        noise=VIRTUAL_NOISE,
        scene="idle",  # until the engine has its baseline
        lead_in=0.0,
        seed=given["seed"],
    )
    with start(settings) as handle:
        yield handle


@contextmanager
def recorder(name: str, path: Path | None) -> Iterator[None]:
    """A recorder of this ring, if a file is wanted; its file is finished in the end."""
    if path is None:
        yield
        return
    with recording(name, path, start_recorder(name, str(path))):
        yield


def start_recorder(name: str, *words: str, pipe: int | None = None) -> "subprocess.Popen[bytes]":
    """A process that records this ring; it ends with the thread that calls this."""
    command = [sys.executable, "-m", "skinfield.live.recorder", name, *words]
    command += ["--parent", str(os.getpid())]
    return subprocess.Popen(command, process_group=0, stdin=pipe, stdout=pipe)


@contextmanager
def recording(name: str, path: Path, child: "subprocess.Popen[bytes]") -> Iterator[None]:
    """What a process records, from when it does; its file is finished in the end."""
    try:
        wait_for_recorder(name, child)
        yield
    finally:
        if child.poll() is None:
            child.terminate()
        try:
            code = child.wait(ENDS)
        except subprocess.TimeoutExpired:
            child.kill()
            code = child.wait()
        unbegun = code == -signal.SIGTERM and not path.exists()  # told to end before it began
        if code and not unbegun:
            raise InputError(
                f"the recorder ended with status {code}: see what it said; "
                f"`skinfield recover {path} -o GOOD.mcap` saves what is in the file"
            )


def wait_for_recorder(name: str, child: "subprocess.Popen[bytes]") -> None:
    """Wait until a recorder records, so that nothing of the skin's life is missing.

    Raises
    ------
    InputError
        If it ends, or does not begin in time.
    """
    from skinfield.live.recorder_state import read_state

    end = time.monotonic() + BEGINS
    while time.monotonic() < end:
        state = read_state(name)
        if state is not None and state.pid == child.pid:
            return
        if child.poll() is not None:
            raise InputError(f"the recorder ended with status {child.returncode}: see what it said")
        time.sleep(LOOK)
    raise InputError(f"the recorder did not begin within {BEGINS:g} s: is the machine very busy?")
