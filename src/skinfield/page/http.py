"""HTTP requests to the page's port: its files, and JSON."""

import json
import mimetypes
from collections.abc import Callable
from http import HTTPStatus
from importlib import resources
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs, urlsplit

from skinfield.errors import SkinfieldError
from skinfield.page.page_state import PageState
from skinfield.settings import PageSettings

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

HERE = ("localhost", "127.0.0.1", "::1")  # as a browser on this machine says it
FILES = ("index.html", "app.js", "app.css", "licences.txt", "favicon.svg")
SOCKET = "/socket"
HEADERS = {
    # 'unsafe-eval' for those who drive the page: they wait by functions that they hand in as text
    "Content-Security-Policy": "default-src 'self'; script-src 'self' 'unsafe-eval'; "
    "img-src 'self' data: blob:; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",  # a token stands in the address
    "Cache-Control": "no-store",
}


class HttpApi:
    """HttpApi to requests; lets through what belongs to the socket.

    Parameters
    ----------
    state : PageState
    settings : PageSettings
    """

    def __init__(self, state: PageState, settings: PageSettings) -> None:
        self._state, self._settings = state, settings
        folder = resources.files("skinfield.page") / "static"
        self._files = {name: (folder / name).read_bytes() for name in FILES if _there(folder, name)}
        self._json: dict[str, Callable[[], Any]] = {
            "/api/status": self._status,
            "/api/contacts": self._contacts,
            "/api/truth": lambda: {"presses": list(state.controller.truth())},
            "/api/controls": state.controller.controls,
        }

    async def answer(self, connection: "ServerConnection", request: "Request") -> "Response | None":
        """Answer a request; None where the socket is meant and may be used."""
        if request.method != "GET":
            wrong = f"method is {request.method!r:.80}, expected GET: nothing is changed from here"
            return _response(HTTPStatus.METHOD_NOT_ALLOWED, {"error": wrong}, Allow="GET")
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
        from skinfield.loop.status import plain_contacts

        state, rows = self._state, []
        layout = state.layout
        for source, view in zip(
            layout.sources, state.controller.views(layout.sources), strict=True
        ):
            names = [patch.name for patch in source.skin]
            found = plain_contacts(names, view.contacts)
            rows += [
                row | {"engine": source.name, "by": by}
                for row, by in zip(found, view.by, strict=True)
            ]
        return {"contacts": rows}


def _there(folder: Any, name: str) -> bool:
    return bool((folder / name).is_file())


def _response(
    status: HTTPStatus, body: Any, kind: str = "application/json; charset=utf-8", **more: str
) -> "Response":
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    data = body if isinstance(body, bytes) else json.dumps(body).encode()
    headers = Headers(HEADERS | {"Content-Type": kind, "Content-Length": str(len(data))} | more)
    headers["Connection"] = "close"
    return Response(status.value, status.phrase, headers, data)
