"""Due times and histograms of times against plain arithmetic; sleeps by what no load can break."""

import os
import signal
import time
import tracemalloc
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.errors import InputError
from skinfield.loop.realtime import (
    WORDS,
    EventWaiter,
    PeriodicClock,
    Timing,
    TimingTable,
    clock,
    quantiles,
)
from skinfield.loop.realtime.timing import FIELDS, LAST_NS, TIMES, TOTALS
from skinfield.loop.realtime.timing_kernel import BINS, LONGEST, SUM, TOP, add_time

MS = 1_000_000


class FakeTime:
    """A clock that moves when it is told to, and by sleeping."""

    def __init__(self, now: int = 0) -> None:
        self.now = now

    def monotonic_ns(self) -> int:
        return self.now

    def sleep_until(self, due_ns: int) -> None:
        self.now = max(self.now, due_ns + 7)  # each wake is 7 ns late


@pytest.fixture
def fake(monkeypatch: pytest.MonkeyPatch) -> FakeTime:
    made = FakeTime()
    monkeypatch.setattr(clock, "time", made)
    monkeypatch.setattr(clock, "sleep_until", made.sleep_until)
    return made


def test_any_work_gives_the_first_multiple_that_is_not_past(fake: FakeTime) -> None:
    periodic, found = PeriodicClock(1000, first_ns=100), []
    work = [10, 900, 993, 994, 3500, *((37 * k * k) % 4001 for k in range(200))]
    for took in [*work, 0]:
        found.append(periodic.wait())
        fake.now += took
    assert found[0] == (100, 107)
    for (due, wake), took, (following, _) in zip(found, work, found[1:], strict=False):
        assert wake == due + 7
        ready = wake + took  # 993 ends as the next is due; 994 is 1 ns late
        assert following == min(
            multiple for multiple in range(due + 1000, due + 9000, 1000) if multiple >= ready
        )
    assert periodic.skipped == (found[-1][0] - found[0][0]) // 1000 - len(work)


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


def waiter(filenos: list[int], longest_ms: float, shortest_ms: float = 0.0) -> EventWaiter:
    return EventWaiter(lambda: filenos, int(longest_ms * MS), int(shortest_ms * MS))


def test_what_arrives_begins_a_cycle(pipe) -> None:
    wait = waiter([pipe[0]], longest_ms=60_000)
    os.write(pipe[1], b"x")
    due, wake = wait.wait()
    assert due == wake
    again, _ = wait.wait()  # it was not read
    assert again >= wake
    os.read(pipe[0], 1)
    assert wait.skipped == 0


def test_a_cycle_begins_when_nothing_arrives(pipe) -> None:
    before = time.monotonic_ns()
    wait = waiter([pipe[0]], longest_ms=5)
    made = time.monotonic_ns()
    due, wake = wait.wait()
    assert before - MS < due - 5 * MS <= made
    assert due <= wake
    due, later = wait.wait()
    assert due == wake + 5 * MS or due == later
    slow = waiter([], longest_ms=3)  # without any source
    first, second = slow.wait(), slow.wait()
    assert second[1] - first[1] >= 2 * MS


def test_a_closed_end_does_not_take_the_processor(pipe) -> None:
    wait = waiter([pipe[0]], longest_ms=1000, shortest_ms=2)
    os.close(pipe[1])
    wakes = [wait.wait()[1] for _ in range(6)]
    assert all(b - a >= 2 * MS for a, b in pairwise(wakes))


def test_long_cycles_leave_the_processor_to_others_now_and_then(pipe) -> None:
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


def test_descriptors_of_a_function_are_asked_for_again(
    pipe, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clock, "AGAIN_NS", 0)
    there: list[int] = []
    wait = waiter(there, longest_ms=1)
    os.write(pipe[1], b"x")
    wait.wait()
    there.append(pipe[0])
    due, wake = wait.wait()
    assert due == wake
    assert wait._watched == (pipe[0],)
    os.read(pipe[0], 1)
    there.clear()
    wait.wait()
    assert wait._watched == ()


def test_waiting_leaves_no_memory_behind(pipe) -> None:
    os.write(pipe[1], b"x")
    event = EventWaiter(lambda: [pipe[0]], longest_ns=MS, shortest_ns=0)
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


def test_a_descriptor_that_was_closed_wakes_once(pipe) -> None:
    wait = waiter([pipe[0]], longest_ms=5)
    os.close(pipe[0])
    _, first = wait.wait()
    due, wake = wait.wait()
    assert first < due == min(first + 5 * MS, wake)


def test_impossible_times_are_refused() -> None:
    with pytest.raises(InputError, match="period_ns"):
        PeriodicClock(0)
    with pytest.raises(InputError, match="shortest_ns"):
        EventWaiter(list, longest_ns=MS, shortest_ns=2 * MS)


def test_work_before_a_cycle_may_end_late_without_skipping_it(fake: FakeTime) -> None:
    periodic = PeriodicClock(1000, first_ns=1000)
    assert periodic.wake_before(200)
    assert fake.now == 807
    assert periodic.wait() == (1000, 1007)
    assert periodic.wake_before(200)
    fake.now += 400  # until 2207: beyond the next due time, by less than half a period
    assert periodic.wait() == (2000, 2207)
    assert periodic.skipped == 0
    assert periodic.wake_before(200)
    fake.now += 900  # until 3707: by more
    assert periodic.wait() == (4000, 4007)
    assert periodic.skipped == 1
    fake.now = 4900
    assert not periodic.wake_before(200)  # too late to begin anything
    assert periodic.wait() == (5000, 5007)


def test_early_work_begins_as_soon_before_the_cycle_as_it_takes(
    fake: FakeTime, monkeypatch: pytest.MonkeyPatch
) -> None:
    from skinfield.loop import engine_process

    periodic = PeriodicClock(MS, first_ns=MS)
    monkeypatch.setattr(engine_process, "time", fake)
    begun = []

    def work() -> None:
        begun.append(periodic._due + MS - fake.now)  # type: ignore[operator]
        fake.now += 50_000

    before = engine_process.Prefetch(periodic, work)
    for _ in range(3000):
        before()
        due, wake = periodic.wait()
        assert wake - due == 7
    assert begun[0] == MS // 4 - 7
    assert abs(begun[-1] - 80_000) < 500  # what it takes, and the spare time
    assert periodic.skipped == 0


WIDTH = 1 / 64
NS = 1e-9


def counted(times: Iterable[int]) -> np.ndarray:
    counts = np.zeros(WORDS, np.uint64)
    for each in times:
        add_time(counts, int(each))
    return counts


@pytest.mark.parametrize("scale", [300.0, 20e3, 4e6, 1e9])
def test_quantiles_are_those_of_the_sorted_times_within_a_bin(scale: float) -> None:
    times = (scale * np.random.default_rng(1).lognormal(sigma=1.0, size=20_000)).astype(np.int64)
    times = np.minimum(times, TOP)
    found = quantiles(counted(times))
    ranked = np.sort(times)
    for thousandths, value in ((500, found.p50), (990, found.p99), (999, found.p999)):
        exact = ranked[thousandths * len(times) // 1000 - 1] * NS  # 20,000: without a remainder
        assert exact * (1 - 1e-12) <= value <= exact * (1 + WIDTH)
    assert found.max == pytest.approx(times.max() * NS, rel=1e-12)
    assert found.mean == pytest.approx(times.mean() * NS, rel=1e-12)
    assert found.count == len(times)


@given(st.integers(0, TOP))
def test_each_time_has_one_bin_that_holds_it(time: int) -> None:
    assert (np.diff(LAST_NS) > 0).all()  # without gaps
    assert (LAST_NS[0], LAST_NS[-1]) == (0, TOP)
    counts = counted([time])
    (at,) = np.flatnonzero(counts[:BINS])
    first = LAST_NS[at - 1] + 1 if at else 0
    assert first <= time <= LAST_NS[at]
    assert LAST_NS[at] - first <= time * WIDTH
    assert counts[LONGEST] == counts[SUM] == time


@given(st.lists(st.integers(-(2**63), 2**63 - 1), min_size=1, max_size=20))
def test_no_time_is_written_elsewhere(times: list[int]) -> None:
    memory = np.zeros(WORDS + 2, np.uint64)
    for each in times:
        add_time(memory[1:-1], each)
    assert memory[0] == memory[-1] == 0
    assert memory[1 : 1 + BINS].sum() == len(times)
    assert memory[1 + LONGEST] == max(0, *times)


def test_times_beyond_the_last_bin_keep_their_longest() -> None:
    found = quantiles(counted([10**12]))
    assert found.max == pytest.approx(1000.0)
    assert found.p50 == pytest.approx(TOP * NS)


def test_a_difference_has_the_times_since() -> None:
    rng = np.random.default_rng(2)
    early, late = rng.integers(10**6, 10**7, 5000), rng.integers(10**3, 10**5, 4000)
    before = counted(early)
    assert quantiles(before, before) is None
    found = quantiles(counted([*early, *late]), before)
    exact = np.percentile(late, 99, method="inverted_cdf") * NS
    assert exact * (1 - 1e-12) <= found.p99 <= exact * (1 + WIDTH)
    assert late.max() * NS * (1 - 1e-12) <= found.max <= late.max() * NS * (1 + WIDTH)
    assert found.mean == pytest.approx(late.mean() * NS)
    assert found.count == len(late)


def test_a_copy_of_a_later_time_is_refused() -> None:
    assert quantiles(np.zeros(WORDS, np.uint64)) is None  # nothing was counted
    with pytest.raises(InputError, match="earlier copy"):
        quantiles(np.zeros(WORDS, np.uint64), counted([5]))


def cycles(count: int) -> np.ndarray:
    """Made-up times of cycles: due, wake, acquired, ready, done, latency (-1 in every third)."""
    steps = np.random.default_rng(3).integers(0, 600_000, (count, 4))
    due = 10**12 + 10**6 * np.arange(count)
    times = np.column_stack((due, due[:, None] + np.cumsum(steps, axis=1)))
    latency = np.where(np.arange(count) % 3, 2 * steps[:, 2], -1)
    return np.column_stack((times, latency))


def test_a_table_counts_the_times_and_what_came_late() -> None:
    rows, deadline, period = cycles(2000), 900_000, 10**6
    table = TimingTable(period, deadline)
    for row in rows:
        table.add(*map(int, row))
    table.set_skipped(5)
    after = TimingTable(period, deadline, table.times, table.totals)  # of an engine started again
    after.set_skipped(2)
    found = Timing.of(table.times, table.totals)
    due, wake, acquired, ready, done, latency = rows.T
    expected = {
        "wake": wake - due,
        "acquired": acquired - wake,
        "ready": ready - wake,
        "latency": latency[latency >= 0],
        "cycle": done - wake,
    }
    for name in TIMES:
        exact, quantile = expected[name], getattr(found, name)
        assert quantile.count == len(exact)
        assert quantile.max == pytest.approx(exact.max() * NS)
        assert quantile.mean == pytest.approx(exact.mean() * NS)
    assert found.cycles == len(rows)
    assert found.late == (ready - due > deadline).sum() > 0
    assert found.overrun == (done - due > period).sum() > 0
    assert found.skipped == 5 + 2


def test_a_table_counts_into_the_fields_of_a_ring() -> None:
    arrays = [np.zeros(shape, dtype) for _, dtype, shape in FIELDS]
    table = TimingTable(10**6, times=arrays[0], totals=arrays[1])
    assert not any(array.any() for array in arrays)  # the rehearsal counts nothing
    for row in cycles(10):
        table.add(*map(int, row))
    before = [array.copy() for array in arrays]
    for row in cycles(25):
        table.add(*map(int, row))
    last = Timing.of(*arrays, before=(before[0], before[1]))
    assert last.cycles == last.wake.count == 25
    assert Timing.of(*arrays).cycles == 35


def test_a_timing_is_plain_numbers_for_json() -> None:
    table = TimingTable(10**6)
    table.add(0, 12_000, 13_000, 95_000, 96_000)
    found = Timing.of(table.times, table.totals).as_dict()
    assert set(found) == {*TOTALS, *(f"{name}_us" for name in TIMES)}
    assert found["latency_us"] is None
    assert found["wake_us"]["max"] == 12.0
    assert found["ready_us"]["count"] == 1
