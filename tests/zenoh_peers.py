"""Rings and sessions for tests of zenoh: each test at a port of its own.

python zenoh_peers.py NAME ROBOT ADDRESS: publish a ring that is filled
"""

import signal
import socket
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import numpy as np
from live_skins import fill, settings, skin_ring

from skinfield.bridges.settings import BridgeSettings
from skinfield.bridges.zenoh.publisher import ZenohPublisher, serve
from skinfield.bridges.zenoh.session import ZenohSettings, open_session
from skinfield.errors import InputError
from skinfield.loop.client import Live
from skinfield.ring import Ring

FORCE = 1.5  # N


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


@contextmanager
def listening() -> Iterator[tuple[Any, str]]:
    """A session that listens, and its address; another port if one was taken meanwhile."""
    with ExitStack() as ends:
        for attempt in range(20):
            address = f"tcp/localhost:{free_port()}"
            try:
                made = ends.enter_context(open_session(ZenohSettings(listen=(address,))))
                break
            except InputError:
                if attempt == 19:
                    raise
        yield made, address


@contextmanager
def joined() -> Iterator[tuple[Any, Any]]:
    """Two sessions that are connected."""
    with listening() as (first, address), open_session(ZenohSettings(connect=(address,))) as second:
        yield first, second


@contextmanager
def publishing(session: Any, ring: Ring, part: Any, **values: Any) -> Iterator[ZenohPublisher]:
    with Live(ring.name) as live:
        publisher = ZenohPublisher(session, live, part, **values)
        with publisher.there():
            yield publisher


def main() -> None:
    name, robot, address = sys.argv[1:]
    stop, rng = threading.Event(), np.random.default_rng(1)
    signal.signal(signal.SIGTERM, lambda *_: stop.set())
    with skin_ring(settings(name=name)) as ring:

        def work() -> None:
            while not stop.wait(0.01):
                fill(ring, rng, time.time_ns(), FORCE)

        worker = threading.Thread(target=work)
        worker.start()
        try:
            serve(name, BridgeSettings(robot=robot, zenoh=True, zenoh_connect=(address,)), stop)
        finally:
            stop.set()
            worker.join()


if __name__ == "__main__":
    main()
