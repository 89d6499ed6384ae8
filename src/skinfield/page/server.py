"""Server of the page: one port for its files, its socket, and plain JSON."""

import asyncio
import json
import mimetypes
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from http import HTTPStatus
from importlib import resources
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs, urlsplit

from skinfield.errors import InputError, SkinfieldError
from skinfield.loop.status import plain_contacts
from skinfield.page.controller import Controller
from skinfield.page.page_state import PageState
from skinfield.page.session import FULL, Session
from skinfield.page.settings import PORT, PageSettings
from skinfield.page.source import DataSource

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

HERE = ("localhost", "127.0.0.1", "::1")  # as a browser on this machine says it
FILES = ("index.html", "app.js", "app.css", "licences.txt", "favicon.svg")
SOCKET = "/socket"
HEADERS = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' data: blob:; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",  # a token stands in the address
    "Cache-Control": "no-store",
}


class HttpApi:
    """Answers to requests; lets through what belongs to the socket."""

    def __init__(self, state: PageState, settings: PageSettings) -> None:
        self._state, self._settings = state, settings
        folder = resources.files("skinfield.page") / "static"
        there = [name for name in FILES if (folder / name).is_file()]
        self._files = {name: (folder / name).read_bytes() for name in there}
        self._json: dict[str, Callable[[], Any]] = {
            "/api/status": self._status,
            "/api/contacts": self._contacts,
            "/api/truth": lambda: {"presses": list(state.controller.truth())},
            "/api/controls": state.controller.controls,
        }

    async def answer(self, connection: "ServerConnection", request: "Request") -> "Response | None":
        """Answer a request; None where the socket is meant and may be used."""
        try:
            url = urlsplit(request.path)
            host = urlsplit(f"//{request.headers.get('Host', 'localhost')}").hostname or ""
        except ValueError as error:  # brackets of no address, characters that no host has
            wrong = f"address is {request.path!r:.80}, expected one of this page: {error}"
            return _response(HTTPStatus.BAD_REQUEST, {"error": wrong})
        refused = self._refusal(request, host, url.path, url.query)
        if refused is not None:
            return _response(*refused)
        if url.path == SOCKET:
            return None
        if url.path in self._json:
            return await self._json_response(self._json[url.path])
        name = url.path.strip("/") or "index.html"
        if name not in self._files:
            known = ", ".join(["/", *self._json])
            return _response(
                HTTPStatus.NOT_FOUND, {"error": f"no {url.path!r:.80}; there is {known}"}
            )
        kind = mimetypes.guess_type(name)[0] or "application/octet-stream"
        text = kind.startswith("text/") or name.endswith(".js")
        return _response(
            HTTPStatus.OK, self._files[name], f"{kind}; charset=utf-8" if text else kind
        )

    def _refusal(
        self, request: "Request", name: str, path: str, query: str
    ) -> tuple[HTTPStatus, dict[str, str]] | None:
        """Why a request must not be answered; None if it may.

        A page elsewhere must not reach a robot through the browser of somebody who may: neither by
        a socket, which browsers let any page open, nor by a name that it lets point here.
        """
        settings, headers = self._settings, request.headers
        host = headers.get("Host", "localhost")
        if (
            settings.is_here
            and not settings.token
            and name not in (*HERE, settings.host.strip("[]"))
        ):
            return HTTPStatus.FORBIDDEN, {
                "error": f"host is {host!r:.80}, expected one of {', '.join(HERE)}"
            }
        origin = headers.get("Origin")
        if origin is not None and origin not in (f"http://{host}", f"https://{host}"):
            return HTTPStatus.FORBIDDEN, {
                "error": f"origin is {origin!r:.80}, expected http://{host[:80]}: open it here"
            }
        guarded = path == SOCKET or path in self._json
        token = parse_qs(query).get("token", [""])[0]
        if guarded and not settings.allows(token):
            return HTTPStatus.UNAUTHORIZED, {
                "error": "token is missing or wrong, expected that of --token: /?token=..."
            }
        return None

    async def _json_response(self, function: Callable[[], Any]) -> "Response":
        try:
            return _response(HTTPStatus.OK, await self._state.update_work(function))
        except SkinfieldError as error:
            return _response(HTTPStatus.SERVICE_UNAVAILABLE, {"error": str(error)})

    def _status(self) -> dict[str, Any]:
        state = self._state
        return {**state.status, "mode": state.controller.mode, "controls": state.controls}

    def _contacts(self) -> dict[str, Any]:
        state, rows = self._state, []
        layout = state.layout
        for source, view in zip(
            layout.sources, state.controller.views(layout.sources), strict=True
        ):
            if view.snapshot is not None and not view.old:
                names = [patch.name for patch in source.skin]
                found = plain_contacts(names, view.snapshot.contacts)
                rows += [row | {"engine": source.name} for row in found]
        return {"contacts": rows}


