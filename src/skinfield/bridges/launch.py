"""Bridge processes: each a process of its own, which may fail alone and is started again."""

import contextlib
import importlib.util
import json
import os
import select
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

from skinfield.bridges.settings import BridgeSettings, ZenohAddresses
from skinfield.bridges.zenoh.session import zenoh_session
from skinfield.errors import InputError
from skinfield.loop.process_supervisor import SupervisedProcess, exit_text
from skinfield.processes import Child, start_python
from skinfield.settings import json_from_value

BEGINS = 180.0  # s for a bridge to be there
LOOK = 0.3  # s between looks whether all shall end
MOST = 1 << 16  # bytes of the line that says it is there


class Bridge(SupervisedProcess):
    """A bridge that runs.

    Parameters
    ----------
    kind : str
        "zenoh", "ros2" or "yarp".
    ring_name : str
    settings : dataclass
        That it is sent.

    Attributes
    ----------
    facts : dict
        What it said when it was there.
    """

    def __init__(self, kind: str, ring_name: str, settings: Any) -> None:
        super().__init__(f"the bridge to {kind}")
        self.kind, self._ring_name, self._settings = kind, ring_name, settings
        self.facts: dict[str, Any] = {}

    def spawn(self) -> Child:
        """See `SupervisedProcess`."""
        module, me = f"skinfield.bridges.{self.kind}", str(os.getpid())
        words = (module, self._ring_name, "--parent", me)
        return start_python(*words, stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def greet(self, child: Child) -> None:
        """See `SupervisedProcess`."""
        assert child.stdin is not None
        with contextlib.suppress(BrokenPipeError):  # then it has said why
            child.stdin.write(json_from_value(self._settings).encode())
            child.stdin.close()
        told = _first_line(child, BEGINS, self.stopping)
        if told.get("ready") is not True:
            self.end()
            why = told.get("error", f"it ended with {exit_text(child.returncode)}")
            raise InputError(f"{self.what} did not start: {why}")
        self.facts = told


def _first_line(child: Child, seconds: float, stop: threading.Event) -> dict[str, Any]:
    """What a bridge says when it is there; `error` if it does not say so in time, or `stop` is set.

    Of one that ends before it says anything there is nothing.
    """
    assert child.stdout is not None
    end = time.monotonic() + seconds
    while not select.select([child.stdout], (), (), LOOK)[0]:
        if stop.is_set():
            return {"error": "all was told to end"}
        if time.monotonic() > end:
            return {"error": f"it was not there within {seconds:g} s: is the machine busy?"}
    try:
        told = json.loads(child.stdout.readline(MOST))
    except ValueError:
        return {}
    return told if isinstance(told, dict) else {}


def bridge_settings(given: BridgeSettings) -> dict[str, Any]:
    """Settings of each bridge that is asked for, by its kind.

    Raises
    ------
    InputError
        If one is meaningless, or needs a package that is not there.
    """
    wanted: dict[str, Any] = {}
    if given.zenoh or given.ros2:
        _need("zenoh", "zenoh")
        session = zenoh_session(given)
    if given.zenoh:
        wanted["zenoh"] = given
    if given.ros2:
        _need("rosbags", "ros")
        from skinfield.bridges.ros2.publisher import RosSettings

        wanted["ros2"] = RosSettings(
            robot=given.robot, domain=given.ros_domain, rates=given.ros_rates, session=session
        )
    if given.yarp:
        from skinfield.bridges.yarp.publisher import YarpSettings

        wanted["yarp"] = YarpSettings(robot=given.robot, name_server=given.yarp_name_server)
    return wanted


def _need(package: str, extra: str) -> None:
    if importlib.util.find_spec(package) is None:
        raise InputError(
            f"package {package} is not installed, expected it: pip install 'skinfield[{extra}]'"
        )


@contextmanager
def zenoh_sources(given: ZenohAddresses) -> Iterator[Any]:
    """Engines elsewhere, as long as the block lasts: `sources()` gives those that there are.

    Raises
    ------
    InputError
        If zenoh is not installed, or cannot start with these settings.
    """
    _need("zenoh", "zenoh")
    from skinfield.bridges.zenoh.discovery import connect

    with connect(zenoh_session(given)) as sources:
        yield sources


@contextmanager
def bridges(given: BridgeSettings, ring_name: str) -> Iterator[list[Bridge]]:
    """The bridges that the options ask for, as long as the block lasts.

    One that ends is started again.

    Raises
    ------
    InputError
        If one does not start, with the reason that it gave.
    """
    wanted = bridge_settings(given)
    made = [Bridge(kind, ring_name, settings) for kind, settings in wanted.items()]
    with ExitStack() as ends:
        for bridge in made:
            ends.enter_context(bridge)
            bridge.begin()
        for bridge in made:
            bridge.watch()
        yield made
