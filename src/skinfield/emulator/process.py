"""Virtual skin in a process of its own, and a handle on it."""

import contextlib
import json
import socket
import subprocess
import sys
import threading
from typing import Any

from skinfield.emulator.scenes import FINGER
from skinfield.emulator.settings import VirtualSettings
from skinfield.errors import InputError
from skinfield.settings import json_from_value
from skinfield.wire.links import host_and_port, resolved

ANSWER = 5.0  # s
TRIES = 3
DATAGRAM = 65536


def start(settings: VirtualSettings | None = None) -> "VirtualProcess":
    """Start a virtual skin as ``python -m skinfield.emulator``; it is there when this returns.

    It ends by itself when this process does, however that happens.

    Parameters
    ----------
    settings : VirtualSettings, optional
        Default an iCub's boards with a hexagon of 72 taxels.

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
    assert child.stdout is not None
    try:
        child.stdin.write(json_from_value(settings).encode() + b"\n")
        child.stdin.flush()
        reply = json.loads(child.stdout.readline() or b"{}")
    except BaseException:
        child.kill()
        child.communicate()
        raise
    if not reply.get("ready"):
        child.communicate()
        raise InputError(f"virtual skin did not start: {reply.get('error', 'it ended')}")
    return VirtualProcess(child, reply)


class VirtualProcess:
    """Handle on a virtual skin in another process; also a context manager.

    Attributes
    ----------
    description : dict
        What it said when it was there: `channels`, `control`, `patches`, `pid`, ...
    """

    def __init__(self, child: "subprocess.Popen[bytes]", reply: dict[str, Any]) -> None:
        self._child, self.description = child, reply
        self._final: dict[str, Any] = {}
        self._tag = 0
        self._asking = threading.Lock()  # one question at a time, from any thread
        self._socket: socket.socket | None = None
        if reply["control"]:
            place = resolved(*host_and_port(reply["control"], "", 0), "control")
            self._socket = socket.socket(place.family, socket.SOCK_DGRAM)
            self._socket.settimeout(ANSWER)
            self._socket.connect(place.address)

    def __enter__(self) -> "VirtualProcess":
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._child.pid

    @property
    def channels(self) -> list[str]:
        """Where a host finds each bus, such as ``"127.0.0.1:40123"``."""
        return list(self.description["channels"])

    def ask(self, command: dict[str, Any]) -> dict[str, Any]:
        """Send a command to the control socket; its answer.

        Raises
        ------
        InputError
            With the skin's own words if it refuses, or if it does not answer.
        """
        with self._asking:
            self._tag += 1
            data = json.dumps({**command, "tag": self._tag}).encode()
            for _ in range(TRIES):
                if self._socket is None or self._child.poll() is not None:
                    break
                with contextlib.suppress(OSError):  # nobody is there, or answers in time
                    self._socket.send(data)
                    reply: dict[str, Any] = {}
                    while reply.pop("tag", None) != self._tag:  # of a command that was given up
                        reply = json.loads(self._socket.recv(DATAGRAM))
                    if not reply.pop("ok"):
                        raise InputError(reply["error"])
                    return reply
        raise InputError(
            f"virtual skin {self.pid} does not answer {command!r:.80}: it has ended, or has no "
            "control socket"
        )

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
        shear: tuple[float, float] = (0.0, 0.0),
    ) -> str:
        """Begin a press, at a point of the patch's plane, m, or on a taxel; its id.

        A ball or a flat end may push along the plane's x and y, N, with up to half its force. With
        an `id` that is pressing already, that press is changed.
        """
        fields = {
            "do": "press", "id": id, "patch": patch, "x": x, "y": y, "taxel": taxel,
            "force": force, "radius": radius, "shape": shape, "shear": shear,
        }  # fmt: skip
        return str(self.ask(fields)["id"])

    def move(self, id: str, x: float, y: float, force: float | None = None) -> None:
        """Move a press to another point of the patch's plane, m."""
        self.ask({"do": "move", "id": id, "x": x, "y": y, "force": force})

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
        if self._child.stdout is not None and not self._child.stdout.closed:
            try:
                said, _ = self._child.communicate(timeout=ANSWER)
            except subprocess.TimeoutExpired:
                self._child.kill()
                said, _ = self._child.communicate()
            self._final = json.loads(said or b"{}").get("counts", {})
        return self._final
