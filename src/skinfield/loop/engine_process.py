"""Engine process of a live skin, where nothing else runs: python -m skinfield.loop.engine_process.

It reads its settings from its standard input and answers until it is told to stop. Whoever started
it restarts it when it fails; the ring outlasts it.
"""

import os
import pickle
import signal
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from skinfield.compile_progress import CompileProgress, followed
from skinfield.errors import InputError, check_type
from skinfield.files.mcap.schema import CycleFlag
from skinfield.loop.baseline import BaselineCollector
from skinfield.loop.control import EngineControl
from skinfield.loop.intake import Intake
from skinfield.loop.model_config import FIELD as CONFIGURATION
from skinfield.loop.model_config import (
    Configuration,
    ModelConfig,
    model_config_of,
    write_configuration,
)
from skinfield.loop.preparation import Preparation, Start, quick
from skinfield.loop.process_supervisor import end_with
from skinfield.loop.realtime.clock import EventWaiter, PeriodicClock, Waiter
from skinfield.loop.realtime.timing import TimingTable
from skinfield.loop.ring_fields import POLLED, known_baseline, open_ring, write_baseline
from skinfield.loop.runtime_parameters import Limits
from skinfield.loop.settings import LiveSettings
from skinfield.loop.slots import CycleHead, CycleSlot, say_nothing
from skinfield.loop.status_text import read_notes, write_notes
from skinfield.loop.supervisor import GO, READY
from skinfield.loop.update import Updater
from skinfield.ring import RingReader, State

FIRST_LEAD = 0.25  # of a period
MOST_LEAD = 0.5
SPARE_NS = 30_000  # between the end of the work and the cycle
COOLING = 0.999  # of the lead, from cycle to cycle


class Prefetch:
    """Wakes shortly before each cycle is due and does some work, within a time that it learns.

    Parameters
    ----------
    clock : PeriodicClock
    work : function
        That would otherwise be done in the cycle.
    """

    def __init__(self, clock: PeriodicClock, work: Callable[[], None]) -> None:
        self._clock, self._work = clock, work
        self._most = MOST_LEAD * clock.period_ns
        self._lead = FIRST_LEAD * clock.period_ns

    def __call__(self) -> None:
        """Do it, if there is time before the next cycle."""
        if not self._clock.wake_before(int(self._lead)):
            return
        start = time.monotonic_ns()
        self._work()
        took = time.monotonic_ns() - start + SPARE_NS
        self._lead = min(max(COOLING * self._lead, took), self._most)


NS = 1e-9
STARTING_NS = 2_000_000  # from cycle to cycle while there is no answer yet
LISTEN = 8  # cycles from one look for orders to the next
LATE, OVERRUN = int(CycleFlag.LATE), int(CycleFlag.OVERRUN)


