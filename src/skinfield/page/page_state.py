"""State of the page that all browsers share: scene layout, status, notices, and the work beside."""

import asyncio
import threading
import time
from collections import deque
from collections.abc import Awaitable, Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from pathlib import PurePath
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

from skinfield.errors import SkinfieldError
from skinfield.loop.snapshot import Snapshot
from skinfield.loop.status_text import preparing_of
from skinfield.page.contact_shapes import ShapeProcesses
from skinfield.page.controller import Controller
from skinfield.page.scene_layout import SceneLayout
from skinfield.page.source import DataSource

LOOK = 0.25  # s between looks at what runs
SLOW = 2  # looks from status to status
NOTICES = 20  # that a browser which comes later still gets
PREPARES = 60.0  # s
RETRY = 10.0  # s from one preparation of a source to the next
TRUTH = 0.03  # s between questions for the truth
RECENT = 60.0  # s for which it is told that an engine failed
LATE = 0.01  # of the cycles late lately, from which on it matters that real time was refused
TOLD = ("failed", "hung")  # events of the supervisor
NOT_TOLD = "too rarely to tell a dead one from a quiet one"  # of taxels that nothing is wrong with
T = TypeVar("T")


def without_paths(status: dict[str, Any]) -> dict[str, Any]:
    """The status of an engine; where on its machine it records is nobody else's business."""
    beside = status.get("beside") or {}
    recorder = beside.get("recorder") or {}
    if "path" not in recorder:
        return status
    recorder = {**recorder, "path": PurePath(recorder["path"]).name}
    return {**status, "beside": {**beside, "recorder": recorder}}


def viewer_notes(status: Mapping[str, Any], simulated: bool) -> list[str]:
    """What `Status.as_dict` tells that a viewer can act on, in sentences.

    The rest is told by `skinfield status`.

    Parameters
    ----------
    status : mapping
        Of one engine.
    simulated : bool
        Whether its skin is virtual: made without a baseline that could be better.
    """
    notes = status.get("notes") or {}
    if isinstance(notes, list):  # of an engine that cannot be asked
        return [str(each) for each in notes]
    supervisor = (status.get("beside") or {}).get("supervisor") or {}
    since = time.time_ns() - RECENT * 1e9
    said = [
        f"the engine {text}"
        for stamp, what, text in supervisor.get("events", [])
        if what in TOLD and stamp >= since
    ][-3:]
    said += [str(notes[name]) for name in ("failed", "remote", "pace") if notes.get(name)]
    said += [*str(notes.get("replay", "")).split("; ")[1:], *notes.get("damage", [])]
    readings = (notes.get("readings") or {}).items()
    said += [f"{patch}: {text}" for patch, texts in readings for text in texts]
    if searching := notes.get("searching"):
        said.append(f"{', '.join(searching)}: searches do not end in time, a longer deadline helps")
    made = tuple(f"{patch['name']}:" for patch in status.get("patches", []) if simulated)
    tare = [text for text in notes.get("tare") or [] if NOT_TOLD not in text]
    said += [text for text in tare if not text.startswith(made)]
    lately = status.get("lately") or {}
    if lately.get("late", 0) > LATE * max(lately.get("cycles", 0), 1):
        said += (notes.get("granted") or {}).get("refused") or []
    return list(dict.fromkeys(said))


