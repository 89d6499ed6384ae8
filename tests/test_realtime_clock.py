"""Due times against plain arithmetic, and real sleeps by what cannot fail on a loaded machine."""

import os
import select
import signal
import sys
import time
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import pairwise

import pytest

from skinfield.errors import InputError
from skinfield.realtime import EventWaiter, PeriodicClock, clock, events, system

MS = 1_000_000


class FakeTime:
    """A clock that moves when it is told to, and by sleeping."""

    def __init__(self, now: int = 0) -> None:
        self.now = now

    def monotonic_ns(self) -> int:
        return self.now

    def sleep_until(self, due_ns: int) -> None:
        self.now = max(self.now, due_ns + 7)  # each wake is 7 ns late


def run(work: list[int], first: int = 100) -> tuple[list[tuple[int, int]], int]:
    """Due and wake of cycles that take `work`, at a period of 1000 ns."""
    fake, periodic = FakeTime(), PeriodicClock(1000, first_ns=first)
    periodic._sleeper = fake
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(clock, "time", fake)
        found = []
        for each in [*work, 0]:
            found.append(periodic.wait())
            fake.now += each
    return found, periodic.skipped


def test_short_cycles_keep_their_places() -> None:
    found, skipped = run([10, 900, 993, 0])
    assert found == [(100 + 1000 * k, 107 + 1000 * k) for k in range(5)]
    assert skipped == 0


def test_long_cycles_are_not_made_up_for() -> None:
    found, skipped = run([994, 3500, 10])  # the first ends 1 ns after the next was due
    assert [due for due, _ in found] == [100, 2100, 6100, 7100]
    assert skipped == 4


def test_any_work_gives_the_first_multiple_that_is_not_past() -> None:
    work = [(37 * k * k) % 4001 for k in range(200)]
    found, skipped = run(work)
    for (due, wake), took, (following, _) in zip(found, work, found[1:], strict=False):
        ready = wake + took
        assert following == min(
            multiple for multiple in range(due + 1000, due + 9000, 1000) if multiple >= ready
        )
    assert skipped == (found[-1][0] - found[0][0]) // 1000 - len(work)


def test_real_sleeps_end_after_they_are_due() -> None:
    periodic = PeriodicClock(MS)
    found = [periodic.wait() for _ in range(50)]
    assert all(wake >= due for due, wake in found)
    steps = [later - sooner for (sooner, _), (later, _) in pairwise(found)]
    assert all(step % MS == 0 and step > 0 for step in steps)
    assert sum(step // MS - 1 for step in steps) <= periodic.skipped


def test_time_before_the_first_wait_is_not_skipped() -> None:
    periodic = PeriodicClock(MS)
    time.sleep(0.02)
    before = time.monotonic_ns()
    due, _ = periodic.wait()
    assert due > before
    assert due % MS == 0
    assert periodic.skipped == 0


def test_other_systems_sleep_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(system, "LIBRARY", None)
    periodic = PeriodicClock(MS)
    assert periodic._sleeper._nanosleep is None
    assert all(wake >= due for due, wake in (periodic.wait() for _ in range(5)))


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timers")
def test_signals_are_handled_and_do_not_end_a_sleep() -> None:
    seen = []
    old = signal.signal(signal.SIGALRM, lambda *_: seen.append(time.monotonic_ns()))
    signal.setitimer(signal.ITIMER_REAL, 0.005, 0.005)
    try:
        first = time.monotonic_ns() + 50 * MS
        due, wake = PeriodicClock(50 * MS, first_ns=first).wait()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, old)
    assert wake >= due
    assert seen
    assert seen[0] < wake


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    ends = os.pipe()
    yield ends
    for end in ends:
        with suppress(OSError):
            os.close(end)


@pytest.fixture(params=["epoll", "any"])
def waiter(request: pytest.FixtureRequest) -> Iterator[Callable[..., EventWaiter]]:
    made = []

    def make(filenos, longest_ms: float, shortest_ms: float = 0.0) -> EventWaiter:
        with pytest.MonkeyPatch.context() as patch:
            if request.param == "any":
                patch.delattr(select, "epoll", raising=False)
            made.append(EventWaiter(filenos, int(longest_ms * MS), int(shortest_ms * MS)))
        kind = events._EPoll if request.param == "epoll" else events._AnyPoll
        assert isinstance(made[-1]._poll, kind)
        return made[-1]

    if request.param == "epoll" and not hasattr(select, "epoll"):
        pytest.skip("no epoll")
    yield make
    for each in made:
        each.close()


def test_what_arrives_begins_a_cycle(waiter, pipe) -> None:
    wait = waiter([pipe[0]], longest_ms=60_000)
    os.write(pipe[1], b"x")
    due, wake = wait.wait()
    assert due == wake
    again, _ = wait.wait()  # it was not read
    assert again >= wake
    os.read(pipe[0], 1)
    assert wait.skipped == 0


