"""The virtual skin: what it feels, what its boards make of it, and when they send it."""

import os
import select
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from skinfield.errors import InputError
from skinfield.layout.words import skin_from_text
from skinfield.virtual.commands import commands_of
from skinfield.virtual.control import Control
from skinfield.virtual.fault_clock import FaultClock
from skinfield.virtual.hardware import Hardware
from skinfield.virtual.hardwares import open_hardware
from skinfield.virtual.scene_files import scene_from_text
from skinfield.virtual.schedule import NEVER
from skinfield.virtual.settings import VirtualSettings
from skinfield.virtual.touch import Touch
from skinfield.virtual.truth import Truth
from skinfield.virtual.world import World

LONGEST_WAIT = 0.05  # s: how often it looks for signals and for tables that are solved
SECOND = 1_000_000_000


class VirtualSkin:
    """A skin of boards that does not exist, on a real bus.

    Parameters
    ----------
    settings : VirtualSettings

    Attributes
    ----------
    skin : Skin
    hardware : Hardware
    world : World
    truth : Truth

    Raises
    ------
    InputError
        If a setting cannot be used, or an address is taken.
    """

    def __init__(self, settings: VirtualSettings) -> None:
        self.settings = settings
        self.skin = skin_from_text(settings.skin)
        scene = scene_from_text(settings.scene, self.skin, settings.seed)
        self.world = World(self.skin, settings.layer, scene)
        self.hardware: Hardware = open_hardware(self.skin, settings)
        self._control: Control | None = None
        self._ended = False
        self.notes: list[str] = []
        self.started_ns = time.time_ns()
        self.stream_ns = 0  # when the first reading was sent
        self._scene_ns = 0
        self._pressing: list[Touch] = []
        self._slow_ns = 0
        try:
            self.faults = FaultClock(self.skin, self.hardware)
            for fault in settings.faults:
                self.faults.add(fault)
            if settings.control:
                self._control = Control(settings.control, commands_of(self))
            self.truth = Truth(self.skin, settings.truth)
        except BaseException:
            self.hardware.close()
            self.world.close()
            raise
        self._update(time.time_ns())
        self.hardware.start(time.time_ns())

    @property
    def control_address(self) -> str:
        """Where the control socket is; empty without one."""
        return self._control.address if self._control is not None else ""

    def time(self, now_ns: int) -> float:
        """Seconds since the stream began; negative before."""
        return (now_ns - self.stream_ns) / SECOND if self.stream_ns else -1.0

    def warmth(self, now_ns: int) -> float:
        """K above 25 °C."""
        return self.settings.temperature.warmth(max(self.time(now_ns), 0.0))

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
        self.hardware.schedule.begin(time.time_ns())
        begun = told = time.monotonic()
        self.notes += ask_for_priority(self.settings.priority)
        while not self._ended:
            if self._wait(watched) & watched:
                break
            now_ns = time.time_ns()
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
        wait = (self.hardware.schedule.next_ns - time.time_ns()) / SECOND
        ready = set(select.select(descriptors, [], [], min(max(wait, 0.0), LONGEST_WAIT))[0])
        if self._control is not None and self._control.fileno() in ready:
            self._control.poll()
        if ready.intersection(self.hardware.filenos()):
            now_ns = time.time_ns()
            self.hardware.listen(now_ns, self.warmth(now_ns))
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
        self._update(now_ns - int(self.settings.wires.delay * SECOND))
        self.hardware.converters.convert(self.warmth(now_ns))
        for group in due:
            self.hardware.send(group.members, now_ns)

    def _update(self, moment_ns: int) -> None:
        """Bring what the taxels read to a moment."""
        scene = (moment_ns - self._scene_ns) / SECOND if self._scene_ns else -1.0
        touches = self.world.update(scene, self.hardware.converters.change)
        if touches is not None:
            self._pressing = [touch for touch, _ in touches]
            self.truth.note(touches, moment_ns)
        else:
            self.truth.settle(moment_ns)

    @property
    def pressing(self) -> list[Touch]:
        """What presses now."""
        return self._pressing

    def play(self, text: str) -> None:
        """Play another scene, from its beginning.

        Raises
        ------
        InputError
            If there is none such.
        """
        scene = scene_from_text(text, self.skin, self.settings.seed)
        self.world.play(scene)
        if self.stream_ns:
            self._scene_ns = time.time_ns()

    def counts(self) -> dict[str, Any]:
        """What was sent, and what was done to it, so far."""
        now_ns = time.time_ns()
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

    def set_wires(self, given: Mapping[str, Any]) -> dict[str, float]:
        """Change probabilities of losing, doubling and swapping from now on."""
        chances = dict(self.hardware.chances)
        for name in chances:
            if name in given:
                value = given[name]
                plain = isinstance(value, int | float) and not isinstance(value, bool)
                if not plain or not 0.0 <= value <= 1.0:
                    raise InputError(f"{name} is {value!r:.60}, expected a probability, 0 to 1")
                chances[name] = float(value)
        self.hardware.set_chances(chances["lose"], chances["duplicate"], chances["swap"])
        return chances

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