class EngineProcess:
    """All that happens in the process.

    Parameters
    ----------
    settings : LiveSettings
    prepared : Updater, optional
        To go on with at once from what the engine before published last.
    compiling : CompileProgress, optional
        Of this process.
    """

    def __init__(
        self,
        settings: LiveSettings,
        prepared: Updater | None = None,
        compiling: CompileProgress | None = None,
    ) -> None:
        self.settings, self.prepared = settings, prepared
        self.intake = Intake(settings.sources, POLLED)
        self.model_config = ModelConfig.of(settings, self.intake.ports)
        self.channel = self.model_config.binding.channel
        self.ring, fresh_ring = open_ring(settings, self.model_config)
        self.slots: dict[int, CycleSlot] = {}
        self.intake.count_in(self.ring.status["sources"])
        self.timing = TimingTable(
            int(settings.period * 1e9),
            int(settings.due_after * 1e9),
            self.ring.status["times"],
            self.ring.status["totals"],
        )
        self.limits = Limits.of(self.ring.description)
        before = None if fresh_ring else read_notes(self.ring.status[CONFIGURATION.name])
        self.tuning = settings.tuning if before is None else Configuration.from_dict(before).tuning
        self.last = None if fresh_ring else newest_cycle(settings.name)
        known = None if fresh_ring else known_baseline(self.ring)
        if known is not None:
            self.intake.resume()
        tracks, self.compiling = self.ring.status["tracks"], compiling
        self.start = Start(settings, self.model_config, known, tracks, compiling)
        self.better: Preparation | None = None
        self.control = EngineControl(settings.name)
        self.updater: Updater | None = None
        self._go_by_tuning()
        self.flags = 0 if fresh_ring else int(CycleFlag.RESTARTED)
        self.stopping, self.ending = False, State.STOPPED
        self.running_ns = 0  # when it began to answer
        self.waiter: Waiter = PeriodicClock(STARTING_NS)
        self.reset = True  # whether the next answer begins without knowledge of those before
        self.began = False
        self.replaced: Updater | None = None  # by a better one, in this cycle
        self.again: BaselineCollector | None = None
        self.prefetch: Prefetch | None = None
        self.taken = 0  # messages, before the cycle
        self.looks = max(int(1.0 / settings.period), 1)  # cycles between looks at the sources
        self.notes: dict[str, object] = {"phase": self.start.phase, "progress": self.start.progress}
        write_notes(self.ring.status["notes"], self.notes)

    def run(self) -> None:
        """Answer until told to stop."""
        signal.signal(signal.SIGTERM, self._stop)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the terminal's, meant for our parent
        self.ring.set_state(State.STARTING)
        count = 0
        try:
            prepared, ports = self.prepared, self.model_config.ports
            if prepared is not None and prepared.model_config.ports == ports:
                self._go_on(prepared)
            while not self.stopping:
                if self.prefetch is not None:
                    self.prefetch()
                due, wake = self.waiter.wait()
                self.one(due, wake)
                count += 1
                if count % LISTEN == 0:
                    self._obey(self.control.poll())
                if count % self.looks == 0:
                    self._note_what_is_new()
            self.ring.set_state(self.ending)
        except BaseException:
            self.ending = State.FAILED
            self.ring.set_state(self.ending)
            raise
        finally:
            self.close()

    def one(self, due: int, wake: int) -> None:
        """One cycle."""
        wall = time.time_ns()
        ring, intake = self.ring, self.intake
        messages, self.taken = intake.poll(wall) + self.taken, 0
        slot = self._slot()
        head = slot.head
        if self.updater is None:
            self._begin(wall)
        elif self.again is not None and self.again.take(intake.channels, wall):
            self._finish_tare(self.updater)
        if self.better is not None:
            self._improve(self.better)
        self._log()
        acquired = time.monotonic_ns()
        head[CycleHead.DUE_NS], head[CycleHead.WAKE_NS] = due, wake
        head[CycleHead.ACQUIRED_NS], head[CycleHead.WALL_NS] = acquired, wall
        head[CycleHead.LOG_POSITION], head[CycleHead.MESSAGES] = ring.log_end, messages
        if self.updater is None or self.began:
            self.began = False  # it took long to get ready: the next cycle is the first on time
            self._without_answer(slot)
            return
        self._answer(self.updater, slot, wake, wall)

    def _prefetch(self) -> None:
        """Before a cycle is due: take in what is there already."""
        self.taken += self.intake.poll(time.time_ns())
        self._log()

    def _log(self) -> None:
        """Log what was taken in; what is logged is not logged again."""
        blocks = self.intake.blocks
        if blocks.end[0]:
            self.ring.log(blocks.octets, int(blocks.end[0]) * 8)
            blocks.clear()

    def _answer(self, updater: Updater, slot: CycleSlot, wake: int, wall: int) -> None:
        head = slot.head
        budget_ns = head[CycleHead.BUDGET_NS] = self.budget_ns
        reset, self.reset = self.reset, False
        budget = budget_ns * NS
        fresh = updater.answer(self.intake.channels, wall, slot, reset=reset, budget=budget)
        head[CycleHead.FLAGS] |= self.flags
        self.flags = 0
        due = int(head[CycleHead.DUE_NS])
        ready = time.monotonic_ns()
        if ready - due > self.timing.deadline_ns:
            head[CycleHead.FLAGS] |= LATE
        if ready - due > self.timing.period_ns:
            head[CycleHead.FLAGS] |= OVERRUN
        head[CycleHead.READY_NS] = ready
        self.ring.publish()
        published = time.monotonic_ns()
        latency = -1
        if fresh:
            latency = max(wall + (published - wake) - updater.newest_ns, 0)
        acquired = int(head[CycleHead.ACQUIRED_NS])
        self.timing.add(due, wake, acquired, published, time.monotonic_ns(), latency)
        self.timing.set_skipped(self.waiter.skipped)
        self.ring.heartbeat(published)

    def _slot(self) -> CycleSlot:
        """The next slot, named; views are made once for each."""
        arrays = self.ring.begin()
        slot = self.slots.get(id(arrays))  # the ring keeps one mapping for each slot
        if slot is None:
            slot = self.slots[id(arrays)] = CycleSlot.of(arrays)
            slot.head[CycleHead.GENERATION] = self.ring.generation
        return slot

    def _begin(self, wall: int) -> None:
        """Go on with the start; from when there is a cycle on, answer."""
        start = self.start
        before = start.phase
        updater = start.take(self.intake.channels, wall)
        self._note_progress(start.progress)
        if start.phase != before:
            self.ring.set_state(State.CALIBRATING)
            self._note(phase=start.phase)
            if start.baseline is not None:
                write_baseline(self.ring, start.baseline)
                self._note(tare=list(start.baseline.notes))
        if updater is not None:
            self._go(updater)
            assert start.baseline is not None  # of which the updater was made
            rehearsal, start.rehearsal = start.rehearsal, None
            if updater.model_config.solver != self.model_config.solver:
                self.better = Preparation(
                    self.model_config, start.baseline, after=rehearsal, compiling=self.compiling
                )

    def _improve(self, better: Preparation) -> None:
        """Go over to the solver that was asked for, as soon as it is ready."""
        if better.progress:
            self._note_progress(better.progress)
        before = self.updater
        if not better.has_ended or before is None:
            return
        self.better = None
        try:
            made = better.updater
            assert made is not None  # it has ended
        except Exception as error:  # what answers goes on
            solver = type(before.model_config.solver).__name__
            failed = f"{type(self.model_config.solver).__name__} cannot be prepared"
            self._note(progress={}, failed=f"{failed}, {solver} goes on: {error}")
            return
        made.take_over(before, self.ring.status["calibration"])
        if self.last is not None:
            made.recall(self.last)
        made.tune(self.tuning)
        self.updater, self.reset, self.began, self.replaced = made, True, True, before
        linear_s = round((time.monotonic_ns() - self.running_ns) * NS, 3)
        self._note(progress={}, solver=type(made.model_config.solver).__name__, linear_s=linear_s)

    def _note_progress(self, progress: Mapping[str, float]) -> None:
        if progress != self.notes["progress"]:
            self._note(progress=dict(progress))

    def _go(self, updater: Updater) -> None:
        """Answer from now on, and nothing may wait; contacts of an engine before go on."""
        settings, last = self.settings, self.last
        self.updater, self.reset, self.began = updater, True, True
        updater.tune(self.tuning)
        if last is not None:
            updater.resume(last)
        granted = settings.real_time.apply()
        self.running_ns = time.monotonic_ns()
        by, wanted = updater.model_config.solver, self.model_config.solver
        progress = {} if by == wanted else {"patches": 0, "of": updater.sizes.patches}
        known = {"granted": granted.as_dict(), "solver": type(by).__name__, "linear_s": 0.0}
        self._note(phase="running", progress=progress, **known)
        if settings.rate is None:
            self.waiter = EventWaiter(self.intake.filenos, int(settings.period * 1e9))
        else:
            self.waiter = clock = PeriodicClock(int(settings.period * 1e9))
            if settings.prefetch and granted.real_time:
                self.prefetch = Prefetch(clock, self._prefetch)
        self.ring.set_state(State.RUNNING)

    def _go_on(self, updater: Updater) -> None:
        """Take over from the engine before, without a start."""
        updater.count_in(self.ring.status["tracks"])
        self._go(updater)
        self.began = False

    def _note_what_is_new(self) -> None:
        """Publish what the sources and the solver say, and what searches last, where new."""
        said = self.intake.sentences()
        if said != self.notes.get("sources", []):
            self._note(sources=said)
        found = {} if self.updater is None else self.updater.engine.notes
        if found != self.notes.get("readings", {}):
            self._note(readings=found)
        lasting = {} if self.updater is None else self.updater.unfinished(time.time_ns())
        if lasting != self.notes.get("searching", {}):
            self._note(searching=lasting)

    def _without_answer(self, slot: CycleSlot) -> None:
        """A slot that says that all patches are missing; as before, where a solver was replaced."""
        replaced, self.replaced = self.replaced, None
        if replaced is not None:
            replaced.repeat(self.intake.channels, slot)
        else:
            say_nothing(slot, int(self.ring.status["tracks"][0]))
            slot.counts[:] = self.intake.channels.counts[self.channel]
        slot.head[CycleHead.READY_NS] = time.monotonic_ns()
        self.ring.publish()
        self.ring.heartbeat(time.monotonic_ns())

    def _note(self, **more: object) -> None:
        self.notes.update(more)
        write_notes(self.ring.status["notes"], self.notes)

    def _obey(self, order: str) -> None:
        if order in ("stop", "hand over"):
            self.stopping = True
            self.ending = State.STOPPED if order == "stop" else State.STARTING
        elif order == "tare" and self.updater is not None:
            self._tare_again()
        elif order == "set":
            self._note(refused=self._tune(self.control.values))

    def _tune(self, order: Mapping[str, Any]) -> str:
        """Obey an order to change the tuning; why it was refused, or nothing."""
        changes: Any = order.get("set")
        try:
            check_type("changes", changes, Mapping, "values by the names of settings")
            self.tuning = self.limits.check(self.tuning.changed(changes))
        except InputError as error:
            return str(error)
        self._go_by_tuning()
        return ""

    def _go_by_tuning(self) -> None:
        """Have the tuning in force from the next cycle on; the ring and recordings say so."""
        self.budget_ns = round(self.tuning.deadline * 1e9)
        known = Configuration(self.ring.generation, self.settings.solver, self.tuning)
        write_configuration(self.ring.status[CONFIGURATION.name], known)
        if self.updater is not None:
            self.updater.tune(self.tuning)

    def _tare_again(self) -> None:
        """Take a new baseline of an untouched skin; answers go on by the old one until then."""
        self.again = BaselineCollector(self.settings, self.model_config.binding, anew=True)
        self.again.skip(self.intake.channels)
        self._note(tare=["a new baseline is being taken"])

    def _finish_tare(self, updater: Updater) -> None:
        """Take over a new baseline, at the cost of some cycles; noise and ages stay the same."""
        tare, self.again = self.again, None
        assert tare is not None  # whoever calls has looked
        try:
            found = tare.finish()
        except InputError as error:  # of what came meanwhile: that must not end what works
            self._note(tare=[f"the baseline stays as it was: {error}"])
            return
        noise_std = self.ring.status["noise_std"].copy()
        baseline = replace(found, noise_std=noise_std, stale_ns=updater.stale_ns)
        write_baseline(self.ring, baseline)
        updater.calibrate(baseline.calibration)
        self.reset = True
        self._note(tare=list(baseline.notes))

    def _stop(self, *_: object) -> None:
        self.stopping = True

    def close(self) -> None:
        """Let go of everything; the ring stays for its readers."""
        self.intake.close(leave=self.ending != State.STOPPED)
        self.control.close()
        self.ring.close()


