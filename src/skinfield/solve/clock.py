"""Clock of compiled searches: the one of `time.perf_counter_ns`."""

import sys
import time
from typing import Any

from numba import types

from skinfield.compiled import MODE, njit
from skinfield.errors import Ints

MONOTONIC = 1  # of Linux: what `time.perf_counter` reads there
UPTIME_RAW = 8  # of macOS, likewise

if MODE.interpreted:

    def now_ns(room: Ints) -> int:
        """Time now; `room` is not needed."""
        return time.perf_counter_ns()

elif sys.platform == "win32":
    _ticks: Any = types.ExternalFunction("QueryPerformanceCounter", types.int32(types.voidptr))
    _rate: Any = types.ExternalFunction("QueryPerformanceFrequency", types.int32(types.voidptr))

    @njit
    def now_ns(room: Ints) -> int:
        """Time now; in the first two of `room`, int64, the system writes it."""
        _ticks(room.ctypes)
        ticks = room[0]
        _rate(room.ctypes)
        whole, part = ticks // room[0], ticks % room[0]
        return int(whole * 1_000_000_000 + part * 1_000_000_000 // room[0])

elif sys.platform == "darwin":
    _uptime: Any = types.ExternalFunction("clock_gettime_nsec_np", types.int64(types.int32))

    @njit
    def now_ns(room: Ints) -> int:
        """Time now; `room` is not needed on this system."""
        return int(_uptime(UPTIME_RAW))

else:
    _gettime: Any = types.ExternalFunction("clock_gettime", types.int32(types.int32, types.voidptr))

    @njit
    def now_ns(room: Ints) -> int:
        """Time now; in the first two of `room`, int64, the system writes it."""
        _gettime(MONOTONIC, room.ctypes)
        return int(room[0] * 1_000_000_000 + room[1])
