"""Server of the page: one port for its files, its socket, and plain JSON."""

import asyncio
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

from skinfield.errors import InputError
from skinfield.page.controller import Controller
from skinfield.page.http import HttpApi
from skinfield.page.page_state import PageState
from skinfield.page.scene_layout import SceneLayout
from skinfield.page.session import Session
from skinfield.page.source import DataSource
from skinfield.settings import PORT, PageSettings

CLIENTS = 16
LARGEST = 1 << 16  # bytes of a command
STARTS = 20.0  # s for a server to be there


class Page:
    """A page that is served; made by `serve_page`.

    Parameters
    ----------
    settings : PageSettings
    sources : function that returns a sequence of DataSource
    controller : Controller

    Attributes
    ----------
    port : int
        That it is served on.
    """

    def __init__(
        self,
        settings: PageSettings,
        sources: Callable[[], Sequence[DataSource]],
        controller: Controller,
    ) -> None:
        self.settings, self.controller = settings, controller
        self.port = 0
        self._state = PageState(sources, controller)
        self._made = 0  # sessions so far
        self._stop: asyncio.Event | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._failed: BaseException | None = None

    @property
    def layout(self) -> SceneLayout:
        """What the picture holds now."""
        return self._state.layout

    @property
    def address(self) -> str:
        """To open in a browser."""
        wide = self.settings.host in ("0.0.0.0", "::", "")
        host = "127.0.0.1" if wide else self.settings.host.strip("[]")
        shown = f"[{host}]" if ":" in host else host
        token = f"?token={self.settings.token}" if self.settings.token else ""
        return f"http://{shown}:{self.port}/{token}"

    # in a thread of its own

    def run(self, ready: threading.Event) -> None:
        """Serve until `end`."""
        try:
            asyncio.run(self._run(ready))
        except BaseException as error:
            self._failed = error
        finally:
            ready.set()
            self._state.shut_down()

    async def _run(self, ready: threading.Event) -> None:
        self._stop, self._loop = asyncio.Event(), asyncio.get_running_loop()
        server = await self._bound()
        self.port = next(iter(server.sockets)).getsockname()[1]
        tasks = self._state.tasks()
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

        api, settings, why = HttpApi(self._state, self.settings), self.settings, ""
        for port in (PORT, 0) if settings.port is None else (settings.port,):
            try:
                return await serve(
                    self._client,
                    settings.host.strip("[]"),
                    port,
                    process_request=api.answer,
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
        if self._state.sessions >= CLIENTS:
            await socket.close(1013, f"{CLIENTS} browsers look on already")
            return
        self._state.sessions += 1
        self._made += 1
        try:
            await Session(self._state, socket, self._made).run()
        finally:
            self._state.sessions -= 1

    def end(self) -> None:
        """Stop serving; from another thread."""
        loop, stop = self._loop, self._stop
        if loop is not None and stop is not None:
            with suppress(RuntimeError):  # it has ended already
                loop.call_soon_threadsafe(stop.set)

    def wait_prepared(self) -> None:
        """See `PageState`."""
        self._state.wait_prepared()

    def check(self) -> None:
        """Raise what serving failed with, if it did."""
        if self._failed is not None:
            raise self._failed


@contextmanager
def serve_page(
    settings: PageSettings,
    sources: Callable[[], Sequence[DataSource]],
    controller: Controller | None = None,
) -> Iterator[Page]:
    """Serve the page from a thread as long as the block lasts.

    Raises
    ------
    InputError
        If the port is taken, or may not be used.
    """
    page = Page(settings, sources, Controller() if controller is None else controller)
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
