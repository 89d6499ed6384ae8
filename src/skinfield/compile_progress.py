"""Progress of compilation: the share that is done, and the seconds that are left.

What there is to compile is known beforehand: `compile_times.json` has the seconds of each function
by the outermost one that it is part of, which is what the cache holds, and the outermost ones of
each use. `benchmarks/compile_times.py` measures them. How much faster or slower this machine is
shows as it goes on; how busy it is, at once.
"""

import json
import math
import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, Literal, NamedTuple

from numba.core.event import Listener, install_listener

from skinfield.compiled import PACKAGE, is_cached

Use = Literal["reconstruct", "heavy", "linear", "run"]
FILE = Path(__file__).with_name("compile_times.json")
TRUST = 5.0  # s of known times, after which a machine's own pace counts for half
CLIMB = 0.25  # s by which what is left may grow in a second
LOOKS = 0.5  # s from look to look what other processes have compiled


class Known(NamedTuple):
    """Known times.

    Attributes
    ----------
    seconds : dict of str to dict of str to float, s
        By outermost function and function; "" stands for all that are short.
    uses : dict of str to list of str
        Outermost functions that each use takes, in the order in which they are compiled.
    """

    seconds: dict[str, dict[str, float]]
    uses: dict[str, list[str]]


@cache
def known_times() -> Known:
    """Those that this package was measured with."""
    return Known(**json.loads(FILE.read_text()))


def is_compiled(outermost: str) -> bool:
    """Whether the cache holds `skinfield.solve.tiles_kernel.apply_tiles`, for example."""
    module, _, name = outermost.rpartition(".")
    file = PACKAGE.joinpath(*module.split(".")[1:]).with_suffix(".py")
    return file.is_file() and is_cached(file, name)


def crowding() -> float:
    """Programs, with this one, that want each processor; at least 1."""
    if not hasattr(os, "getloadavg"):  # on Windows
        return 1.0
    return max((os.getloadavg()[0] + 1.0) / (os.cpu_count() or 1), 1.0)


def _spread(seconds: dict[str, float]) -> dict[str, float]:
    """Seconds of functions with those of the short ones among them, which end in between."""
    short = seconds.get("", 0.0)
    rest = sum(seconds.values()) - short
    if not rest:
        return dict(seconds)
    return {name: its * (1.0 + short / rest) for name, its in seconds.items() if name}


class CompileProgress(Listener):
    """Estimate of how far the compilation for a use is; each of its methods may be called anywhere.

    Parameters
    ----------
    use : {"reconstruct", "heavy", "linear", "run"}
        A `Reconstructor` with the usual solver, the same after `interpret`, a live skin that
        answers linearly, or by the usual solver.
    compiled : function of a name, optional
        Whether the cache holds an outermost function.
    clock : function, optional
        Time, s.
    crowd : function, optional
        Programs that want each processor, at least 1: so many times longer it takes.

    Attributes
    ----------
    count : int
        Functions that were begun so far.
    """

    def __init__(
        self,
        use: Use,
        compiled: Callable[[str], bool] = is_compiled,
        clock: Callable[[], float] = time.monotonic,
        crowd: Callable[[], float] = crowding,
    ) -> None:
        known = known_times()
        self._compiled, self._clock, self._crowd = compiled, clock, crowd()
        names = [name for name in known.uses[use] if not compiled(name)]
        self._left = {name: _spread(known.seconds[name]) for name in names}
        self._total = sum(sum(each.values()) for each in self._left.values())
        self._lock = threading.Lock()
        self._threads: dict[int, list[str]] = {}
        self._began = self._event = self._looked = clock()
        self._done, self._said = 0.0, (self._began, math.inf)
        self.count = 0

    def on_start(self, event: Any) -> None:
        """A function is about to be compiled: the cache does not hold it."""
        function = event.data["dispatcher"].py_func
        with self._lock:
            if not self.count:
                self._began = self._clock()
            self.count += 1
            self._event = self._clock()
            stack = self._threads.setdefault(threading.get_ident(), [])
            stack.append(f"{function.__module__}.{function.__qualname__}")

    def on_end(self, event: Any) -> None:
        """It is compiled."""
        with self._lock:
            self._event = self._clock()
            stack = self._threads.get(threading.get_ident())
            if not stack:  # it was begun before this listens
                return
            name = stack.pop()
            if stack:
                self._left.get(stack[0], {}).pop(name, None)
            else:
                self._left.pop(name, None)

    @property
    def is_going_on(self) -> bool:
        """Whether a function is being compiled by this process."""
        return any(self._threads.values())

    @property
    def share(self) -> float:
        """Share of the work, 0 to 1; it never falls."""
        return self._estimate()[0]

    @property
    def seconds_left(self) -> float:
        """At the pace so far, s; it grows slowly, if at all."""
        return self._estimate()[1]

    def _estimate(self) -> tuple[float, float]:
        with self._lock:
            now = self._clock()
            if now > self._looked + LOOKS:
                self._looked = now
                for name in [name for name in self._left if self._compiled(name)]:
                    self._left.pop(name)
            left = sum(sum(each.values()) for each in self._left.values())
            spent = self._total - left
            taken = now - self._began if self.count else 0.0
            pace = (self._crowd * TRUST + taken) / (TRUST + spent)
            left -= min((now - self._event) / pace, self._at_most()) if self.is_going_on else 0.0
            share = 1.0 - left / self._total if self._total else 1.0
            self._done = max(self._done, min(max(share, 0.0), 1.0))
            before, seconds = self._said
            most = seconds + CLIMB * (now - before)
            self._said = now, min(max(pace * self._total * (1.0 - self._done), 0.0), most)
            return self._done, self._said[1]

    def _at_most(self) -> float:
        """Seconds that what is being compiled now takes at the most."""
        total = 0.0
        for stack in self._threads.values():
            if stack and (its := self._left.get(stack[0])) is not None:
                name = stack[-1]
                total += its.get(name, 0.0)
        return total


def words(seconds_left: float) -> str:
    """What people read while it lasts; without the seconds where nothing known is left."""
    text = "compiling once for this machine"
    return f"{text}, {max(seconds_left, 1.0):.0f} s left" if seconds_left else text


@contextmanager
def followed(use: Use) -> Iterator[CompileProgress]:
    """Follow what this process compiles while this lasts."""
    progress = CompileProgress(use)
    with install_listener("numba:compile", progress):
        yield progress
