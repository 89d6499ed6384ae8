"""Presses of a virtual skin from the page."""

import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any, NamedTuple, Protocol

from skinfield.emulator.scenes import FRICTION, PUSHED
from skinfield.errors import InputError, check_choice, check_range

SHAPES = ("ball", "flat", "finger", "L", "T")
COMMON = {  # radii, m, of tools that are ready before anybody asks for them
    "ball": (5e-3, 10e-3, 20e-3),
    "flat": (3e-3, 6e-3),
    "finger": (10e-3,),
    "L": (8e-3,),
    "T": (8e-3,),
}
RADII = (1e-3, 20e-3)  # m
FORCES = (0.05, 5.0)  # N
TOOL_RADIUS, TOOL_FORCE = 10e-3, 1.0  # m, N: that the page begins with
SCENES = ("idle", "press", "slide", "two-balls", "tap", "random")
IDLE = "idle"
MOST = 16  # presses by hand
LOOK = 0.05  # s
NO_VIRTUAL = "a real skin is pressed by hand: only a virtual one can be pressed from here"


class PressRequest(NamedTuple):
    """Where and how a virtual skin is to be pressed.

    Attributes
    ----------
    id : str
    patch : str
    x, y : float, m
        In the patch's plane.
    force : float, N, or None
        None: as before.
    radius : float, m, or None
    shape : str
    shear : (x, y), N, or None
        Along the skin, in the patch's plane; more than friction holds is taken for what it holds.
    """

    id: str
    patch: str
    x: float
    y: float
    force: float | None = None
    radius: float | None = None
    shape: str = "ball"
    shear: tuple[float, float] | None = None


def _held(press: PressRequest) -> tuple[float, float]:
    """What of a push friction holds, N; none of a body that is not pushed."""
    x, y = press.shear or (0.0, 0.0)
    size, most = math.hypot(x, y), FRICTION * (press.force or 0.0)
    if size == 0.0 or press.shape not in PUSHED:
        return 0.0, 0.0
    part = min(1.0, most / size)
    return x * part, y * part


class Virtual(Protocol):
    """A virtual skin: `skinfield.emulator.process.VirtualProcess`."""

    def ask(self, command: dict[str, Any]) -> dict[str, Any]:
        """Obey a command, or raise InputError."""
        ...


