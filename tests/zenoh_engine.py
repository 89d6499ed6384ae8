"""A process with a ring that is filled, and published: zenoh_engine.py NAME ROBOT ADDRESS."""

import signal
import sys
import threading
import time

import numpy as np
from live_skins import fill, settings, skin_ring

from skinfield.bridges.zenoh.publisher import PublisherSettings, serve
from skinfield.bridges.zenoh.session import ZenohSettings

FORCE = 1.5  # N


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
        session = ZenohSettings(connect=(address,))
        try:
            serve(name, PublisherSettings(robot=robot, session=session), stop)
        finally:
            stop.set()
            worker.join()


if __name__ == "__main__":
    main()
