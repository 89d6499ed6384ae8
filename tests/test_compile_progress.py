"""What is known of the time of compilation, and how far it is said to be."""

import threading
from collections.abc import Iterator
from importlib import import_module
from types import SimpleNamespace

import numba
import pytest

from skinfield import compile_progress
from skinfield.compile_progress import CompileProgress, Known, followed, known_times

TIMES = Known(
    {"a.root": {"a.leaf": 2.0, "a.root": 1.0, "": 1.0}, "b.root": {"b.root": 6.0}},
    {"run": ["a.root", "b.root"], "reconstruct": ["a.root"], "linear": []},
)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    monkeypatch.setattr(compile_progress, "known_times", lambda: TIMES)
    return [100.0]


def event(name: str) -> SimpleNamespace:
    module, _, own = name.rpartition(".")
    function = SimpleNamespace(__module__=module, __qualname__=own)
    return SimpleNamespace(data={"dispatcher": SimpleNamespace(py_func=function)})


def progress_of(clock: list[float], cached: set[str], crowd: float = 1.0) -> CompileProgress:
    return CompileProgress("run", cached.__contains__, lambda: clock[0], lambda: crowd)


def steps(progress: CompileProgress, clock: list[float], pace: float) -> Iterator[float]:
    """Shares done while both are compiled at a pace, looked at each second of known time."""
    for name, end, seconds in (
        ("a.root", False, 1), ("a.leaf", False, 2), ("a.leaf", True, 1), ("a.root", True, 0),
        ("b.root", False, 9), ("b.root", True, 0),
    ):  # fmt: skip
        (progress.on_end if end else progress.on_start)(event(name))
        for _ in range(seconds + 1):
            yield progress.share
            clock[0] += pace if seconds else 0.0


@pytest.mark.parametrize("pace", [0.3, 1.0, 7.0])
def test_a_share_of_the_work_only_rises_from_none_to_all(clock: list[float], pace: float) -> None:
    progress = progress_of(clock, set())
    assert progress.seconds_left == pytest.approx(10.0)
    shares = list(steps(progress, clock, pace))
    assert shares == sorted(shares)
    assert 0.0 <= shares[0] <= 0.1
    assert shares[-1] == 1.0
    assert progress.seconds_left == 0.0


def test_the_time_that_is_left_goes_by_this_machines_pace(clock: list[float]) -> None:
    left = {}
    for pace in (1.0, 10.0):
        progress = progress_of(clock, set())
        for name, its in (("a.root", progress.on_start), ("a.root", progress.on_end)):
            its(event(name))
            clock[0] += 4.0 * pace if its == progress.on_start else 0.0
        assert progress.share == pytest.approx(0.4)
        left[pace] = progress.seconds_left
    assert left[1.0] == pytest.approx(6.0)
    assert 20.0 < left[10.0] < 60.0  # at ten times the known time for 4 of 10 s


@pytest.mark.parametrize("crowd", [1.0, 6.0])
def test_on_a_busy_machine_the_time_that_is_left_hardly_grows(
    clock: list[float], crowd: float
) -> None:
    pace = 6.0  # of six programs on a processor
    progress = progress_of(clock, set(), crowd)
    said = [progress.seconds_left]
    for _ in steps(progress, clock, pace):
        said.append(progress.seconds_left)
        assert said[-1] <= said[-2] + compile_progress.CLIMB * pace
    assert said[0] == pytest.approx(10.0 * crowd)
    assert max(said) <= (70.0 if crowd == 6.0 else 25.0)


def test_short_functions_count_when_those_beside_them_end(clock: list[float]) -> None:
    progress = progress_of(clock, set())
    progress.on_start(event("a.root"))
    progress.on_start(event("a.leaf"))
    progress.on_end(event("a.leaf"))
    assert progress.share == pytest.approx((2.0 + 1.0 * 2.0 / 3.0) / 10.0)


def test_what_the_cache_holds_is_no_work(clock: list[float]) -> None:
    assert progress_of(clock, {"a.root", "b.root"}).share == 1.0
    cached = {"a.root"}
    progress = progress_of(clock, cached)
    assert progress.seconds_left == pytest.approx(6.0)
    cached.add("b.root")  # by another process
    clock[0] += 2 * compile_progress.LOOKS
    assert progress.share == 1.0


def test_functions_are_followed_while_they_are_compiled() -> None:
    function = numba.njit(lambda x: x + 1)
    with followed("reconstruct") as progress:
        before = progress.share
        thread = threading.Thread(target=function, args=(1,))
        thread.start()
        thread.join()
        assert [function(1), function(1.5)] == [2, 2.5]
        assert not progress.is_going_on
    assert function("a" == "b") == 1
    assert progress.count == 2
    assert before <= progress.share <= 1.0


def test_all_that_has_a_known_time_is_there() -> None:
    known = known_times()
    for use, names in known.uses.items():
        assert set(names) <= set(known.seconds), use
        assert len(names) > 3
    assert set(known.uses["linear"]) < set(known.uses["run"])
    for name in known.seconds:
        module, _, function = name.rpartition(".")
        assert hasattr(getattr(import_module(module), function), "py_func"), name
    assert 10.0 < sum(sum(known.seconds[name].values()) for name in known.uses["run"]) < 200.0
