"""The page's server: one port for the page, its socket, and plain JSON."""

import asyncio
import threading
import time
from collections import deque
from collections.abc import Awaitable, Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

from skinfield.errors import InputError, SkinfieldError
from skinfield.viewer.answers import Answers
from skinfield.viewer.desk import Desk
from skinfield.viewer.feed import Feed
from skinfield.viewer.meter import Meter
from skinfield.viewer.session import Session
from skinfield.viewer.settings import PageSettings
from skinfield.viewer.stage import Stage
from skinfield.viewer.told import without_paths

CLIENTS = 16
LARGEST = 1 << 16  # bytes of an order
LOOK = 0.25  # s between looks at what runs
SLOW = 2  # looks from status to status
STARTS = 20.0  # s for a server to be there
KEPT = 20  # notices
PREPARES = 60.0  # s
AGAIN = 10.0  # s from one preparation of a feed to the next
TRUTH = 0.03  # s between questions for the truth
T = TypeVar("T")


class Page:
    """A page that is served; made by `serve_page`.

    Parameters
    ----------
    settings : PageSettings
    feeds : function that returns a sequence of Feed
        Asked again and again: engines come and go. The same feeds must be the same objects.
    desk : Desk

    Attributes
    ----------
    port : int
        That it is served on.
    """

    def __init__(
        self, settings: PageSettings, feeds: Callable[[], Sequence[Feed]], desk: Desk
    ) -> None:
        self.settings, self.desk = settings, desk
        self._feeds = feeds
        self.port = 0
        self.meter = Meter()
        self.stage = Stage(())
        self.status: dict[str, Any] = {"state": "starting", "engines": []}
        self.status_number = 0
        self.desk_hello, self.controls = desk.hello(), desk.controls()
        self.looking_on = Desk().controls()
        self.truth: Sequence[Any] = ()
        self.notices: deque[tuple[int, str, str]] = deque(maxlen=KEPT)
        self._noted = self._turn = 0
        self._tried: dict[str, float] = {}
        self.sessions = 0
        self._made = 0
        self._work = ThreadPoolExecutor(1, "page-updates")
        self._orders = ThreadPoolExecutor(1, "page-orders")
        self._asks = ThreadPoolExecutor(1, "page-asks")
        self._stop: asyncio.Event | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._preparing: threading.Thread | None = None
        self._failed: BaseException | None = None

    @property
    def address(self) -> str:
        """To open in a browser."""
        wide = self.settings.host in ("0.0.0.0", "::", "")
        host = "127.0.0.1" if wide else self.settings.host.strip("[]")
        shown = f"[{host}]" if ":" in host else host
        token = f"?token={self.settings.token}" if self.settings.token else ""
        return f"http://{shown}:{self.port}/{token}"

    async def worked(self, function: Callable[..., T], *arguments: Any) -> T:
        """Call what makes updates, beside the loop; one at a time, as they share what they use."""
        return await asyncio.get_running_loop().run_in_executor(self._work, function, *arguments)

    async def ordered(self, function: Callable[[], T]) -> T:
        """Call what an order needs, beside the loop; one after the other."""
        return await asyncio.get_running_loop().run_in_executor(self._orders, function)

    def begun(self, function: Callable[[], T]) -> Future[T]:
        """As `ordered`, for what somebody must close though nobody waits for it any more."""
        return self._orders.submit(function)

    async def _asked(self, function: Callable[[], T]) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._asks, function)

    # in a thread of its own

    def run(self, ready: threading.Event) -> None:
        """Serve until `end`."""
        try:
            asyncio.run(self._run(ready))
        except BaseException as error:
            self._failed = error
        finally:
            ready.set()
            for pool in (self._work, self._orders, self._asks):
                pool.shutdown(wait=True, cancel_futures=True)

    async def _run(self, ready: threading.Event) -> None:
        self._stop, self._loop = asyncio.Event(), asyncio.get_running_loop()
        server = await self._bound()
        self.port = next(iter(server.sockets)).getsockname()[1]
        tasks = [
            asyncio.create_task(self._again("the page", self._watch, LOOK)),
            asyncio.create_task(self._again("the virtual skin", self._ask_truth, TRUTH)),
        ]
        ready.set()
        try:
            stopping = asyncio.create_task(self._stop.wait())
            await asyncio.wait([stopping, *tasks], return_when=asyncio.FIRST_COMPLETED)
            for task in tasks:
                if task.done():
                    task.result()
        finally:
            for task in tasks:
                task.cancel()
            server.close()
            await server.wait_closed()

    async def _bound(self) -> Any:
        from websockets.asyncio.server import serve

        answers, settings, why = Answers(self), self.settings, ""
        for port in (settings.port, 0) if settings.other_port else (settings.port,):
            try:
                return await serve(
                    self._client,
                    settings.host.strip("[]"),
                    port,
                    process_request=answers.answer,
                    compression=None,  # numbers hardly shrink, and it would cost more than they do
                    max_size=LARGEST,
                    max_queue=64,
                    write_limit=1 << 18,
                    server_header=None,
                )
            except OSError as error:
                why = str(error)
        raise InputError(
            f"port {settings.port} of {settings.host} cannot be served ({why}), expected an "
            "address of this machine and a port that is free: give another --port, or 0"
        )

    async def _client(self, socket: Any) -> None:
        if self.sessions >= CLIENTS:
            await socket.close(1013, f"{CLIENTS} browsers look on already")
            return
        self.sessions += 1
        self._made += 1
        try:
            await Session(self, socket, self._made).run()
        finally:
            self.sessions -= 1

    # what all browsers are told

    async def _again(self, what: str, turn: Callable[[], Awaitable[None]], pause: float) -> None:
        """Do something again and again; where it fails, that is told once, and it is tried on."""
        told = ""
        while True:
            try:
                await turn()
                told = ""
            except Exception as error:
                known = isinstance(error, SkinfieldError)
                why = f"{what}: {error}" if known else f"{what}: {type(error).__name__}: {error}"
                if why != told:
                    self._notice("error", why)
                told = why
            await asyncio.sleep(pause)

    def _notice(self, level: str, text: str) -> None:
        self._noted += 1
        self.notices.append((self._noted, level, text))

    async def _watch(self) -> None:
        feeds = await self._asked(self._feeds)
        if tuple(feeds) != self.stage.feeds:
            self.stage = await self.worked(Stage, feeds)
        if self._turn % SLOW == 0:
            self.status = await self._asked(self._look)
            self.status_number += 1
        self._turn += 1
        await self.look_again()
        for level, text in self.desk.notices():
            self._notice(level, text)
        await self._asked(self._prepare)

    async def look_again(self) -> None:
        """Ask for what may have changed by an order."""
        self.controls = await self._asked(self.desk.controls)
        hello = await self._asked(self.desk.hello)
        if hello != self.desk_hello:
            self.desk_hello = hello
            self.stage = await self.worked(Stage, self.stage.feeds)

    async def _ask_truth(self) -> None:
        if self.sessions or self.truth:
            self.truth = await self._asked(self.desk.truth)

    def _look(self) -> dict[str, Any]:
        """What all engines say of themselves, and the page."""
        engines = []
        for feed in self.stage.feeds:
            try:
                engines.append(without_paths(feed.status()))
            except SkinfieldError as error:
                engines.append({"name": feed.name, "state": "failed", "notes": [str(error)]})
        states = {each["state"] for each in engines}
        one = states.pop() if len(states) == 1 else ("mixed" if states else "starting")
        return {"state": one, "engines": engines, "page": self.meter.look(self.sessions)}

    def _prepare(self) -> None:
        """See that deformation and uncertainty get prepared, beside everything else."""
        if self._preparing is not None and self._preparing.is_alive():
            return
        now = time.monotonic()
        for feed in self.stage.feeds:
            if now - self._tried.get(feed.name, -PREPARES) < AGAIN:
                continue  # others may be prepared meanwhile
            with suppress(SkinfieldError):
                snapshot = feed.latest()
                if snapshot is not None and not snapshot.prepared and snapshot.stamp_ns:
                    self._tried[feed.name] = now
                    name = f"prepare-{feed.name}"
                    self._preparing = threading.Thread(
                        target=_quietly, args=(snapshot.prepare,), name=name, daemon=True
                    )
                    self._preparing.start()
                    return

    def end(self) -> None:
        """Stop serving; from another thread."""
        loop, stop = self._loop, self._stop
        if loop is not None and stop is not None:
            with suppress(RuntimeError):  # it has ended already
                loop.call_soon_threadsafe(stop.set)

    def wait_prepared(self) -> None:
        """Wait for a preparation that goes on: an interpreter that ends below it would crash."""
        if self._preparing is not None:
            self._preparing.join(PREPARES)

    def check(self) -> None:
        """Raise what serving failed with, if it did."""
        if self._failed is not None:
            raise self._failed


def _quietly(function: Callable[[], None]) -> None:
    """Call it; what is not there cannot be prepared, and the page says so by what it lacks."""
    with suppress(SkinfieldError):
        function()


@contextmanager
def serve_page(
    settings: PageSettings, feeds: Callable[[], Sequence[Feed]], desk: Desk | None = None
) -> Iterator[Page]:
    """Serve the page from a thread as long as the block lasts.

    Raises
    ------
    InputError
        If the port is taken, or may not be used.
    """
    page = Page(settings, feeds, Desk() if desk is None else desk)
    ready = threading.Event()
    thread = threading.Thread(target=page.run, args=(ready,), name="page", daemon=True)
    thread.start()
    try:
        if not ready.wait(STARTS):
            raise InputError(f"the page was not there within {STARTS:g} s: is the machine busy?")
        page.check()
        yield page
    finally:
        page.end()
        thread.join(STARTS)
        page.wait_prepared()
