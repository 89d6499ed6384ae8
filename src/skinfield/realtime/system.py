"""Calls of the C library that Python does not have. All are missing on other systems than Linux."""

import ctypes
import os
import sys
from pathlib import Path

MCL_CURRENT, MCL_FUTURE, MCL_ONFAULT = 1, 2, 4
PR_SET_TIMERSLACK, PR_GET_TIMERSLACK = 29, 30
M_TRIM_THRESHOLD, M_MMAP_MAX = -1, -4
LINUX = sys.platform == "linux"
LIBRARY = ctypes.CDLL(None, use_errno=True) if LINUX else None  # the C library of this process


def call(name: str, *arguments: int) -> int:
    """Result of a function of whole numbers.

    Raises
    ------
    OSError
        If it says -1, or the system does not have it.
    """
    function = getattr(LIBRARY, name, None)
    if function is None:
        raise OSError(0, f"this system has no {name}")
    found = int(function(*(ctypes.c_long(value) for value in arguments)))
    if found == -1:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
    return found


def cpus_of(text: str) -> set[int]:
    """Processors of a list such as "0-3,6"; empty for what is no such list."""
    found: set[int] = set()
    for part in filter(None, text.strip().split(",")):
        first, _, last = part.partition("-")
        if not first.isdigit() or not (last or first).isdigit():
            return set()
        found.update(range(int(first), int(last or first) + 1))
    return found


def read_text(path: str) -> str:
    """A file that the system writes; empty where there is none."""
    try:
        return Path(path).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
