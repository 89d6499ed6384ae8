"""The process in which nothing runs but the engine: python -m skinfield.live.engine_process.

It reads its settings from its standard input and answers until it is told to stop. Whoever started
it restarts it when it fails; the ring outlasts it.
"""

import os
import pickle
import signal
import sys
import time
from dataclasses import replace

from skinfield.acquisition.recorded import CycleFlag
from skinfield.errors import InputError
from skinfield.live.binding import Binding, bind
from skinfield.live.control import Control
from skinfield.live.cycle import Cycle
from skinfield.live.early import Early
from skinfield.live.handover import GO, READY, Handover
from skinfield.live.intake import Intake
from skinfield.live.journal import Journal, tune_or_say
from skinfield.live.notes import write_notes
from skinfield.live.parent import end_with
from skinfield.live.recipe import Recipe
from skinfield.live.ring_fields import known_tare, open_ring, room_for, write_tare
from skinfield.live.settings import LiveSettings
from skinfield.live.slots import Head, Slot
from skinfield.live.start import Start
from skinfield.live.tare import Tare
from skinfield.live.unanswered import say_nothing
from skinfield.realtime import EventWaiter, PeriodicClock, TimingTable, Waiter
from skinfield.ring import RingReader, State

NS = 1e-9
STARTING_NS = 2_000_000  # from cycle to cycle while there is no answer yet
LISTEN = 8  # cycles from one look for orders to the next
LATE, OVERRUN = int(CycleFlag.LATE), int(CycleFlag.OVERRUN)