def newest_cycle(name: str) -> CycleSlot | None:
    """What an engine before published last; None if that was nothing."""
    with RingReader(name) as reader:
        last = reader.latest()
    return None if last is None else CycleSlot.of(last.arrays)


def prepared_from_ring(settings: LiveSettings) -> Updater:
    """What an engine takes over with: of the ports and the calibration of the one that runs.

    Raises
    ------
    InputError
        If that has no baseline.
    """
    with RingReader(settings.name) as reader:
        known, ports = known_baseline(reader), model_config_of(reader).ports
    if known is None:
        raise InputError(
            f"{settings.name!r} has no baseline yet, expected one that answers: wait until it runs"
        )
    return Updater(ModelConfig.of(settings, ports), known)


def main() -> None:
    """Read the settings and run."""
    end_with(int(sys.argv[1]) if len(sys.argv) > 1 else os.getppid())
    settings, takes_over = pickle.load(sys.stdin.buffer)
    prepared = None
    if takes_over:
        prepared = prepared_from_ring(settings)
        sys.stdout.buffer.write(READY)
        sys.stdout.buffer.flush()
        if sys.stdin.buffer.readline() != GO:
            return  # it is not wanted any more
    with followed("run" if quick(settings.solver) != settings.solver else "linear") as compiling:
        EngineProcess(settings, prepared, compiling).run()
    os._exit(0)  # others wait for the end of this process: to tear Numba down takes 0.1 s


if __name__ == "__main__":
    main()
