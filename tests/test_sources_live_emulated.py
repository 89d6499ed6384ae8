"""Sources against the virtual skin in another process: what it sent is what was taken in."""

import time
from collections.abc import Callable

import numpy as np
import pytest
from bus_peers import PATIENCE
from live_devices import HEXAGON

from skinfield.emulator.process import VirtualProcess, start
from skinfield.emulator.settings import VirtualSettings
from skinfield.signal import Blocks, Channels, Count, Lasting, Source
from skinfield.wire.sources import matched, skin_for, source_from_options


class Host:
    """Takes in whatever comes."""

    def __init__(self, source: Source) -> None:
        self.source, self.stream, self.blocks = source, source.open(), Blocks()
        self.channels = Channels(sum(port.channels for port in self.stream.ports))

    def follow(self) -> None:
        """Leave the boards to another stream, as engines do that follow on each other."""
        before = self.stream
        assert isinstance(before, Lasting)
        before.leave()
        before.close()
        self.stream = self.source.open()
        assert isinstance(self.stream, Lasting)
        self.stream.resume()

    def until(self, condition: Callable[[], object]) -> None:
        end = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < end, self.stream.counters
            self.blocks.clear()
            self.stream.poll(self.blocks, 0, time.time_ns())
            self.channels.apply(self.blocks)
            time.sleep(1e-3)

    def count(self, what: Count) -> int:
        return int(self.stream.counters[what])


def started(hardware: str, bus: str, *channels: str, **options: str) -> tuple[VirtualProcess, Host]:
    settings = VirtualSettings(hardware=hardware, bus=bus, channels=channels, scene="idle")
    skin = start(settings)
    try:
        source = source_from_options(
            hardware, bus, tuple(skin.channels), skin_for(hardware, HEXAGON), options
        )
        host = Host(source)
        assert matched(skin_for(hardware, HEXAGON), host.stream.ports) == (0,)
    except BaseException:
        skin.stop()
        raise
    return skin, host


def test_icub_goes_on_under_a_press_for_the_next_to_read() -> None:
    skin, host = started("icub", "udp", period_ms="5")
    try:
        host.until(lambda: host.count(Count.RECEIVED) > 200)
        skin.press(taxel=40, force=2.0)
        host.until(lambda: np.nanmin(host.channels.counts[:72]) < 220)
        host.follow()
        host.until(lambda: host.count(Count.RECEIVED) > 200)
        assert np.nanmin(host.channels.counts[:72]) < 220  # of 240 at rest
        assert host.stream.reconfigured == 0  # type: ignore[attr-defined]
    finally:
        host.stream.close()
        skin.stop()


def test_icub_that_boots_again_is_told_again() -> None:
    skin, host = started("icub", "udp", period_ms="5", no_load="245")
    try:
        host.until(lambda: host.count(Count.RECEIVED) > 500)
        assert abs(np.nanmean(host.channels.counts[:72]) - 245.0) < 2.0
        skin.fault("reboot 0+100ms")
        host.until(lambda: host.stream.reconfigured == 1)  # type: ignore[attr-defined]
        before = host.count(Count.RECEIVED)
        host.until(lambda: host.count(Count.RECEIVED) > before + 200)
        assert abs(np.nanmean(host.channels.counts[:72]) - 245.0) < 2.0
        host.stream.close()
        counts = skin.stop()
        assert counts["reboots"] == 1
        for what in (Count.LOST, Count.OVERFLOWED, Count.MALFORMED, Count.FOREIGN):
            assert host.count(what) == 0, what.name
        assert host.count(Count.RECEIVED) <= counts["messages"]
    finally:
        skin.stop()


@pytest.mark.parametrize(("hardware", "bus"), [("cyskin", "udp"), ("packet", "serial")])
def test_all_of_a_skin_arrives(hardware: str, bus: str) -> None:
    skin, host = started(hardware, bus)
    try:
        host.until(lambda: host.count(Count.READINGS) > 20)
        placed = skin_for(hardware, HEXAGON)[0]
        assert np.isfinite(host.channels.counts[placed.channel]).all()
        for what in (Count.OVERFLOWED, Count.MALFORMED, Count.FOREIGN):
            assert host.count(what) == 0, what.name
        host.stream.close()
    finally:
        skin.stop()
