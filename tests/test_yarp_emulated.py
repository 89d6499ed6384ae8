"""The virtual robot's ports of YARP, read by the source that reads a real one's."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from bus_peers import wait_for
from live_devices import HEXAGON

from skinfield.acquisition import Blocks, Channels, Count
from skinfield.errors import InputError
from skinfield.sources.live import source_from_options
from skinfield.virtual import VirtualSettings, VirtualSkin, Wires


@contextmanager
def emulated(**changes: object) -> Iterator[VirtualSkin]:
    made = VirtualSettings(
        hardware="yarp", bus="tcp", channels=("127.0.0.1:0",), scene="idle", control="",
        rate=200.0, **changes,
    )  # fmt: skip
    skin = VirtualSkin(made)
    thread = threading.Thread(target=skin.run)
    thread.start()
    try:
        yield skin
    finally:
        skin.stop()
        thread.join()
        skin.close()


def test_all_that_is_sent_arrives_and_what_is_left_out_is_counted() -> None:
    with emulated(wires=Wires(lose=0.2), seed=3) as skin:
        stream = source_from_options("yarp", skin.hardware.addresses[0], (), HEXAGON).open()
        blocks, channels = Blocks(), Channels(72)

        def enough() -> bool:
            blocks.clear()
            stream.poll(blocks, 0, time.time_ns())
            channels.apply(blocks)
            return bool(stream.counters[Count.READINGS] >= 60)

        wait_for(enough)
        assert abs(np.nanmean(channels.counts) - 240.0) < 1.0
        assert set(np.rint(channels.counts)) == set(channels.counts)
        skin.stop()
        sent = skin.counts()
        wait_for(lambda: enough() and stream.counters[Count.READINGS] == skin.counts()["messages"])
        assert 0 <= skin.counts()["lost"] - stream.counters[Count.LOST] <= 3  # at either end
        assert sent["lost"] > 3
        assert stream.counters[Count.MALFORMED] == 0
        stream.close()


def test_what_a_tcp_connection_cannot_do_is_refused() -> None:
    with pytest.raises(InputError, match="neither double nor swap"):
        VirtualSkin(VirtualSettings(hardware="yarp", bus="tcp", wires=Wires(swap=0.1)))
    with pytest.raises(InputError, match="bus is 'udp'"):
        VirtualSettings(hardware="yarp", bus="udp")
