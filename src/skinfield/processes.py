"""Processes of skinfield's own modules, started without loading what they load."""

import os
import subprocess
import sys
from typing import IO

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
Child = subprocess.Popen[bytes]


def processors() -> int:
    """Number of those that this process may use."""
    allowed = getattr(os, "sched_getaffinity", lambda _: range(os.cpu_count() or 1))  # not on macOS
    return len(allowed(0))


def start_python(
    module: str,
    *words: str,
    stdin: int = subprocess.DEVNULL,
    stdout: int = subprocess.DEVNULL,
    stderr: IO[bytes] | None = None,
) -> Child:
    """Start a module of skinfield in a process of its own, with this one's path and one thread."""
    return subprocess.Popen(
        [sys.executable, "-X", "faulthandler", "-m", module, *words],
        stdin=stdin,
        stdout=stdout,
        stderr=stderr,
        process_group=0,  # a terminal's Ctrl-C is meant for whoever started it, and ends it
        env=os.environ | ONE_THREAD | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )
