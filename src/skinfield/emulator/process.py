"""Virtual skin in a process of its own, and a handle on it."""

import contextlib
import json
import select
import socket
import subprocess
import sys
import threading
import time
from types import TracebackType
from typing import Any

from skinfield.emulator.scenes import FINGER
from skinfield.emulator.settings import VirtualSettings
from skinfield.errors import InputError
from skinfield.settings import json_from_value
from skinfield.wire.can.bus import host_and_port

READY = 600.0  # s: presses may have to be solved first, and kernels compiled
ANSWER = 5.0  # s
TRIES = 3
DATAGRAM = 65536


class Silent(InputError):
    """A virtual skin that has ended, or does not answer."""


def start(settings: VirtualSettings | None = None, timeout: float = READY) -> "VirtualProcess":
    """Start a virtual skin as ``python -m skinfield.emulator``; it is there when this returns.

    It ends by itself when this process does, however that happens.

    Parameters
    ----------
    settings : VirtualSettings, optional
        Default an iCub's boards with a hexagon of 72 taxels.
    timeout : float, s
        To wait for it to be there.

    Raises
    ------
    InputError
        With what it said, if it could not start.
    """
    settings = VirtualSettings() if settings is None else settings
    child = subprocess.Popen(
        [sys.executable, "-m", "skinfield.emulator"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        process_group=0,  # a terminal's Ctrl-C is meant for whoever started it, and ends it
    )
    assert child.stdin is not None
    try:
        child.stdin.write(json_from_value(settings).encode() + b"\n")
        child.stdin.flush()
        reply = _line(child, timeout)
    except BaseException:
        _end(child)
        raise
    if not reply.get("ready"):
        _end(child)
        raise InputError(f"virtual skin did not start: {reply.get('error', 'it reply nothing')}")
    return VirtualProcess(child, settings, reply)


def _line(child: "subprocess.Popen[bytes]", timeout: float) -> dict[str, Any]:
    """Next line of a child, as JSON; empty where it has ended or says something else."""
    assert child.stdout is not None
    data, until = b"", time.monotonic() + timeout
    while not data.endswith(b"\n"):
        left = until - time.monotonic()
        if left <= 0.0 or not select.select([child.stdout], [], [], left)[0]:
            raise Silent(f"virtual skin says nothing for {timeout:g} s, expected a line")
        more = child.stdout.read1(DATAGRAM)  # type: ignore[attr-defined]
        if not more:
            return {}
        data += more
    try:
        reply = json.loads(data.splitlines()[0])
    except ValueError:
        return {}
    return reply if isinstance(reply, dict) else {}


def _end(child: "subprocess.Popen[bytes]") -> None:
    """End a child, by asking first."""
    if child.stdin is not None:
        with contextlib.suppress(OSError):
            child.stdin.close()
    try:
        child.wait(ANSWER)
    except subprocess.TimeoutExpired:
        child.kill()
        child.wait()
    if child.stdout is not None:
        child.stdout.close()


class VirtualProcess:
    """Handle on a virtual skin in another process; also a context manager.

    Attributes
    ----------
    settings : VirtualSettings
    description : dict
        What it said when it was there: `channels`, `control`, `patches`, `pid`, ...
    """

    def __init__(
        self, child: "subprocess.Popen[bytes]", settings: VirtualSettings, reply: dict[str, Any]
    ) -> None:
        self._child, self.settings, self.description = child, settings, reply
        self._final: dict[str, Any] = {}
        self._tag = 0
        self._asking = threading.Lock()  # one question at a time, from any thread
        self._socket: socket.socket | None = None
        if reply.get("control"):
            place = host_and_port(reply["control"], "127.0.0.1", 0)
            family = socket.AF_INET6 if ":" in place[0] else socket.AF_INET
            self._socket = socket.socket(family, socket.SOCK_DGRAM)
            self._socket.connect(place)

    def __enter__(self) -> "VirtualProcess":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._child.pid

    @property
    def channels(self) -> list[str]:
        """Where a host finds each bus, such as ``"127.0.0.1:40123"``."""
        return list(self.description["channels"])

    @property
    def running(self) -> bool:
        """Whether the process is there."""
        return self._child.poll() is None

    def ask(self, command: dict[str, Any]) -> dict[str, Any]:
        """Send a command to the control socket; its answer.

        Raises
        ------
        InputError
            With the skin's own words if it refuses, or if it does not answer.
        """
        with self._asking:
            return self._ask(command)

    def _ask(self, command: dict[str, Any]) -> dict[str, Any]:
        if self._socket is None:
            raise Silent("virtual skin has no control socket, expected settings with control")
        self._tag += 1
        data = json.dumps({**command, "tag": self._tag}).encode()
        for _ in range(TRIES):
            with contextlib.suppress(ConnectionError):
                self._socket.send(data)
                answer = self._answer(ANSWER)
                if answer is not None:
                    return answer
            if not self.running:
                break
        raise Silent(f"virtual skin {self.pid} does not answer {command!r:.80}: it has ended")

    def _answer(self, timeout: float) -> dict[str, Any] | None:
        assert self._socket is not None
        until = time.monotonic() + timeout
        while (left := until - time.monotonic()) > 0.0:
            if not select.select([self._socket], [], [], left)[0]:
                break
            reply = json.loads(self._socket.recv(DATAGRAM))
            if reply.pop("tag", None) != self._tag:
                continue  # of a command that was given up
            if not reply.pop("ok"):
                raise InputError(reply["error"])
            return dict(reply)
        return None

    def press(
        self,
        x: float | None = None,
        y: float | None = None,
        *,
        force: float = 1.0,
        radius: float = FINGER,
        shape: str = "ball",
        patch: str | int = 0,
        taxel: int | None = None,
        id: str | None = None,
    ) -> str:
        """Begin a press, at a point of the patch's plane, m, or on a taxel; its id.

        With an `id` that is pressing already, that press is changed.
        """
        fields: dict[str, Any] = {
            "do": "press", "patch": patch, "force": force, "radius": radius, "shape": shape,
        }  # fmt: skip
        fields |= {"taxel": taxel} if taxel is not None else {"x": x, "y": y}
        fields |= {"id": id} if id is not None else {}
        return str(self.ask(fields)["id"])

    def move(self, id: str, x: float, y: float, force: float | None = None) -> None:
        """Move a press to another point of the patch's plane, m."""
        fields: dict[str, Any] = {"do": "move", "id": id, "x": x, "y": y}
        self.ask(fields | ({} if force is None else {"force": force}))

    def release(self, id: str | None = None) -> None:
        """Lift off a press, or all that began by hand."""
        self.ask({"do": "release", "id": id})

    def fault(self, text: str) -> None:
        """Begin a fault, such as ``"unplug 3+5s"``; its times count from now."""
        self.ask({"do": "fault", "fault": text})

    def clear(self, kind: str | None = None) -> None:
        """End all faults, or those of a kind."""
        self.ask({"do": "clear", "kind": kind})

    def wires(self, **chances: float) -> None:
        """Change the probabilities `lose`, `duplicate` and `swap`."""
        self.ask({"do": "wires", **chances})

    def scene(self, text: str) -> None:
        """Play another scene, now."""
        self.ask({"do": "scene", "scene": text})

    def truth(self, after: int = 0) -> list[dict[str, Any]]:
        """Lines about what really pressed, from line `after` on."""
        lines: list[dict[str, Any]] = []
        while True:
            reply = self.ask({"do": "truth", "after": after})
            lines += reply["lines"]
            if not reply["lines"] or lines[-1]["number"] + 1 >= reply["made"]:
                return lines
            after = lines[-1]["number"] + 1

    def counts(self) -> dict[str, Any]:
        """What was sent and what was done to it, so far; after `stop`, in all."""
        return self._final if self._final else self.ask({"do": "counts"})

    def stop(self) -> dict[str, Any]:
        """End it; its last counts. A second time does nothing."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None
        if self._child.stdin is not None and not self._child.stdin.closed:
            with contextlib.suppress(OSError):
                self._child.stdin.close()
            with contextlib.suppress(Silent):
                self._final = dict(_line(self._child, ANSWER).get("counts", {}))
            _end(self._child)
        return self._final
