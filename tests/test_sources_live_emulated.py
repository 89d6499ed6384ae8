"""Sources against the virtual skin in another process: what it sent is what was taken in."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from live_devices import HEXAGON, Host

from skinfield.emulator.process import VirtualProcess, start
from skinfield.emulator.settings import VirtualSettings
from skinfield.signal import Count, Lasting, Source
from skinfield.wire.sources import skin_for, source_from_options


def follow(host: Host, source: Source) -> Host:
    """Leave the boards to another stream, as engines do that follow on each other."""
    assert isinstance(host.stream, Lasting)
    host.stream.leave()
    host.stream.close()
    stream = source.open()
    assert isinstance(stream, Lasting)
    stream.resume()
    return Host(stream)


@contextmanager
def started(hardware: str, bus: str, **options: str) -> Iterator[tuple[VirtualProcess, Source]]:
    with start(VirtualSettings(hardware=hardware, bus=bus, scene="idle")) as skin:
        placed = skin_for(hardware, HEXAGON)
        yield skin, source_from_options(hardware, bus, tuple(skin.channels), placed, options)


def test_icub_goes_on_under_a_press_and_is_told_again_when_it_boots() -> None:
    with started("icub", "udp", period_ms="5", no_load="245") as (skin, source):
        first = Host(source.open())
        first.until(lambda: first.count(Count.RECEIVED) > 500)
        assert abs(np.nanmean(first.channels.counts[:72]) - 245.0) < 2.0
        skin.press(taxel=40, force=2.0)
        first.until(lambda: np.nanmin(first.channels.counts[:72]) < 225)
        host = follow(first, source)
        host.until(lambda: host.count(Count.RECEIVED) > 200)
        assert np.nanmin(host.channels.counts[:72]) < 225
        assert host.stream.reconfigured == 0  # type: ignore[attr-defined]
        skin.release()
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
        assert first.count(Count.RECEIVED) + host.count(Count.RECEIVED) <= counts["messages"]


@pytest.mark.parametrize(("hardware", "bus"), [("cyskin", "udp"), ("packet", "serial")])
def test_all_of_a_skin_arrives(hardware: str, bus: str) -> None:
    with started(hardware, bus) as (_, source):
        host, placed = Host(source.open()), skin_for(hardware, HEXAGON)
        host.until(lambda: host.count(Count.READINGS) > 20)
        assert np.isfinite(host.channels.counts[placed[0].channel]).all()
        for what in (Count.OVERFLOWED, Count.MALFORMED, Count.FOREIGN):
            assert host.count(what) == 0, what.name
        host.stream.close()
