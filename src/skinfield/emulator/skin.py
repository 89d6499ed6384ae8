"""Virtual skin: boards as any hardware offers them, faults in time, and the loop of it all."""

import math
import os
import select
import time
from bisect import insort
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from skinfield.emulator.cyskin import CySkinBoards
from skinfield.emulator.hardware import MISHAPS, NEVER, Hardware
from skinfield.emulator.icub import ICubBoards
from skinfield.emulator.packet import PacketDevices
from skinfield.emulator.scenes import SCENES, CurrentPress, Scene, scene_from_text, with_fingers
from skinfield.emulator.settings import FOREVER, Fault, VirtualSettings, fault_from_text
from skinfield.emulator.transports import Command, ControlServer, Request
from skinfield.emulator.truth_log import TruthLog
from skinfield.emulator.world import World
from skinfield.errors import InputError
from skinfield.files.layouts.load import skin_from_text

BOARDS: dict[str, type[ICubBoards | CySkinBoards | PacketDevices]] = {  # by `settings.BOARDS`
    "icub": ICubBoards,
    "cyskin": CySkinBoards,
    "packet": PacketDevices,
}
MOST = 10_000  # to come


@dataclass
class FaultClock:
    """Begins and ends faults when their time comes.

    Attributes
    ----------
    begun : Counter
        How many of each kind began.
    active : list of Fault
    """

    hardware: Hardware
    begun: Counter[str] = field(default_factory=Counter)
    active: list[Fault] = field(default_factory=list)
    _coming: list[Fault] = field(default_factory=list)  # in the order of their beginnings

    def add(self, fault: Fault) -> None:
        """Take in a fault.

        Raises
        ------
        InputError
            If there is no such triangle, board, bus or taxel.
        """
        self.hardware.places(fault.kind, fault.what)
        if len(self._coming) + len(self.active) >= MOST:
            raise InputError(f"{MOST} faults are to come, expected fewer: clear them first")
        insort(self._coming, fault, key=lambda each: each.start)

    @property
    def next_time(self) -> float:
        """When the next one begins or ends, s since the stream began."""
        times = [fault.start for fault in self._coming[:1]] + [each.end for each in self.active]
        return min(times, default=FOREVER)

    def advance(self, time: float, now_ns: int, warmth: float) -> None:
        """Begin and end what is due at a time, s since the stream began."""
        while (due := self.next_time) <= time:
            if self._coming and self._coming[0].start <= due:
                fault = self._coming.pop(0)
                self.begun[fault.kind] += 1
                self.active.append(fault)
                self.hardware.begin(fault.kind, fault.what, now_ns)
            else:
                self._end(min(self.active, key=lambda each: each.end), now_ns, warmth)

    def clear(self, kind: str | None, now_ns: int, warmth: float) -> int:
        """End all faults of a kind, or all, and forget those to come; how many."""
        self._coming = [each for each in self._coming if kind not in (None, each.kind)]
        ending = [fault for fault in self.active if kind in (None, fault.kind)]
        for fault in ending:
            self._end(fault, now_ns, warmth)
        return len(ending)

    def _end(self, fault: Fault, now_ns: int, warmth: float) -> None:
        self.active.remove(fault)
        self.hardware.end(fault.kind, fault.what, now_ns, warmth)


LINES = 100  # of truth in one answer, at most
LONGEST_WAIT = 0.05  # s: how often it looks for signals and for tables that are solved
SECOND = 1_000_000_000
HELD_UP = (
    1.0  # s without a turn of the loop: boards, which have processors of their own, never stop
)


