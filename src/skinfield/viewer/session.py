"""One browser: what it is sent, and what it orders."""

import asyncio
import contextlib
import json
import time
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from skinfield.errors import InputError, SkinfieldError
from skinfield.viewer.orders import flag, number, press_of, text
from skinfield.viewer.stage import Stage
from skinfield.viewer.updates import Seen, Updates
from skinfield.viewer.wire import VERSION

if TYPE_CHECKING:
    from concurrent.futures import Future

    from websockets.asyncio.server import ServerConnection

    from skinfield.viewer.feed import Feed
    from skinfield.viewer.page import Page

LOOK = 0.008  # s between looks for something new
SHORTEST = 1 / 40  # s from one update to the next
STILL = 0.5  # s after which an update comes though nothing is new: ages grow
TELL = 0.5  # s from status to status
ORDERS = 32  # of a browser that are not answered yet
PRESSES = ("press", "move", "lift")  # may come with every movement of a pointer
Given = Mapping[str, Any]


class Session:
    """See the module; made for every connection.

    Parameters
    ----------
    page : Page
    socket : ServerConnection
    number : int
        Of the browser.
    """

    def __init__(self, page: "Page", socket: "ServerConnection", number: int) -> None:
        self._page, self._socket, self._number = page, socket, number
        self._replay: Any = page.desk.shared  # a recording that this browser looks at
        self._stage: Stage | None = None
        self._updates = Updates(Stage(()))
        self._awaited = 0  # number of the update that is in flight; 0: none
        self._count = 0
        self._last: tuple[Any, ...] = ()
        self._sent_at = self._told_at = 0.0
        self._controls = ""
        self._told_status = 0
        self._tasks: set[asyncio.Task[None]] = set()
        self._noted = page.notices[-1][0] if page.notices else 0

    async def run(self) -> None:
        """Talk and listen until the connection ends."""
        from websockets.exceptions import ConnectionClosed

        self._page.begun(self._page.desk.come)  # it is not waited for
        listening = asyncio.create_task(self._listen())
        try:
            while not listening.done():
                await self._talk()
                await asyncio.sleep(LOOK)
        except ConnectionClosed:
            pass
        finally:
            for task in self._tasks:
                task.cancel()
            listening.cancel()
            with contextlib.suppress(asyncio.CancelledError, ConnectionClosed):
                await listening
            try:
                await self._page.ordered(lambda: self._page.desk.leave(f"{self._number}-"))
            finally:
                await self._leave()

    # what is sent

    async def _send(self, message: str | bytes) -> None:
        self._page.meter.count(len(message))
        await self._socket.send(message)

    async def _tell(self, kind: str, **more: Any) -> None:
        await self._send(json.dumps({"kind": kind, **more}))

    async def _talk(self) -> None:
        """Whatever is due."""
        page = self._page
        if self._replay is page.desk.shared and self._stage is not page.stage:
            await self._begin(page.stage)
        controls = json.dumps(self._controls_now())
        if controls != self._controls:
            self._controls = controls
            await self._send(controls)
        now = time.monotonic()
        if now - self._told_at >= TELL and page.status_number != self._told_status:
            self._told_at, self._told_status = now, page.status_number
            await self._tell("status", **page.status)
        for place, level, words in [each for each in page.notices if each[0] > self._noted]:
            self._noted = place
            await self._tell("notice", level=level, text=words)
        if not self._awaited and now - self._sent_at >= SHORTEST:
            await self._update(now)

    async def _begin(self, stage: Stage) -> None:
        """Tell the page of another skin."""
        self._stage, quantity = stage, self._updates.quantity
        self._updates = Updates(stage)
        self._updates.show(quantity)
        self._awaited, self._last, self._controls = 0, (), ""
        await self._tell("hello", **self._hello(stage))

    def _hello(self, stage: Stage) -> dict[str, Any]:
        page, replay = self._page, self._replay
        told = {"wire": VERSION, "version": version("skinfield"), "patches": stage.told()}
        told |= {"name": stage.name, "size": stage.size}
        told |= page.desk_hello | {"mode": page.desk.mode, "replay": None}
        if replay is not None:
            span = {"start_s": replay.start_s, "end_s": replay.end_s}
            told |= {"mode": "replay", "press": None, "record": False}
            told["replay"] = span | {"events": [list(each) for each in replay.events]}
        return told

    def _controls_now(self) -> dict[str, Any]:
        told = {"kind": "controls", "quantity": self._updates.quantity, **self._page.controls}
        replay = self._replay
        if replay is not None:
            told |= self._page.looking_on
            told["replay"] = {"playing": replay.playing, "speed": replay.speed, "name": replay.name}
        return told

    async def _update(self, now: float) -> None:
        """Send what is new, if anything is; the next one only when this one is drawn."""
        updates = self._updates
        made = await self._page.worked(self._make, now - self._sent_at >= STILL)
        if not made or updates is not self._updates:  # of what is not looked at any more
            return
        self._sent_at, self._awaited = now, self._count
        for message in made:
            await self._send(message)
        self._page.meter.updates += 1

    def _make(self, anyhow: bool) -> list[bytes]:
        """The messages of an update; none if nothing is new."""
        stage, page, replay = self._updates.stage, self._page, self._replay
        seen: list[Seen]
        truth: Sequence[Given] = ()
        if replay is not None:
            seen = [replay.seen()]
        else:
            seen, truth = page.desk.seen(stage.feeds), page.truth
        numbers = [None if s.snapshot is None else s.snapshot.number for s in seen]
        state = (numbers, truth, self._updates.quantity)
        if state == self._last and not anyhow:
            return []
        self._last = state
        self._count += 1
        time_s = None if replay is None else replay.time_s
        return self._updates.make(self._count, seen, truth, time_s)

    # what is ordered

    async def _listen(self) -> None:
        async for message in self._socket:
            try:
                given = json.loads(message)
                if not isinstance(given, dict) or not isinstance(given.get("do"), str):
                    raise ValueError("no object with `do`")
            except (ValueError, RecursionError) as error:
                await self._tell("notice", level="error", text=f"not understood: {error}")
                continue
            if given["do"] == "ack":
                if given.get("number") == self._awaited:
                    self._awaited = 0
                continue
            task = asyncio.create_task(self._obey(given))  # what takes long must hold up no update
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)
            if len(self._tasks) >= ORDERS:
                await asyncio.wait(self._tasks, return_when=asyncio.FIRST_COMPLETED)

    async def _obey(self, given: Given) -> None:
        """Obey an order and answer it; the desk gets them in their order."""
        from websockets.exceptions import ConnectionClosed

        told: dict[str, Any] = {"tag": given.get("tag")}
        try:
            told |= {"ok": True, **await self._order(given["do"], given)}
        except SkinfieldError as error:
            told |= {"ok": False, "error": str(error)}
        except Exception as error:  # of a part that failed: that is told, and the page goes on
            told |= {"ok": False, "error": f"{type(error).__name__}: {error}"}
        with contextlib.suppress(ConnectionClosed):
            await self._tell("answer", **told)

    async def _order(self, do: str, given: Given) -> dict[str, Any]:
        page, desk = self._page, self._page.desk
        if do == "hello":
            return {}
        if do == "show":
            self._updates.show(given.get("quantity"))
            return {}
        if do == "replay":
            return await self._replay_order(given)
        if self._replay is not None:
            raise InputError(f"{do} is for a live skin, and this is a recording: go back to live")
        orders: dict[str, Callable[[], dict[str, Any]]] = {
            "set": lambda: desk.set(text(given, "what"), self._value(given)),
            "tare": desk.tare,
            "record": lambda: desk.record(flag(given, "on")),
            "press": lambda: desk.press(press_of(given, self._updates.stage, self._number)),
            "move": lambda: desk.press(press_of(given, self._updates.stage, self._number)),
            "lift": lambda: desk.lift(self._mine(given.get("id"))),
            "scene": lambda: desk.scene(text(given, "name")),
        }
        if do not in orders:
            raise InputError(f"do is {do[:40]!r}, expected one of {', '.join(orders)}")
        said = await page.ordered(orders[do])
        if do not in PRESSES:
            await page.look_again()
        return said

    def _mine(self, id: Any) -> str | None:
        return None if id is None else f"{self._number}-{id}"[:40]

    def _value(self, given: Given) -> Any:
        """The value of a setting; a window's patch by its name, for its engine."""
        value = given.get("value")
        if given.get("what") != "focus" or value is None:
            return value
        if not isinstance(value, dict):
            raise InputError(f"focus is {value!r:.80}, expected patch, low and high")
        return {**value, "patch": self._updates.stage[value.get("patch")].patch.name}

    async def _replay_order(self, given: Given) -> dict[str, Any]:
        page, what = self._page, text(given, "what")
        if what == "open":
            name = text(given, "value")
            opening = page.begun(lambda: page.desk.recording(name))
            try:
                opened = await asyncio.wrap_future(opening)
            except asyncio.CancelledError:  # the browser has gone, and nobody would close it
                opening.add_done_callback(_close_result)
                raise
            await self._leave()
            self._replay = opened
            await self._begin(Stage((opened,)))
            return {}
        replay = self._replay
        if replay is None:
            raise InputError(f"{what} is for a recording, and this is a live skin: open one first")
        if what == "close":
            if replay is page.desk.shared:
                raise InputError("there is no live skin here, only the recording that is shown")
            await self._leave()
            await self._begin(page.stage)
        elif what in ("play", "pause"):
            await page.ordered(getattr(replay, what))
        elif what == "seek":
            place = number(given, "value", replay.start_s, replay.end_s, "seconds of the recording")
            await page.ordered(lambda: replay.seek(place))
        elif what == "speed":
            speed = number(given, "value", 0.1, 10.0, "times its own")
            await page.ordered(lambda: replay.set_speed(speed))
        else:
            raise InputError(
                f"what is {what[:40]!r}, expected open, close, play, pause, seek, speed"
            )
        self._last = ()
        return {}

    async def _leave(self) -> None:
        """Let go of a recording that is looked at, if there is one."""
        shared = self._page.desk.shared
        replay, self._replay = self._replay, shared
        if replay is not shared:
            await self._page.ordered(replay.close)


def _close_result(opening: "Future[Feed]") -> None:
    if not opening.cancelled() and opening.exception() is None:
        opening.result().close()
