"""Loops whose lateness is measured, each in a process of its own."""

import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.shared_memory import SharedMemory
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.acquisition import Source
from skinfield.errors import InputError
from skinfield.inverse import Solver
from skinfield.layout import Skin
from skinfield.realtime import Granted, PeriodicClock, RealTime, TimingTable
from skinfield.realtime.timing import FIELDS

if TYPE_CHECKING:
    from skinfield.conditioning import Convention
    from skinfield.live.settings import LiveSettings
    from skinfield.live.supervisor import Supervisor
    from skinfield.ring import RingReader

Words = NDArray[np.uint64]
PATIENCE = 120.0  # s until it runs: what must be compiled may take long
RUNGS = (10, 20, 40)


class Loop(Protocol):
    """A loop that runs."""

    @property
    def pid(self) -> int:
        """Of its process."""
        ...

    @property
    def granted(self) -> Granted:
        """What the system gave to it."""
        ...

    def snapshot(self) -> tuple[Words, Words]:
        """Copies of its histograms and totals."""
        ...

    def failure(self) -> str:
        """What went wrong with it, in words; empty where nothing did."""
        ...


@dataclass(frozen=True)
class Bare:
    """See `Loop`: it wakes and counts, and does nothing else."""

    pid: int
    granted: Granted
    times: Words
    totals: Words

    def snapshot(self) -> tuple[Words, Words]:
        """Copies of its histograms and totals."""
        return self.times.copy(), self.totals.copy()

    def failure(self) -> str:
        """Nothing is known of it."""
        return ""


@contextmanager
def bare_loop(rate: float, real_time: RealTime) -> Iterator[Bare]:
    """A loop that does nothing but wake: what Python costs."""
    sizes = [int(np.prod(shape)) for _, _, shape in FIELDS]
    memory = SharedMemory(create=True, size=8 * sum(sizes))
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    child = context.Process(
        target=_run_bare, args=(memory.name, int(1e9 / rate), real_time, theirs), daemon=True
    )
    child.start()
    theirs.close()
    times, totals = arrays_in(memory)
    try:
        if not ours.poll(PATIENCE):
            raise InputError(f"the loop did not start within {PATIENCE:g} s, expected less")
        yield Bare(int(child.pid or 0), Granted.from_dict(ours.recv()), times, totals)
    finally:
        ours.close()  # which ends it
        child.join(10)
        if child.is_alive():
            child.kill()
            child.join()
        del times, totals
        memory.close()
        memory.unlink()


def arrays_in(memory: SharedMemory) -> tuple[Words, Words]:
    """Times and totals of a `TimingTable` in shared memory."""
    found, offset = [], 0
    for _, dtype, shape in FIELDS:
        array: Words = np.ndarray(shape, dtype, memory.buf, offset)
        found.append(array)
        offset += array.nbytes
    return found[0], found[1]


def _run_bare(name: str, period_ns: int, real_time: RealTime, parent: Connection) -> None:
    """In the child: until the parent hangs up."""
    memory = SharedMemory(name)
    times, totals = arrays_in(memory)
    table = TimingTable(period_ns, times=times, totals=totals)
    clock = PeriodicClock(period_ns)
    parent.send(real_time.apply().as_dict())
    looks = max(200_000_000 // period_ns, 1)  # cycles from one look at the parent to the next
    while True:
        for _ in range(looks):
            due, wake = clock.wait()
            now = time.monotonic_ns()
            table.add(due, wake, now, now, now)
            table.set_skipped(clock.skipped)
        if parent.poll(0):  # hung up
            return


@dataclass(frozen=True)
class Engine:
    """See `Loop`: the engine of a live skin."""

    pid: int
    granted: Granted
    reader: "RingReader"
    supervisor: "Supervisor"

    def snapshot(self) -> tuple[Words, Words]:
        """Copies of its histograms and totals."""
        status = self.reader.status
        return status["times"].copy(), status["totals"].copy()

    def failure(self) -> str:
        """Why the engine had to be started again, or is gone."""
        return self.supervisor.failure


@contextmanager
def engine_loop(rate: float, solver: Solver, real_time: RealTime) -> Iterator[Engine]:
    """The engine of the paper's hexagon on 40 x 40 nodes, with two fingers that move over it.

    Their readings were made before and cost nothing to receive.
    """
    from skinfield.cli.jitter_source import Switch, fingers
    from skinfield.layout.generators import hexagon72

    patch = hexagon72()
    with ExitStack() as stack:
        switch = Switch()
        stack.callback(switch.close)
        source = fingers(patch, switch)
        settings = engine_settings(Skin((patch,)), source, None, rate, solver, real_time)
        yield _engine(stack, settings, switch.throw)


@contextmanager
def skin_loop(rate: float, solver: Solver, real_time: RealTime) -> Iterator[Engine]:
    """The same engine, which reads a virtual skin: messages of iCub boards, over UDP.

    The skin has a process of its own and sends as often as the engine answers.
    """
    from skinfield.conditioning import ICubByte
    from skinfield.layout.generators import hexagon72
    from skinfield.sources.live.spec import source_from_options
    from skinfield.virtual.process import start
    from skinfield.virtual.settings import VirtualSettings

    skin = Skin((hexagon72(),))
    settings = VirtualSettings(
        bus="udp", rate=rate, scene="idle", lead_in=0.0, priority=max(real_time.priority - 10, 0)
    )
    with ExitStack() as stack:
        boards = stack.enter_context(start(settings))
        source = source_from_options("icub", "udp", tuple(boards.channels), skin)
        live = engine_settings(skin, source, ICubByte(), rate, solver, real_time)
        yield _engine(stack, live, partial(boards.scene, "slide"))


def engine_settings(
    skin: Skin,
    source: Source,
    board: "Convention | None",
    rate: float,
    solver: Solver,
    real_time: RealTime,
) -> "LiveSettings":
    """Of an engine under a name that nobody else has."""
    from skinfield.live.settings import LiveSettings

    return LiveSettings(
        skin=skin,
        sources=(source,),
        name=f"bench-{uuid.uuid4().hex[:8]}",
        board=board,
        solver=solver,
        rungs=RUNGS,
        rate=rate,
        tare_seconds=0.5,
        real_time=real_time,
    )


def _engine(stack: ExitStack, settings: "LiveSettings", begin: Callable[[], object]) -> Engine:
    """Start it; `begin` is called when it has its baseline."""
    from skinfield.live.supervisor import Supervisor

    supervisor = stack.enter_context(Supervisor(settings))
    reader = supervisor.wait(PATIENCE)
    stack.callback(reader.close)
    begin()
    return Engine(reader.pid, _granted(reader), reader, supervisor)


def _granted(reader: "RingReader") -> Granted:
    """From the engine's notes, which it may be writing just now."""
    from skinfield.live.notes import read_notes

    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        notes = read_notes(reader.status["notes"])
        if notes is not None and "granted" in notes:
            return Granted.from_dict(notes["granted"])
        time.sleep(0.02)
    raise InputError(
        "the engine runs and does not say what was granted to it, expected that it did"
    )