class VirtualSkin:
    """A skin of boards that does not exist, on a real bus.

    Parameters
    ----------
    settings : VirtualSettings
    clock : function
        Gives the time, ns since the epoch.

    Raises
    ------
    InputError
        If a setting cannot be used, or an address is taken.

    Attributes
    ----------
    pressing : list of CurrentPress
        What presses now.
    """

    def __init__(self, settings: VirtualSettings, clock: Callable[[], int] = time.time_ns) -> None:
        self.settings, self.clock = settings, clock
        self.skin = skin_from_text(settings.skin)
        true, self._soft = settings.its_habits.tolerances, bool(settings.its_habits.fingers)
        rng = np.random.default_rng([settings.seed, 5])
        layer = replace(true.layer(settings.layer, rng), relaxation=None)  # converters creep
        plane = np.concatenate([true.plane(patch, rng) for patch in self.skin])
        self.world = World(self.skin, layer, self._scene_of(settings.scene), plane)
        self.hardware: Hardware = BOARDS[settings.hardware](self.skin, settings)
        self._control: ControlServer | None = None
        self._ended = False
        self.notes: list[str] = []
        self.started_ns = self.clock()
        self.stream_ns = 0  # when the first reading was sent
        self._scene_ns = 0
        self.pressing: list[CurrentPress] = []
        self._slow_ns = self._turned_ns = 0
        try:
            self.faults = FaultClock(self.hardware)
            for fault in (*self.hardware.converters.faults, *settings.faults):
                self.faults.add(fault)
            if settings.control:
                self._control = ControlServer(settings.control, self.commands())
            self.truth = TruthLog(self.skin, settings.truth)
        except BaseException:
            self.hardware.close()
            self.world.close()
            raise
        self._update(self.clock())
        self.hardware.reschedule(self.clock())

    @property
    def control_address(self) -> str:
        """Where the control socket is; empty without one."""
        return self._control.address if self._control is not None else ""

    def time(self, now_ns: int) -> float:
        """Seconds since the stream began; negative before."""
        return (now_ns - self.stream_ns) / SECOND if self.stream_ns else -1.0

    def warmth(self, now_ns: int) -> float:
        """K above 25 °C."""
        return self.settings.surroundings.warmth(max(self.time(now_ns), 0.0))

    def stop(self) -> None:
        """Let `run` return soon; for signal handlers and other threads."""
        self._ended = True

    def run(
        self, watch: Sequence[int] = (), each_second: Callable[["VirtualSkin"], None] | None = None
    ) -> None:
        """Play until `stop`, the duration, or until a file descriptor of `watch` is readable.

        Parameters
        ----------
        watch : sequence of int
            Such as a pipe that ends with the process at its other end.
        each_second : function, optional
            Called about once a second, to show what happens.
        """
        watched = set(watch)
        self.hardware.schedule.begin(self.clock())
        begun = told = time.monotonic()
        self.notes += ask_for_priority(self.settings.priority)
        while not self._ended:
            if self._wait(watched) & watched:
                break
            now_ns = self.clock()
            self.step(now_ns)
            if each_second is not None and time.monotonic() - told >= 1.0:
                told = time.monotonic()
                each_second(self)
            duration = self.settings.duration
            if duration is not None and time.monotonic() - begun >= duration:
                break

    def _wait(self, watched: set[int]) -> set[int]:
        """Wait for the next reading, a host or a command; the descriptors that have something."""
        descriptors = [*self.hardware.filenos(), *watched]
        if self._control is not None:
            descriptors.append(self._control.fileno())
        wait = (self.hardware.schedule.next_ns - self.clock()) / SECOND
        ready = set(select.select(descriptors, [], [], min(max(wait, 0.0), LONGEST_WAIT))[0])
        if self._control is not None and self._control.fileno() in ready:
            self._control.poll()
        now_ns = self.clock()
        late = 0 < self._turned_ns < now_ns - HELD_UP * SECOND
        self._turned_ns = now_ns
        if ready.intersection(self.hardware.filenos()):
            listen = self.hardware.listen_late if late else self.hardware.listen
            listen(now_ns, self.warmth(now_ns))
        return ready

    def step(self, now_ns: int) -> None:
        """Do what is due at a time."""
        if self.faults.next_time <= self.time(now_ns):
            self.faults.advance(self.time(now_ns), now_ns, self.warmth(now_ns))
        if now_ns - self._slow_ns > LONGEST_WAIT * SECOND:
            self._slow_ns = now_ns
            self.world.poll()
            self._update(now_ns)
        schedule = self.hardware.schedule
        if schedule.next_ns > now_ns or schedule.next_ns == NEVER:
            return
        if not self.stream_ns:
            self.stream_ns = now_ns
            self._scene_ns = now_ns + int(self.settings.lead_in * SECOND)
            self.faults.advance(0.0, now_ns, self.warmth(now_ns))
        due = schedule.due(now_ns)
        self._update(now_ns - int(self.settings.wires.delay_ms * 1e-3 * SECOND))
        self.hardware.converters.convert(self.warmth(now_ns), now_ns)
        for group in due:
            self.hardware.send(group.members, now_ns)

    def _update(self, moment_ns: int) -> None:
        """Bring what the taxels read to a moment."""
        scene = (moment_ns - self._scene_ns) / SECOND if self._scene_ns else -1.0
        touches = self.world.update(scene, self.hardware.converters.change)
        if touches is not None:
            self.pressing = touches
        self.truth.note(touches, moment_ns)

    def counts(self) -> dict[str, Any]:
        """What was sent, and what was done to it, so far."""
        now_ns = self.clock()
        return {
            "seconds": round((now_ns - self.started_ns) / SECOND, 3),
            "streamed_seconds": round(max(self.time(now_ns), 0.0), 3),
            "readings": self.hardware.readings,
            "skipped": self.hardware.schedule.skipped,
            **self.hardware.counts(),
            "faults": dict(self.faults.begun),
            "truth_lines": self.truth.made,
            "notes": [*self.notes, *self.world.notes],
        }

    def description(self) -> dict[str, Any]:
        """What it is and where it is reached."""
        return {
            "hardware": self.settings.hardware,
            "bus": self.settings.bus,
            "channels": list(self.hardware.addresses),
            "control": self.control_address,
            "skin": self.settings.skin,
            "patches": {patch.name: len(patch) for patch in self.skin},
            "scene": self.world.scene.name,
        }

    def commands(self) -> Mapping[str, Command]:
        """What `do` can be; each takes the command's other fields and gives the answer's."""
        return {
            "press": self.world.press,
            "move": self.world.move,
            "release": self.world.release,
            "prepare": self.world.prepare,
            "tools": self.world.tools,
            "fault": self._fault,
            "clear": self._clear,
            "wires": self._wires,
            "scene": self._scene,
            "counts": lambda _: self.counts(),
            "truth": self._truth,
            "describe": lambda _: self.description(),
            "quit": self._quit,
        }

    def _fault(self, request: Request) -> dict[str, Any]:
        """Add a fault, whose times count from now."""
        fault, now_ns = fault_from_text(request.fault), self.clock()
        fault = replace(fault, start=max(self.time(now_ns), 0.0) + fault.start)
        self.faults.add(fault)
        if self.stream_ns:
            self.faults.advance(self.time(now_ns), now_ns, self.warmth(now_ns))
        until = fault.end if math.isfinite(fault.end) else None
        return {"kind": fault.kind, "what": fault.what, "start": fault.start, "end": until}

    def _clear(self, request: Request) -> dict[str, Any]:
        now_ns = self.clock()
        return {"cleared": self.faults.clear(request.kind, now_ns, self.warmth(now_ns))}

    def _wires(self, request: Request) -> dict[str, float]:
        for wire in self.hardware.wires:
            for name in MISHAPS:
                chance = getattr(request, name)
                wire.chances[name] = wire.chances[name] if chance is None else chance
        return dict(self.hardware.wires[0].chances)

    def _scene_of(self, text: str) -> Scene:
        seed = self.settings.seed
        scene = scene_from_text(text, self.skin, seed)
        return with_fingers(scene, seed) if self._soft and text in SCENES else scene

    def _scene(self, request: Request) -> dict[str, Any]:
        """Play another scene, from its beginning."""
        self.world.play(self._scene_of(request.scene))
        if self.stream_ns:
            self._scene_ns = self.clock()
        return {"scene": self.world.scene.name}

    def _truth(self, request: Request) -> dict[str, Any]:
        """Lines from `after` on, as many as one answer holds; the newest alone without it."""
        made = self.truth.made
        first = max(made - 1, 0) if request.after is None else request.after
        lines = self.truth.after(first, LINES)
        while len(lines) > 1 and sum(len(line["presses"]) for line in lines) > LINES:
            lines = lines[: len(lines) // 2]
        found = {"lines": lines, "made": made, "stamp_ns": self.clock()}
        return {**found, "waits": self.world.waits, "notes": self.world.notes}

    def _quit(self, _: Request) -> dict[str, Any]:
        self.stop()
        return {}

    def close(self) -> None:
        """Let go of everything."""
        self.hardware.close()
        if self._control is not None:
            self._control.close()
        self.world.close()
        self.truth.close()


def ask_for_priority(priority: int) -> list[str]:
    """Ask for SCHED_FIFO; a sentence if it is not granted.

    The loop sleeps in every cycle; what it starts is not real-time.
    """
    if not priority:
        return []
    try:
        policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    except (OSError, AttributeError) as error:
        return [
            f"SCHED_FIFO with priority {priority} is not granted ({error}): readings may be late; "
            "run as root, or with the right to real time (ulimit -r)"
        ]
    return []
