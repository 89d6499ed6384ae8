"""WebSocket session of one browser: what it is sent, and its commands, which are checked."""

import asyncio
import contextlib
import json
import time
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats, InputError, SkinfieldError, check_choice
from skinfield.page.page_state import PageState
from skinfield.page.presser import PressRequest
from skinfield.page.scene_layout import SceneLayout
from skinfield.page.source import EngineView
from skinfield.page.timeline import HEAD
from skinfield.page.updates import Updates
from skinfield.page.wire import VERSION

LONGEST = 200  # characters
FAR = 1e3  # m
Command = Mapping[str, Any]


def text(command: Command, key: str) -> str:
    """A text of a command; raises InputError."""
    value = command.get(key)
    if not isinstance(value, str) or not 0 < len(value) <= LONGEST:
        raise InputError(f"{key} is {value!r:.80}, expected text")
    return value


def flag(command: Command, key: str) -> bool:
    """Yes or no; raises InputError."""
    value = command.get(key)
    if not isinstance(value, bool):
        raise InputError(f"{key} is {value!r:.80}, expected true or false")
    return value


def number(command: Command, key: str, low: float, high: float, what: str) -> float:
    """A number between two bounds; raises InputError."""
    value = command.get(key)
    if not _is_number(value, low, high):
        raise InputError(f"{key} is {value!r:.80}, expected {low:g} to {high:g}: {what}")
    return float(value)  # type: ignore[arg-type]


def vector(command: Command, key: str, most: float, what: str) -> Floats:
    """Three numbers of the picture's frame; raises InputError."""
    value = command.get(key)
    if (
        not isinstance(value, list)
        or len(value) != 3
        or not all(_is_number(each, -most, most) for each in value)
    ):
        raise InputError(f"{key} is {value!r:.80}, expected three numbers in {what}")
    return np.array(value, float)


def press_of(command: Command, layout: SceneLayout, browser: int) -> PressRequest:
    """A press at a place of the picture; raises InputError."""
    placed = layout[command.get("patch")]
    place = vector(command, "position", FAR, "metres")
    x, y = placed.plane_of(place)
    force = None if "force" not in command else number(command, "force", 0.0, 100.0, "newtons")
    radius = None if "radius" not in command else number(command, "radius", 1e-4, 0.1, "metres")
    shape = text(command, "shape") if "shape" in command else "ball"
    shear = None
    if "shear" in command:
        shear = placed.along_of(vector(command, "shear", 100.0, "newtons"), x, y)
    name = f"{browser}-{text(command, 'id')}"[:40]
    return PressRequest(name, placed.patch.name, x, y, force, radius, shape, shear)


def _is_number(value: Any, low: float, high: float) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and low <= value <= high


if TYPE_CHECKING:
    from concurrent.futures import Future

    from websockets.asyncio.server import ServerConnection

    from skinfield.page.source import DataSource

LOOK = 0.008  # s between looks for something new
SHORTEST = 1 / 40  # s from one update to the next
STILL = 0.5  # s after which an update comes though nothing is new: ages grow
STATUS = 0.5  # s from status to status
SILENT = 20.0  # s without a word about an update, after which a browser loses its place
FULL, HUNG = 1013, 4008  # codes of ends that a page tells: no place, or lost it by silence
COMMANDS = 32  # of a browser that are not answered yet
ORDERS = ("open", "close", "play", "pause", "seek", "speed", "step", "loop", "contacts")
MOST_STEPS = 1000  # readings at once
PRESSES = ("press", "move", "lift")  # may come with every movement of a pointer


