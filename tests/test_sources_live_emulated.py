"""Sources against the virtual skin in another process: what it sent is what was taken in."""

import numpy as np
from live_devices import HEXAGON, Host

from skinfield.emulator.process import start
from skinfield.emulator.settings import VirtualSettings
from skinfield.signal import Count, Lasting, Source
from skinfield.wire.sources import source_from_options


def follow(host: Host, source: Source) -> Host:
    """Leave the boards to another stream, as engines do that follow on each other."""
    assert isinstance(host.stream, Lasting)
    host.stream.leave()
    host.stream.close()
    stream = source.open()
    assert isinstance(stream, Lasting)
    stream.resume()
    return Host(stream)


def test_icub_goes_on_under_a_press_and_is_told_again_when_it_boots() -> None:
    with start(VirtualSettings(bus="udp", scene="idle")) as skin:
        options = {"period_ms": "5", "no_load": "245"}
        source = source_from_options("icub", "udp", tuple(skin.channels), HEXAGON, options)
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
