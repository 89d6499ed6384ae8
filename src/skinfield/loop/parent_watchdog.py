"""Parent watchdog: a process that ends when the one that started it does, however that happens."""

import contextlib
import ctypes
import os
import signal

PARENT_DIED = 1  # PR_SET_PDEATHSIG of Linux


def end_with(parent: int) -> None:
    """Have the system send SIGTERM to this process when its parent ends, where it can.

    Parameters
    ----------
    parent : int
        Process that is expected to be the parent: what it is called if it is already gone differs.

    Raises
    ------
    SystemExit
        If it is gone.
    """
    with contextlib.suppress(AttributeError, OSError):
        ctypes.CDLL(None).prctl(PARENT_DIED, signal.SIGTERM)
    if os.getppid() != parent:
        raise SystemExit("whoever started this process is gone")
