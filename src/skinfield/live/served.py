"""Status and contacts of a running skin as JSON, for programs on this machine: plain HTTP."""

import json
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from skinfield.errors import InputError, SkinfieldError, check_count
from skinfield.live.client import Live
from skinfield.live.slots import Slot
from skinfield.live.status import Observer, contacts_of

HERE = ("localhost", "127.0.0.1", "[::1]")  # as a browser or a program on this machine says it


class _Handler(BaseHTTPRequestHandler):
    """Answers GET /status and GET /contacts."""

    server: "_Server"

    def do_GET(self) -> None:
        host = (self.headers.get("Host") or "localhost").rsplit(":", 1)[0]
        if host not in HERE:  # a page elsewhere must not read a robot by a name it owns
            self._say(403, {"error": f"host is {host!r}, expected one of {', '.join(HERE)}"})
            return
        what = self.path.partition("?")[0].strip("/")
        try:
            if what == "status":
                self._say(200, self.server.status())
            elif what == "contacts":
                self._say(200, self.server.contacts())
            else:
                self._say(404, {"error": f"no {self.path!r}, expected /status or /contacts"})
        except SkinfieldError as error:
            self._say(503, {"error": str(error)})

    def _say(self, code: int, plain: Any) -> None:
        data = json.dumps(plain).encode()
        self.send_response(code)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(data)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, format: str, *arguments: Any) -> None:
        """Say nothing: the table is on the terminal."""


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, name: str, port: int) -> None:
        super().__init__(("127.0.0.1", port), _Handler)
        self._live = Live(name)
        self._observer = Observer(self._live.reader)
        self._lock = threading.Lock()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of clients that went away too soon: the terminal shows the table."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)

    def status(self) -> dict[str, Any]:
        with self._lock:
            return self._observer.look().as_dict()

    def contacts(self) -> dict[str, Any]:
        with self._lock:
            found = self._live.latest()
            slot: Slot = found.slot
            names = [patch.name for patch in self._live.skin]
            return {
                "cycle": found.number,
                "stamp_ns": found.stamp_ns,
                "age": found.age,
                "contacts": contacts_of(names, slot),
            }


@contextmanager
def serve(name: str, port: int) -> Iterator[int]:
    """Serve as long as the block lasts; yields the port, which 0 lets the system choose.

    Raises
    ------
    InputError
        If the port is taken, or may not be used.
    """
    check_count("port", port, 0, 65535, "of this machine; 0 lets the system choose")
    try:
        server = _Server(name, port)
    except OSError as error:
        raise InputError(
            f"port {port} cannot be served: {error.strerror}, expected one that is free"
        ) from error
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield int(server.server_address[1])
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