class Session:
    """See the module; made for every connection.

    Parameters
    ----------
    state : PageState
    socket : ServerConnection
    number : int
        Of the browser.
    """

    def __init__(self, state: PageState, socket: "ServerConnection", number: int) -> None:
        self._state, self._socket, self._number = state, socket, number
        self._replay: Any = state.controller.shared  # a recording that this browser looks at
        self._updates = Updates(SceneLayout(()))
        self._awaited = 0  # number of the update that is in flight; 0: none
        self._count = 0
        self._last: tuple[Any, ...] = ()
        self._sent_at = self._status_at = 0.0
        self._controls = ""
        self._status_number = 0
        self._outlined = False  # whether the timeline of the recording was sent
        self._tasks: set[asyncio.Task[None]] = set()
        self._noted = state.notices[-1][0] if state.notices else 0

    async def run(self) -> None:
        """Talk and listen until the connection ends."""
        from websockets.exceptions import ConnectionClosed

        if (recordings := self._state.controller.recordings) is not None:
            self._state.submit(recordings.prepare)  # it is not waited for
        if (presser := self._state.controller.presser) is not None:
            self._state.submit(presser.prepare_common)
        listening = asyncio.create_task(self._listen())
        try:
            while not listening.done():
                await self._talk()
                await asyncio.sleep(LOOK)
        except ConnectionClosed:
            pass
        finally:
            self._state.shapes.viewers.discard(self._number)
            for task in self._tasks:
                task.cancel()
            listening.cancel()
            with contextlib.suppress(asyncio.CancelledError, ConnectionClosed):
                await listening
            try:
                if (presser := self._state.controller.presser) is not None:
                    await self._state.command_work(lambda: presser.leave(f"{self._number}-"))
            finally:
                await self._close(self._replay)

    # what is sent

    async def _send(self, message: str | bytes) -> None:
        self._state.octets += len(message)
        await self._socket.send(message)

    async def _send_kind(self, kind: str, **more: Any) -> None:
        await self._send(json.dumps({"kind": kind, **more}, allow_nan=False))

    async def _talk(self) -> None:
        """Whatever is due."""
        state = self._state
        if self._replay is state.controller.shared and self._updates.layout is not state.layout:
            await self._begin(state.layout, self._replay)
        controls = json.dumps(self._controls_now(), allow_nan=False)
        if controls != self._controls:
            self._controls = controls
            await self._send(controls)
        now = time.monotonic()
        if now - self._status_at >= STATUS and state.status_number != self._status_number:
            self._status_at, self._status_number = now, state.status_number
            await self._send_kind("status", **state.status)
        for place, level, words in [each for each in state.notices if each[0] > self._noted]:
            self._noted = place
            await self._send_kind("notice", level=level, text=words)
        if not self._outlined and self._replay is not None and self._replay.timeline.told:
            self._outlined = True
            await self._send_kind("timeline", **self._replay.timeline.told)
        if self._awaited and now - self._sent_at > SILENT:
            await self._socket.close(HUNG, f"nothing was drawn here for {SILENT:g} s")
        elif not self._awaited and now - self._sent_at >= SHORTEST:
            await self._update(now)

    async def _begin(self, layout: SceneLayout, replay: Any) -> None:
        """Tell the page of another skin, or of a recording, and let go of the one before."""
        before, quantity = self._replay, self._updates.quantity
        self._replay, self._updates = replay, Updates(layout)
        self._updates.show(quantity)
        self._awaited, self._last, self._controls, self._outlined = 0, (), "", False
        await self._send_kind("hello", **self._hello(layout))
        if before is not replay:
            await self._close(before)

    def _hello(self, layout: SceneLayout) -> dict[str, Any]:
        state, replay = self._state, self._replay
        fields = {"wire": VERSION, "version": version("skinfield"), "patches": layout.describe()}
        fields |= {"name": layout.name, "size": layout.size, "columns": HEAD}
        fields |= state.controller_hello | {"mode": state.controller.mode, "replay": None}
        if replay is not None:
            span = {"start_s": replay.start_s, "end_s": replay.end_s}
            fields |= {"mode": "replay", "press": None, "record": False}
            fields["replay"] = span | {"events": [list(each) for each in replay.events]}
        return fields

    def _controls_now(self) -> dict[str, Any]:
        fields = {"kind": "controls", "quantity": self._updates.quantity, **self._state.controls}
        replay = self._replay
        if replay is not None:
            fields |= self._state.looking_on
            names = ("playing", "speed", "name", "loop")
            fields["replay"] = {name: getattr(replay, name) for name in names}
        return fields

    async def _update(self, now: float) -> None:
        """Send what is new, if anything is; the next one only when this one is drawn."""
        updates, replay = self._updates, self._replay  # may be others before it is made
        made = await self._state.update_work(
            self._make, updates, replay, now - self._sent_at >= STILL
        )
        if not made or updates is not self._updates:  # of what is not looked at any more
            return
        self._sent_at, self._awaited = now, self._count
        for message in made:
            if updates is not self._updates:  # another skin was told of meanwhile
                return
            await self._send(message)
        self._state.updates += 1

    def _make(self, updates: Updates, replay: Any, anyhow: bool) -> list[bytes]:
        """The messages of an update; none if nothing is new."""
        layout, state = updates.layout, self._state
        views: list[EngineView]
        truth: Sequence[Command] = ()
        if replay is not None:
            views = [EngineView(replay.latest())]
        else:
            views, truth = state.controller.views(layout.sources), state.truth
        numbers = [None if s.snapshot is None else s.snapshot.number for s in views]
        shapes = None
        if replay is None and self._number in state.shapes.viewers:
            shapes = state.shapes.newest(layout.sources)
        key = (numbers, [view.old for view in views], truth, updates.quantity)
        if key == self._last and not anyhow:
            return []
        self._last = key
        self._count += 1
        time_s = None if replay is None else replay.time_s
        return updates.make(self._count, views, truth, time_s, shapes)

    # what it commands

    async def _listen(self) -> None:
        async for message in self._socket:
            try:
                command = json.loads(message)
                if not isinstance(command, dict) or not isinstance(command.get("do"), str):
                    raise ValueError("no object with `do`")
            except (ValueError, RecursionError) as error:
                await self._send_kind("notice", level="error", text=f"not understood: {error}")
                continue
            if command["do"] == "ack":
                if command.get("number") == self._awaited:
                    self._awaited = 0
                continue
            # what takes long must hold up no update
            task = asyncio.create_task(self._obey(command))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)
            if len(self._tasks) >= COMMANDS:
                await asyncio.wait(self._tasks, return_when=asyncio.FIRST_COMPLETED)

    async def _obey(self, command: Command) -> None:
        """Obey a command and answer it; the controller gets them in their order."""
        from websockets.exceptions import ConnectionClosed

        fields: dict[str, Any] = {"tag": command.get("tag")}
        try:
            fields |= {"ok": True, **await self._run_command(command["do"], command)}
        except SkinfieldError as error:
            fields |= {"ok": False, "error": str(error)}
        except Exception as error:  # of a part that failed: that is answered, and the page goes on
            fields |= {"ok": False, "error": f"{type(error).__name__}: {error}"}
        with contextlib.suppress(ConnectionClosed):
            await self._send_kind("answer", **fields)

    async def _run_command(self, do: str, command: Command) -> dict[str, Any]:
        state, controller = self._state, self._state.controller
        if do == "hello":
            return {}
        if do == "show":
            self._updates.show(command.get("quantity"))
            return {}
        if do == "shapes":
            viewers = state.shapes.viewers
            (viewers.add if flag(command, "on") else viewers.discard)(self._number)
            return {}
        if do == "replay":
            return await self._replay_command(command)
        if self._replay is not None:
            raise InputError(f"{do} is for a live skin, and this is a recording: go back to live")
        commands: dict[str, Callable[[], dict[str, Any]]] = {
            "set": lambda: controller.set(text(command, "what"), self._value(command)),
            "tare": controller.tare,
            "record": lambda: controller.recording.record(flag(command, "on")),
            "press": lambda: controller.pressing.press(self._press(command)),
            "move": lambda: controller.pressing.press(self._press(command)),
            "lift": lambda: controller.pressing.lift(self._mine(command.get("id"))),
            "scene": lambda: controller.pressing.scene(text(command, "name")),
            "tool": lambda: controller.pressing.prepare(
                text(command, "shape"), number(command, "radius", 1e-4, 0.1, "metres")
            ),
        }
        if do not in commands:
            raise InputError(f"do is {do[:40]!r}, expected one of {', '.join(commands)}")
        reply = await state.command_work(commands[do])
        if do not in PRESSES:
            await state.refresh()
        return reply

    def _press(self, command: Command) -> PressRequest:
        return press_of(command, self._updates.layout, self._number)

    def _mine(self, id: Any) -> str | None:
        return None if id is None else f"{self._number}-{id}"[:40]

    def _value(self, command: Command) -> Any:
        """The value of a setting; a window's patch by its name, for its engine."""
        value = command.get("value")
        if command.get("what") != "focus" or value is None:
            return value
        if not isinstance(value, dict):
            raise InputError(f"focus is {value!r:.80}, expected patch, low and high")
        return {**value, "patch": self._updates.layout[value.get("patch")].patch.name}

    async def _replay_command(self, command: Command) -> dict[str, Any]:
        state, what = self._state, text(command, "what")
        if what == "open":
            name = text(command, "value")
            opening = state.submit(lambda: state.controller.recording.open(name))
            try:
                opened = await asyncio.wrap_future(opening)
            except asyncio.CancelledError:  # the browser has gone, and nobody would close it
                opening.add_done_callback(_close_result)
                raise
            state.opened.append(opened)
            await self._begin(SceneLayout((opened,)), opened)
            return {}
        replay = self._replay
        if replay is None:
            raise InputError(f"{what} is for a recording, and this is a live skin: open one first")
        check_choice("what", what, ORDERS, "an order")
        if what == "close":
            if replay is state.controller.shared:
                raise InputError("there is no live skin here, only the recording that is shown")
            await self._begin(state.layout, state.controller.shared)
        elif what in ("play", "pause"):
            await state.command_work(getattr(replay, what))
        elif what == "contacts":
            table = await asyncio.to_thread(replay.timeline.csv, replay.start_s, replay.end_s)
            return {"csv": table}
        elif what == "step":
            count = number(command, "value", -MOST_STEPS, MOST_STEPS, "readings")
            await state.command_work(lambda: replay.step(int(count)))
        elif what == "loop":
            on = flag(command, "value")
            await state.command_work(lambda: replay.set_loop(on))
        else:
            low, high = (replay.start_s, replay.end_s) if what == "seek" else (0.1, 10.0)
            place = number(command, "value", low, high, "s of the recording, or times its own pace")
            change = replay.seek if what == "seek" else replay.set_speed
            await state.command_work(lambda: change(place))
        self._last = ()
        return {}

    async def _close(self, replay: Any) -> None:
        """Let go of a recording that this browser alone looked at, if it is one."""
        if replay in self._state.opened:
            self._state.opened.remove(replay)
            await self._state.command_work(replay.close)


def _close_result(opening: "Future[DataSource]") -> None:
    if not opening.cancelled() and opening.exception() is None:
        opening.result().close()