class Presser:
    """Presses a virtual skin; not before its engine has a baseline, which a press would spoil.

    May be called from any thread.

    Parameters
    ----------
    virtual : Virtual
    waits_for : function
        Says in words what has to end before anything may press; nothing: it may.
    say : function
        Takes a sentence about a press that could not be.
    """

    def __init__(
        self, virtual: Virtual, waits_for: Callable[[], str], say: Callable[[str], None]
    ) -> None:
        self._virtual, self._waits_for, self._say = virtual, waits_for, say
        self._lock = threading.RLock()
        self.playing = IDLE
        self.preparing = False  # whether a tool is being solved
        self._presses: dict[str, PressRequest] = {}
        self._waiting: set[str] = set()
        self._noted: list[str] = []

    def offer(self) -> dict[str, Any]:
        """What the page offers."""
        radius, force = [*RADII, TOOL_RADIUS], [*FORCES, TOOL_FORCE]
        return {
            "shapes": SHAPES,
            "radius": radius,
            "force": force,
            "scenes": SCENES,
            "common": COMMON,
            "friction": FRICTION,
        }

    def tools(self) -> dict[str, Any]:
        """Tools that press at once, and those being prepared."""
        reply = self._virtual.ask({"do": "tools"})
        return {name: reply.get(name, []) for name in ("ready", "preparing")}

    def prepare_common(self) -> None:
        """Somebody may press soon: have the common tools ready, the smallest of a shape first."""
        for shape in COMMON:
            for radius in reversed(COMMON[shape]):  # the last that is asked for comes first
                self.prepare(shape, radius)

    def prepare(self, shape: str, radius: float) -> dict[str, Any]:
        """Have a tool ready before it presses.

        Raises
        ------
        InputError
            For a tool that there is none of.
        """
        check_range("radius", radius, *RADII, "metres")
        check_choice("shape", shape, SHAPES, "what presses")
        return self._virtual.ask({"do": "prepare", "shape": shape, "radius": radius})

    @property
    def placed(self) -> int:
        """Presses by hand."""
        return len(self._presses)

    def truth(self) -> Sequence[Mapping[str, Any]]:
        """What presses now; says of presses that the skin let go why."""
        with self._lock:
            reply = self._virtual.ask({"do": "truth"})
            self.preparing = bool(reply.get("waits"))
            notes = list(reply.get("notes", ()))
            for note in notes:
                if note not in self._noted:
                    self._let_go(note)
            self._noted = notes
        lines = reply["lines"]
        return lines[-1]["presses"] if lines else ()

    def _let_go(self, note: str) -> None:
        for id in [each for each in self._presses if f"press {each} " in note]:
            del self._presses[id]
            note = note.replace(f"press {id} ", "a press ")  # its name is the page's own
        self._say(note)

    def press(self, press: PressRequest) -> dict[str, Any]:
        """Begin a press, or change it; a scene ends with the first one by hand.

        Raises
        ------
        InputError
            For a tool that there is none of, or a force that is too hard for it.
        """
        with self._lock:
            done = self._whole(press)
            if done.id not in self._presses and len(self._presses) >= MOST:
                raise InputError(f"{MOST} presses stand, expected fewer: lift some")
            place = {"patch": done.patch, "x": done.x, "y": done.y}
            why = self._waits_for()
            if why:
                self._presses[done.id] = done
                self._waiting.add(done.id)
                return {**place, "waits": why}
            if self.playing != IDLE:
                self._play(IDLE)
            self._do(done)
            self._presses[done.id] = done
            return place

    def _whole(self, press: PressRequest) -> PressRequest:
        """A press with what it does not say taken from before."""
        before = self._presses.get(press.id)
        if before is not None:
            press = press._replace(
                force=before.force if press.force is None else press.force,
                shape=before.shape if press.radius is None else press.shape,
                radius=before.radius if press.radius is None else press.radius,
                shear=before.shear if press.shear is None else press.shear,
            )
        if press.force is None or press.radius is None:
            raise InputError(f"press {press.id!r} is new, expected its force and radius")
        check_range("force", press.force, *FORCES, "newtons")
        check_range("radius", press.radius, *RADII, "metres")
        check_choice("shape", press.shape, SHAPES, "what presses")
        return press._replace(shear=_held(press))

    def _do(self, press: PressRequest) -> None:
        self._virtual.ask({"do": "press", **press._asdict()})

    def do_waiting(self) -> None:
        """Press what had to wait, if it need not any more; what is refused is reported."""
        with self._lock:
            if not self._waiting or self._waits_for():
                return
            if self.playing != IDLE:
                self._play(IDLE)
            for id in sorted(self._waiting):
                try:
                    self._do(self._presses[id])
                except InputError as error:
                    del self._presses[id]
                    self._say(f"a press that waited could not be: {error}")
            self._waiting.clear()

    def lift(self, id: str | None) -> dict[str, Any]:
        """Lift off a press, or all; of one that is gone already nothing is left to do."""
        with self._lock:
            if id is None:
                self._presses.clear()
                self._waiting.clear()
                self._virtual.ask({"do": "release", "id": None})
            elif self._presses.pop(id, None) is not None:
                if id not in self._waiting:
                    with suppress(InputError):  # the skin let it go itself
                        self._virtual.ask({"do": "release", "id": id})
                self._waiting.discard(id)
        return {}

    def leave(self, browser: str) -> None:
        """Lift off all presses whose ids begin so."""
        with self._lock:
            for id in [each for each in self._presses if each.startswith(browser)]:
                self.lift(id)

    def begin(self, scene: str) -> None:
        """Play a scene, by name or from a file, unless somebody presses by hand already."""
        with self._lock:
            if not self._presses:
                self._play(scene)

    def scene(self, name: str) -> dict[str, Any]:
        """Play one of `SCENES`.

        Raises
        ------
        InputError
            While nothing may press.
        """
        check_choice("scene", name, SCENES, "what presses by itself")
        with self._lock:
            if name != IDLE and (why := self._waits_for()):
                raise InputError(f"scene is {name!r}, expected it later: {why}")
            self._play(name)
        return {}

    def _play(self, scene: str) -> None:
        self._virtual.ask({"do": "scene", "scene": scene})
        self.playing = scene

    def let_off(self, patience: float) -> bool:
        """End the scene and wait until nothing presses; whether that is so."""
        with self._lock:
            if self.playing != IDLE:
                self._play(IDLE)
        end = time.monotonic() + patience
        while self.truth():
            if time.monotonic() > end:
                return False
            time.sleep(LOOK)
        return True