class PageState:
    """What all browsers of a page share.

    Parameters
    ----------
    sources : function that returns a sequence of DataSource
        Called again and again: engines come and go. The same sources must be the same objects.
    controller : Controller
    """

    def __init__(self, sources: Callable[[], Sequence[DataSource]], controller: Controller) -> None:
        self.controller = controller
        self._sources = sources
        self.updates = self.octets = 0  # sent to all browsers
        self._counted = (time.monotonic(), 0, 0)
        self.layout = SceneLayout(())
        self.status: dict[str, Any] = {"state": "starting", "engines": []}
        self.status_number = 0
        self.controller_hello, self.controls = controller.hello(), controller.controls()
        self.looking_on = Controller().controls()
        self.truth: Sequence[Any] = ()
        self.notices: deque[tuple[int, str, str]] = deque(maxlen=NOTICES)
        self._noted = self._turn = 0
        self.opened: list[DataSource] = []  # recordings, each looked at by one browser
        self._tried: WeakKeyDictionary[DataSource, float] = WeakKeyDictionary()
        self.sessions = 0
        self.shapes = ShapeProcesses()
        self._update_pool = ThreadPoolExecutor(1, "page-updates")
        self._command_pool = ThreadPoolExecutor(1, "page-commands")
        self._query_pool = ThreadPoolExecutor(1, "page-queries")
        self._preparing: threading.Thread | None = None

    def shut_down(self) -> None:
        """End the pools, once nothing is served any more."""
        self._query_pool.submit(self.shapes.close).result()
        for pool in (self._update_pool, self._command_pool, self._query_pool):
            pool.shutdown(wait=True, cancel_futures=True)

    async def update_work(self, function: Callable[..., T], *arguments: Any) -> T:
        """Call what makes updates, beside the loop; one at a time, as they share what they use."""
        return await asyncio.wrap_future(self._update_pool.submit(function, *arguments))

    async def command_work(self, function: Callable[[], T]) -> T:
        """Call what a command needs, beside the loop; one after the other."""
        return await asyncio.wrap_future(self.submit(function))

    def submit(self, function: Callable[[], T]) -> Future[T]:
        """As `command_work`, for what somebody must close though nobody waits for it any more."""
        return self._command_pool.submit(function)

    async def _query(self, function: Callable[[], T]) -> T:
        return await asyncio.wrap_future(self._query_pool.submit(function))

    def tasks(self) -> list[asyncio.Task[None]]:
        """What keeps it up to date, begun in the running loop."""
        return [
            asyncio.create_task(self._repeat("the page", self._watch, LOOK)),
            asyncio.create_task(self._repeat("the virtual skin", self._query_truth, TRUTH)),
        ]

    async def _repeat(self, what: str, turn: Callable[[], Awaitable[None]], pause: float) -> None:
        """Do something again and again; where it fails, that is said once, and it is tried on."""
        noted = ""
        while True:
            try:
                await turn()
                noted = ""
            except Exception as error:
                known = isinstance(error, SkinfieldError)
                why = f"{what}: {error}" if known else f"{what}: {type(error).__name__}: {error}"
                if why != noted:
                    self._notice("error", why)
                noted = why
            await asyncio.sleep(pause)

    def _notice(self, level: str, text: str) -> None:
        self._noted += 1
        self.notices.append((self._noted, level, text))

    async def _watch(self) -> None:
        sources = await self._query(self._sources)
        if tuple(sources) != self.layout.sources:
            self.layout = await self.update_work(SceneLayout, sources)
        if self._turn % SLOW == 0:
            self.status = await self._query(self._look)
            self.status_number += 1
        self._turn += 1
        await self.refresh()
        for level, text in self.controller.notices():
            self._notice(level, text)
        for text in await self._query(lambda: self.shapes.tend(self.layout.sources)):
            self._notice("warn", text)
        await self._query(self._prepare)

    async def refresh(self) -> None:
        """Ask for what may have changed by a command."""
        self.controls = await self._query(self.controller.controls)
        hello = await self._query(self.controller.hello)
        if hello != self.controller_hello:
            self.controller_hello = hello
            self.layout = await self.update_work(SceneLayout, self.layout.sources)

    async def _query_truth(self) -> None:
        if self.sessions or self.truth:
            self.truth = await self._query(self.controller.truth)

    def _look(self) -> dict[str, Any]:
        """What all engines say of themselves, and the page."""
        engines = []
        for source in self.layout.sources:
            try:
                status = without_paths(source.status())
                told = viewer_notes(status, self.controller.presser is not None)
                engines.append({**status, "viewer_notes": told})
            except SkinfieldError as error:
                engines.append({"name": source.name, "state": "failed", "notes": [str(error)]})
        states = {each["state"] for each in engines}
        one = states.pop() if len(states) == 1 else ("mixed" if states else "starting")
        notes = [each["notes"] for each in engines if isinstance(each.get("notes"), dict)]
        preparing = min(
            filter(None, map(preparing_of, notes)), key=lambda its: its["done"], default=None
        )
        rates = self._rates()
        return {"state": one, "engines": engines, "preparing": preparing, "page": rates}

    def _rates(self) -> dict[str, Any]:
        """What was sent to all browsers, per second since the last look."""
        before, now = self._counted, (time.monotonic(), self.updates, self.octets)
        self._counted, seconds = now, max(now[0] - before[0], 1e-9)
        return {
            "clients": self.sessions,
            "updates_per_s": (now[1] - before[1]) / seconds,
            "bytes_per_s": (now[2] - before[2]) / seconds,
        }

    def _prepare(self) -> None:
        """See that deformation and uncertainty get prepared, beside everything else."""
        if self._preparing is not None and self._preparing.is_alive():
            return
        now = time.monotonic()
        for source in (*self.layout.sources, *self.opened):
            if now - self._tried.get(source, -PREPARES) < RETRY:
                continue  # others may be prepared meanwhile
            with suppress(SkinfieldError):
                snapshot = source.latest()
                if snapshot is not None and not snapshot.prepared and snapshot.stamp_ns:
                    self._tried[source] = now
                    self._preparing = threading.Thread(
                        target=_prepare, args=(snapshot,), name="prepare", daemon=True
                    )
                    self._preparing.start()
                    return

    def wait_prepared(self) -> None:
        """Wait for a preparation that goes on: an interpreter that ends below it would crash."""
        if self._preparing is not None:
            self._preparing.join(PREPARES)


def _prepare(snapshot: Snapshot) -> None:
    """What is not there cannot be prepared, and the page says so by what it lacks."""
    with suppress(SkinfieldError):
        snapshot.prepare()
