"""Calls of the C library that Python does not have. All are missing on other systems than Linux."""

import ctypes
import os
import sys
from functools import cache

MCL_CURRENT, MCL_FUTURE = 1, 2
PR_SET_TIMERSLACK, PR_GET_TIMERSLACK = 29, 30
M_TRIM_THRESHOLD, M_MMAP_MAX = -1, -4
LINUX = sys.platform == "linux"


@cache
def library() -> ctypes.CDLL | None:
    """The C library of this process, on Linux."""
    return ctypes.CDLL(None, use_errno=True) if LINUX else None


def call(name: str, *arguments: int) -> int:
    """Result of a function of whole numbers.

    Raises
    ------
    OSError
        If it says -1, or the system does not have it.
    """
    function = getattr(library(), name, None)
    if function is None:
        raise OSError(0, f"this system has no {name}")
    found = int(function(*(ctypes.c_long(value) for value in arguments)))
    if found == -1:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
    return found