def test_a_cycle_begins_when_nothing_arrives(waiter, pipe) -> None:
    before = time.monotonic_ns()
    wait = waiter([pipe[0]], longest_ms=5)
    made = time.monotonic_ns()
    due, wake = wait.wait()
    assert before - MS < due - 5 * MS <= made
    assert due <= wake
    due, later = wait.wait()
    assert due == wake + 5 * MS or due == later


def test_without_any_source_it_is_a_slow_clock(waiter) -> None:
    wait = waiter([], longest_ms=3)
    _, first = wait.wait()
    _, second = wait.wait()
    assert second - first >= 2 * MS


def test_a_closed_end_does_not_take_the_processor(waiter, pipe) -> None:
    wait = waiter([pipe[0]], longest_ms=1000, shortest_ms=2)
    os.close(pipe[1])
    wakes = [wait.wait()[1] for _ in range(6)]
    assert all(b - a >= 2 * MS for a, b in pairwise(wakes))


def test_long_cycles_leave_the_processor_to_others_now_and_then(waiter, pipe) -> None:
    os.write(pipe[1], b"x")  # never read
    wait, slept = waiter([pipe[0]], longest_ms=1000), []
    for _ in range(3):
        began = wait.wait()[1]
        while (now := time.monotonic_ns()) < began + 20 * MS:
            pass
        slept.append((began, now))
    slept.append((wait.wait()[1], 0))
    for (began, ended), (again, _) in pairwise(slept):
        assert again - ended >= (ended - began) // 10


def test_a_source_that_was_opened_again_is_watched(waiter) -> None:
    first = os.pipe()
    wait = waiter([first[0]], longest_ms=60_000)
    for end in first:
        os.close(end)
    second = os.pipe()  # the same numbers, most likely
    try:
        wait.watch([second[0]])
        os.write(second[1], b"x")
        due, wake = wait.wait()
        assert due == wake
        wait.watch([])
        assert wait._watched == ()
    finally:
        for end in second:
            os.close(end)


def test_descriptors_of_a_function_are_asked_for_again(
    waiter, pipe, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(events, "AGAIN_NS", 0)
    there: list[int] = []
    wait = waiter(lambda: there, longest_ms=1)
    os.write(pipe[1], b"x")
    wait.wait()
    there.append(pipe[0])
    due, wake = wait.wait()
    assert due == wake
    assert wait._watched == (pipe[0],)


def test_waiting_leaves_no_memory_behind(pipe) -> None:
    os.write(pipe[1], b"x")
    event = EventWaiter([pipe[0]], longest_ns=MS, shortest_ns=0)
    try:
        for wait in (PeriodicClock(20_000).wait, event.wait):
            for _ in range(100):
                wait()
            tracemalloc.start()
            wait()
            before = tracemalloc.get_traced_memory()[0]
            for _ in range(1000):
                wait()
            grown = tracemalloc.get_traced_memory()[0] - before
            tracemalloc.stop()
            assert grown < 500, "bytes over 1000 cycles"  # the newest numbers take the old's place
    finally:
        event.close()


def test_impossible_times_are_refused() -> None:
    with pytest.raises(InputError, match="period_ns"):
        PeriodicClock(0)
    with pytest.raises(InputError, match="shortest_ns"):
        EventWaiter([], longest_ns=MS, shortest_ns=2 * MS)


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux")
def test_linux_sleeps_by_its_own_clock() -> None:
    assert PeriodicClock(MS)._sleeper._nanosleep is not None


def test_work_before_a_cycle_may_end_late_without_skipping_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fake, periodic = FakeTime(), PeriodicClock(1000, first_ns=1000)
    periodic._sleeper = fake
    monkeypatch.setattr(clock, "time", fake)
    assert periodic.early(200)
    assert fake.now == 807
    assert periodic.wait() == (1000, 1007)
    assert periodic.early(200)
    fake.now += 400  # until 2207: beyond the next due time, by less than half a period
    assert periodic.wait() == (2000, 2207)
    assert periodic.skipped == 0
    assert periodic.early(200)
    fake.now += 900  # until 3707: by more
    assert periodic.wait() == (4000, 4007)
    assert periodic.skipped == 1
    fake.now = 4900
    assert not periodic.early(200)  # too late to begin anything
    assert periodic.wait() == (5000, 5007)


def test_early_work_begins_as_soon_before_the_cycle_as_it_takes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from skinfield.live import early

    fake, periodic = FakeTime(), PeriodicClock(MS, first_ns=MS)
    periodic._sleeper = fake
    monkeypatch.setattr(clock, "time", fake)
    monkeypatch.setattr(early, "time", fake)
    begun = []

    def work() -> None:
        begun.append(periodic._due + MS - fake.now)  # type: ignore[operator]
        fake.now += 50_000

    before = early.Early(periodic, work)
    for _ in range(3000):
        before()
        due, wake = periodic.wait()
        assert wake - due == 7
    assert begun[0] == MS // 4 - 7
    assert abs(begun[-1] - 80_000) < 500  # what it takes, and the spare time
    assert periodic.skipped == 0