def _response(
    status: HTTPStatus, body: Any, kind: str = "application/json; charset=utf-8", **more: str
) -> "Response":
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    data = body if isinstance(body, bytes) else json.dumps(body, allow_nan=False).encode()
    headers = Headers(HEADERS | {"Content-Type": kind, "Content-Length": str(len(data))} | more)
    headers["Connection"] = "close"
    return Response(status.value, status.phrase, headers, data)


def _connection() -> "type[ServerConnection]":
    """Class of connections that refuse other methods than GET; its base drops what has a body."""
    from websockets.asyncio.server import ServerConnection

    class Connection(ServerConnection):
        is_get: bool | None = None  # not known before the first bytes

        def data_received(self, data: bytes) -> None:
            if self.is_get is None:
                self.is_get = b"GET ".startswith(data[:4])
                if not self.is_get:
                    method = data.split(b" ")[0].decode("latin-1")
                    wrong = f"method is {method!r:.80}, expected GET: nothing is changed from here"
                    refusal = _response(
                        HTTPStatus.METHOD_NOT_ALLOWED, {"error": wrong}, Allow="GET"
                    )
                    self.transport.write(refusal.serialize())
                    self.transport.write_eof()  # the rest is read: a reset would take the answer
            if self.is_get:
                super().data_received(data)

    return Connection


CLIENTS = 16
PING = 10.0  # s between pings, and for an answer to one: who gives none loses the place
ENDS = 2.0  # s for a browser to say goodbye
LARGEST = 1 << 16  # bytes of a command
STARTS = 20.0  # s for a server to be there


class Page:
    """A page that is served; made by `serve_page`.

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
        self.state = PageState(sources, controller)
        self._made = 0  # sessions so far
        self._stop: asyncio.Event | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._failed: BaseException | None = None

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
            self.state.shut_down()

    async def _run(self, ready: threading.Event) -> None:
        self._stop, self._loop = asyncio.Event(), asyncio.get_running_loop()
        server = await self._bound()
        self.port = next(iter(server.sockets)).getsockname()[1]
        tasks = self.state.tasks()
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

        api, settings, why = HttpApi(self.state, self.settings), self.settings, ""
        for port in (PORT, 0) if settings.port is None else (settings.port,):
            try:
                return await serve(
                    self._client,
                    settings.host.strip("[]"),
                    port,
                    process_request=api.answer,
                    create_connection=_connection(),
                    compression=None,  # numbers hardly shrink, and it would cost more than they do
                    max_size=LARGEST,
                    max_queue=64,
                    ping_interval=PING,
                    ping_timeout=PING,
                    close_timeout=ENDS,
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
        if self.state.sessions >= CLIENTS:
            await socket.close(
                FULL, f"{CLIENTS} browsers look on already, the most this page serves"
            )
            return
        self.state.sessions += 1
        self._made += 1
        try:
            await Session(self.state, socket, self._made).run()
        finally:
            self.state.sessions -= 1

    def end(self) -> None:
        """Stop serving; from another thread."""
        loop, stop = self._loop, self._stop
        if loop is not None and stop is not None:
            with suppress(RuntimeError):  # it has ended already
                loop.call_soon_threadsafe(stop.set)

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
        page.state.wait_prepared()