class EngineProcess:
    """All that happens in the process.

    Parameters
    ----------
    settings : LiveSettings
    prepared : Binding and Cycle, optional
        To go on with at once from what the engine before published last.
    """

    def __init__(
        self, settings: LiveSettings, prepared: tuple[Binding, Cycle] | None = None
    ) -> None:
        self.settings, self.prepared = settings, prepared
        self.intake = Intake(settings.sources, room_for(sum(map(len, settings.skin))))
        self.binding = bind(settings.skin, self.intake.ports)
        self.recipe = Recipe.of(settings, self.intake.ports)
        self.ring, fresh_ring = open_ring(settings, self.recipe)
        self.slots: dict[int, Slot] = {}
        self.intake.count_in(self.ring.status["sources"])
        self.timing = TimingTable(
            int(settings.period * 1e9),
            int(settings.due_after * 1e9),
            self.ring.status["times"],
            self.ring.status["totals"],
        )
        self.journal = Journal(self.ring, self.intake.blocks, settings, fresh_ring)
        known = None if fresh_ring else known_tare(self.ring)
        if known is not None:
            self.intake.resume()
        self.start = Start(settings, self.binding, known, self.ring.status["tracks"])
        self.control = Control(settings.name)
        self.cycle: Cycle | None = None
        self.flags = 0 if fresh_ring else int(CycleFlag.RESTARTED)
        self.stopping, self.ending = False, State.STOPPED
        self.waiter: Waiter = PeriodicClock(STARTING_NS)
        self.since_key = 0
        self.keys = 1
        self.began = False
        self.again: Tare | None = None
        self.early: Early | None = None
        self.taken = 0  # messages, before the cycle
        self.said: list[str] = []
        self.looks = max(int(1.0 / settings.period), 1)  # cycles between looks at the sources
        self.notes: dict[str, object] = {"phase": self.start.phase}
        write_notes(self.ring.status["notes"], self.notes)

    def run(self) -> None:
        """Answer until told to stop."""
        signal.signal(signal.SIGTERM, self._stop)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the terminal's, meant for our parent
        self.ring.set_state(State.STARTING)
        count = 0
        try:
            if self.prepared is not None and self.prepared[0].ports == self.binding.ports:
                self._go_on(self.prepared[1])
            while not self.stopping:
                if self.early is not None:
                    self.early()
                due, wake = self.waiter.wait()
                self.one(due, wake)
                count += 1
                if count % LISTEN == 0:
                    self._obey(self.control.poll())
                if count % self.looks == 0:
                    self._listen_to_sources()
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
        if self.cycle is None:
            self._begin(wall)
        elif self.again is not None and self.again.take(intake.channels, wall):
            self._finish_tare(self.cycle, wall)
        if self.since_key <= 0 and self.cycle is not None and not self.began:
            self.journal.key(self.cycle, wall)
        self.journal.log()
        acquired = time.monotonic_ns()
        head[Head.DUE_NS], head[Head.WAKE_NS] = due, wake
        head[Head.ACQUIRED_NS], head[Head.WALL_NS] = acquired, wall
        head[Head.LOG_POSITION], head[Head.MESSAGES] = ring.log_end, messages
        if self.cycle is None or self.began:
            self.began = False  # it took long to get ready: the next cycle is the first on time
            self._without_answer(slot)
            return
        self._answer(self.cycle, slot, wake, wall)

    def _take_in_early(self) -> None:
        """Before a cycle is due: take in what is there already."""
        self.taken += self.intake.poll(time.time_ns())
        self.journal.log()

    def _answer(self, cycle: Cycle, slot: Slot, wake: int, wall: int) -> None:
        head = slot.head
        key = self.since_key <= 0
        self.since_key = self.keys if key else self.since_key - 1
        budget_ns = head[Head.BUDGET_NS] = self.journal.budget_ns
        budget = budget_ns * NS
        fresh = cycle.answer(self.intake.channels, wall, slot, key=key, budget=budget)
        head[Head.FLAGS] |= self.flags
        self.flags = 0
        due = int(head[Head.DUE_NS])
        ready = time.monotonic_ns()
        if ready - due > self.timing.deadline_ns:
            head[Head.FLAGS] |= LATE
        if ready - due > self.timing.period_ns:
            head[Head.FLAGS] |= OVERRUN
        head[Head.READY_NS] = ready
        self.ring.publish()
        published = time.monotonic_ns()
        latency = -1
        if fresh:
            latency = max(wall + (published - wake) - cycle.newest_ns, 0)
        acquired = int(head[Head.ACQUIRED_NS])
        self.timing.add(due, wake, acquired, published, time.monotonic_ns(), latency)
        self.timing.set_skipped(self.waiter.skipped)
        self.ring.heartbeat(published)

    def _slot(self) -> Slot:
        """The next slot, named; views are made once for each."""
        arrays = self.ring.begin()
        slot = self.slots.get(id(arrays))  # the ring keeps one mapping for each slot
        if slot is None:
            slot = self.slots[id(arrays)] = Slot.of(arrays)
            slot.head[Head.GENERATION] = self.ring.generation
        return slot

    def _begin(self, wall: int) -> None:
        """Go on with the start; from when there is a cycle on, answer."""
        start = self.start
        before = start.phase
        cycle = start.take(self.intake.channels, wall)
        if start.phase != before:
            self.ring.set_state(State.CALIBRATING)
            self._note(phase=start.phase)
            if start.tared is not None:
                self.journal.log()  # so that a calibration has all the room
                write_tare(self.ring, start.tared, self.intake.blocks, wall)
                self._note(tare=list(start.tared.notes))
        if cycle is not None:
            self._go(cycle)

    def _go(self, cycle: Cycle) -> None:
        """From here on nothing may wait."""
        settings = self.settings
        self.cycle, self.since_key, self.began = cycle, 0, True
        cycle.tuned.tune(self.journal.tuning)
        self.keys = max(int(settings.key_seconds / settings.period), 1)
        granted = settings.real_time.apply()
        self._note(phase="running", granted=granted.as_dict())
        if settings.rate is None:
            self.waiter = EventWaiter(self.intake.filenos, int(settings.period * 1e9))
        else:
            self.waiter = clock = PeriodicClock(int(settings.period * 1e9))
            if settings.early and granted.real_time:
                self.early = Early(clock, self._take_in_early)
        self.ring.set_state(State.RUNNING)

    def _go_on(self, cycle: Cycle) -> None:
        """Take over from the engine before: contacts keep their numbers."""
        cycle.count_in(self.ring.status["tracks"])
        with RingReader(self.settings.name) as reader:
            last = reader.latest()
        if last is not None:
            cycle.resume(Slot.of(last.arrays))
        self._go(cycle)
        self.began = False

    def _listen_to_sources(self) -> None:
        """Tell what the sources say, where that is new."""
        said = self.intake.said()
        if said != self.said:
            self.said = said
            self._note(sources=said)

    def _without_answer(self, slot: Slot) -> None:
        """A slot that says that all patches are missing."""
        say_nothing(slot, int(self.ring.status["tracks"][0]))
        slot.head[Head.READY_NS] = time.monotonic_ns()
        slot.counts[:] = self.intake.channels.counts[self.binding.channel]
        self.ring.publish()
        self.ring.heartbeat(time.monotonic_ns())

    def _note(self, **more: object) -> None:
        self.notes.update(more)
        write_notes(self.ring.status["notes"], self.notes)

    def _obey(self, order: str) -> None:
        if order in ("stop", "hand over"):
            self.stopping = True
            self.ending = State.STOPPED if order == "stop" else State.STARTING
        elif order == "key":
            self.since_key = 0
        elif order == "tare" and self.cycle is not None:
            self._tare_again()
        elif order == "set":
            self._note(refused=tune_or_say(self.journal, self.control.values, self.cycle))

    def _tare_again(self) -> None:
        """Take a new baseline of an untouched skin; answers go on by the old one until then."""
        self.again = Tare(self.settings, self.binding)
        self.again.skip(self.intake.channels)
        self._note(tare=["a new baseline is being taken"])

    def _finish_tare(self, cycle: Cycle, wall: int) -> None:
        """Take over a new baseline, at the cost of some cycles; noise and ages stay the same."""
        tare, self.again = self.again, None
        assert tare is not None  # whoever calls has looked
        try:
            found = tare.finish()
        except InputError as error:  # of what came meanwhile: that must not end what works
            self._note(tare=[f"the baseline stays as it was: {error}"])
            return
        noise_std = self.ring.status["noise_std"].copy()
        tared = replace(found, noise_std=noise_std, stale_ns=cycle.stale_ns)
        self.journal.log()
        write_tare(self.ring, tared, self.intake.blocks, wall)
        cycle.calibrate(tared.calibration)
        self.since_key = 0
        self._note(tare=list(tared.notes))

    def _stop(self, *_: object) -> None:
        self.stopping = True

    def close(self) -> None:
        """Let go of everything; the ring stays for its readers."""
        self.intake.close(leave=self.ending != State.STOPPED)
        self.control.close()
        self.ring.close()


def main() -> None:
    """Read the settings and run."""
    end_with(int(sys.argv[1]) if len(sys.argv) > 1 else os.getppid())
    asked, prepared = pickle.load(sys.stdin.buffer), None
    if isinstance(asked, Handover):
        prepared = asked.cycle()
        sys.stdout.buffer.write(READY)
        sys.stdout.buffer.flush()
        if sys.stdin.buffer.readline() != GO:
            return  # it is not wanted any more
        asked = asked.settings
    if not isinstance(asked, LiveSettings):
        raise InputError(f"settings are {type(asked).__name__}, expected LiveSettings")
    engine = EngineProcess(asked, prepared)
    engine.run()
    if engine.ending != State.STOPPED:  # the next one waits for the end of this process
        os._exit(0)


if __name__ == "__main__":
    main()
