"""The bridges that `skinfield run` starts: a process each, which may fail alone."""

import contextlib
import importlib.util
import json
import os
import re
import selectors
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from typing import Any

from skinfield.cli.kept import LOOKS, Kept, how
from skinfield.errors import InputError

BEGINS = 180.0  # s for a bridge to be there
MOST = 1 << 16  # bytes of the line that says it is there
ROBOT = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")


class Bridge(Kept):
    """A bridge that runs.

    Parameters
    ----------
    kind : str
        "zenoh", "ros2" or "yarp".
    command : list of str
    settings : mapping
        That it is told.

    Attributes
    ----------
    facts : dict
        What it said when it was there.
    """

    def __init__(self, kind: str, command: list[str], settings: Mapping[str, Any]) -> None:
        super().__init__(f"the bridge to {kind}")
        self.kind, self._command, self._settings = kind, command, settings
        self.facts: dict[str, Any] = {}

    def spawn(self) -> "subprocess.Popen[bytes]":
        """See `Kept`."""
        return subprocess.Popen(
            self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, process_group=0
        )

    def greet(self, child: "subprocess.Popen[bytes]") -> None:
        """See `Kept`."""
        assert child.stdin is not None
        with contextlib.suppress(BrokenPipeError):  # then it has said why
            child.stdin.write(json.dumps(self._settings).encode())
            child.stdin.close()
        told = _first_line(child, BEGINS, self.stopping)
        if told.get("ready") is not True:
            self.end()
            why = told.get("error", f"it ended with {how(child.returncode)}")
            raise InputError(f"{self.what} did not start: {why}")
        self.facts = told


class Bridges(tuple[Bridge, ...]):
    """The bridges that run."""

    __slots__ = ()

    def notices(self) -> list[str]:
        """What happened to any of them since the last time, in sentences."""
        return [text for bridge in self for text in bridge.notices()]


def _first_line(
    child: "subprocess.Popen[bytes]", seconds: float, stop: threading.Event
) -> dict[str, Any]:
    """What a bridge says when it is there; `error` if it does not say so in time, or `stop` is set.

    Of one that ends before it says anything there is nothing.
    """
    assert child.stdout is not None
    end, data = time.monotonic() + seconds, b""
    with selectors.DefaultSelector() as waiting:
        waiting.register(child.stdout, selectors.EVENT_READ)
        while b"\n" not in data and len(data) < MOST:
            if stop.is_set():
                return {"error": "all was told to end"}
            if time.monotonic() > end:
                return {"error": f"it was not there within {seconds:g} s: is the machine busy?"}
            if not waiting.select(LOOKS):
                continue
            part = os.read(child.stdout.fileno(), MOST)
            if not part:
                break
            data += part
    try:
        told = json.loads(data.partition(b"\n")[0])
    except ValueError:
        return {}
    return told if isinstance(told, dict) else {}


def check_bridges(given: Mapping[str, Any]) -> None:
    """Refuse, before anything starts, what cannot become a bridge.

    Raises
    ------
    InputError
        If an option is meaningless, or needs a package that is not there.
    """
    addressed = any(given[f"zenoh_{what}"] for what in ("listen", "connect", "config"))
    if addressed and not (given["zenoh"] or given["ros2"]):
        raise InputError("addresses of zenoh were given, expected --zenoh or --ros2 with them")
    for what in ("domain", "rate"):
        if given[f"ros_{what}"] not in (None, ()) and not given["ros2"]:
            raise InputError(f"--ros-{what} was given, expected --ros2 with it")
    if not ROBOT.fullmatch(given["robot"]):
        raise InputError(
            f"--robot is {given['robot']!r}, expected letters, digits, '_', '-' and '.', at most 64"
        )
    if given["zenoh"] or given["ros2"]:
        _need("zenoh", "zenoh")
        zenoh_settings(given)
    if given["ros2"]:
        _need("rosbags", "ros")
        from skinfield.bridges.ros2.settings import RosSettings

        RosSettings.from_plain(_wanted(given)["ros2"])


def _need(package: str, extra: str) -> None:
    if importlib.util.find_spec(package) is None:
        raise InputError(
            f"package {package} is not installed, expected it: pip install 'skinfield[{extra}]'"
        )


def zenoh_settings(given: Mapping[str, Any]) -> Any:
    """`ZenohSettings` of the options."""
    from skinfield.bridges.zenoh.session import ZenohSettings

    return ZenohSettings(
        listen=tuple(given["zenoh_listen"]),
        connect=tuple(given["zenoh_connect"]),
        config=given["zenoh_config"],
    )


@contextmanager
def zenoh_feeds(given: Mapping[str, Any]) -> Iterator[Any]:
    """Engines elsewhere, as long as the block lasts: `feeds()` gives those that there are.

    Parameters
    ----------
    given : mapping
        Options of `zenoh_options`.

    Raises
    ------
    InputError
        If zenoh is not installed, or cannot start with these settings.
    """
    _need("zenoh", "zenoh")
    from skinfield.bridges.zenoh.feeds import connect

    with connect(zenoh_settings(given)) as feeds:
        yield feeds


def _wanted(given: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Settings of each bridge that is asked for."""
    robot, wanted = given["robot"], {}
    if given["zenoh"]:
        wanted["zenoh"] = {"robot": robot, "session": zenoh_settings(given).to_plain()}
    if given["ros2"]:
        wanted["ros2"] = {
            "robot": robot,
            "domain": given["ros_domain"],
            "rates": dict(_rate_of(text) for text in given["ros_rate"]),
            "session": zenoh_settings(given).to_plain(),
        }
    if given["yarp"] is not None:
        wanted["yarp"] = {"robot": robot, "name_server": given["yarp"] or None}
    return wanted


def _rate_of(text: str) -> tuple[str, float]:
    what, _, rate = text.partition("=")
    try:
        return what, float(rate)
    except ValueError as error:
        raise InputError(
            f"--ros-rate is {text!r}, expected such as wrench=500: messages a second"
        ) from error


@contextmanager
def bridges(given: Mapping[str, Any], ring_name: str) -> Iterator[Bridges]:
    """The bridges that the options ask for, as long as the block lasts.

    One that ends is started again.

    Parameters
    ----------
    given : mapping
        Options of `bridge_options`.
    ring_name : str

    Raises
    ------
    InputError
        If one does not start, with the reason that it gave.
    """
    check_bridges(given)
    made = Bridges(
        Bridge(
            kind,
            [
                sys.executable, "-m", f"skinfield.bridges.{kind}", ring_name,
                "--parent", str(os.getpid()),
            ],
            settings,
        )
        for kind, settings in _wanted(given).items()
    )  # fmt: skip
    with ExitStack() as ends:
        for bridge in made:
            ends.enter_context(bridge)
            bridge.begin()
        for bridge in made:
            bridge.keep()
        yield made
