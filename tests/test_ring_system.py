"""Fences and waking: each way that a machine may need, as far as this one has it."""

import platform
import sys
import threading
import time

import pytest
from ring_scenes import SLOT, numbers, own_name, write

from skinfield.errors import InputError
from skinfield.ring import Ring, RingReader, system


def test_x86_needs_no_fence_and_others_do(monkeypatch: pytest.MonkeyPatch) -> None:
    for machine, needed in {"x86_64": False, "AMD64": False, "aarch64": True, "": True}.items():
        monkeypatch.setattr(platform, "machine", lambda machine=machine: machine)
        assert system.needs_fence() == needed
    monkeypatch.setattr(platform, "machine", lambda: "x86_64")
    assert system.fence() is None
    monkeypatch.setattr(platform, "machine", lambda: "m68k")
    assert system.fence_of_kernel() is None
    assert isinstance(system.signal(0), system.Polling)


def test_a_ring_works_with_a_fence(monkeypatch: pytest.MonkeyPatch) -> None:
    fence = system.fence_of_kernel()
    if fence is None:
        pytest.skip("no fence on this machine")
    assert fence() == 0
    calls: list[object] = []
    monkeypatch.setattr(system, "fence", lambda: lambda: calls.append(fence()))
    with own_name() as name, Ring.create(name, SLOT, slots=4) as ring, RingReader(name) as reader:
        for newest in range(1, 10):
            write(ring)
            assert numbers(reader)[-1] == newest
    assert len(calls) > 9 * 4


def test_without_any_fence_it_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(system, "needs_fence", lambda: True)
    monkeypatch.setattr(system, "fence_of_kernel", lambda: None)
    with pytest.raises(InputError, match="membarrier"):
        system.fence()
    monkeypatch.setattr(sys, "byteorder", "big")
    with pytest.raises(InputError, match="little-endian"):
        system.fence()


@pytest.mark.parametrize("polling", [False, True])
def test_who_waits_is_woken(polling: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if polling:
        monkeypatch.setattr(system, "machine", lambda: "")
    elif not system.FUTEX.get(system.machine()):
        pytest.skip("no futex on this machine")
    woken: list[int] = []
    with own_name() as name, Ring.create(name, SLOT) as ring, RingReader(name) as reader:
        assert isinstance(ring._signal, system.Polling) == polling
        threads = [
            threading.Thread(target=lambda: woken.append(reader.wait(0, 60))) for _ in range(2)
        ]
        for thread in threads:
            thread.start()
        time.sleep(0.02)
        write(ring)
        for thread in threads:
            thread.join(60)
    assert woken == [1, 1]


def test_futex_refuses_nonsense(monkeypatch: pytest.MonkeyPatch) -> None:
    if not system.FUTEX.get(system.machine()):
        pytest.skip("no futex on this machine")
    with pytest.raises(InputError, match="failed with E"):
        system.signal(1).wait(0, 0.001)  # no word lies at address 1
