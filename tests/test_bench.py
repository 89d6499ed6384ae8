"""Benchmark: what `skinfield bench` computes of its laps, and its two panels."""

import json
import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.errors import InputError
from skinfield.lab.bench import costs, machine, run, scene
from skinfield.lab.bench.costs import Answer, Call, Chain, run_chain
from skinfield.lab.bench.machine import laps, spread, undisturbed
from skinfield.lab.bench.picture import FLOOR, picture, written
from skinfield.lab.bench.run import miss
from skinfield.lab.bench.scene import LADDER, SMOKE, BenchSettings, bench_size
from skinfield.lab.paper import reconstruct_as_paper
from skinfield.reconstruct import Reconstructor
from skinfield.skin import Grid
from skinfield.solve import NonNegative

TINY = BenchSettings(size=replace(SMOKE, readings=3, nodes=10, grids=(10,)))


@pytest.fixture(scope="module")
def tiny() -> scene.Scene:
    return scene.make_scene(TINY)


class Scripted:
    """A contender that answers at once, with what it is told to."""

    name = "scripted"

    def __init__(self, pressure: np.ndarray) -> None:
        self.pressure, self.asked, self.resets = pressure, [], 0

    def reset(self) -> None:
        self.resets += 1

    def answer(self, readings: np.ndarray, deadline_ns: int | None) -> None:
        now = time.perf_counter_ns()
        self.asked.append((readings[0], None if deadline_ns is None else deadline_ns - now))

    def last(self) -> Answer:
        return Answer(self.pressure.astype(np.float32), gap=0.25, met=True, iterations=3)

    def contacts(self, pressure: np.ndarray) -> tuple:
        return ()


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=40))
def test_spread_is_of_the_sorted_values(values: list[float]) -> None:
    found = spread([*values, float("nan")], scale=2.0)
    ordered = 2.0 * np.sort(values)
    assert found["count"] == len(values)
    assert (found["min"], found["max"]) == (ordered[0], ordered[-1])
    for percent in (10, 50, 90, 99):
        place = percent / 100 * (len(values) - 1)  # between two of the sorted ones
        low, high = ordered[int(np.floor(place))], ordered[int(np.ceil(place))]
        between = low + (high - low) * (place - np.floor(place))
        assert found[f"p{percent}"] == pytest.approx(between, rel=1e-9, abs=1e-6)
    assert found["mean"] == pytest.approx(sum(ordered) / len(ordered), rel=1e-9, abs=1e-6)


def test_no_number_has_no_spread() -> None:
    assert spread([]) is None
    assert spread([float("nan"), float("inf")]) is None


def test_laps_are_counted_and_garbage_waits() -> None:
    import gc

    calls = []
    with undisturbed():
        assert not gc.isenabled()
        found = laps(lambda: calls.append(1), 7)
    assert gc.isenabled()
    assert (found.shape, len(calls)) == ((7,), 7)
    assert (found >= 0.0).all()


def test_fingers_move_as_fingers_do() -> None:
    count = 2000
    places, forces = scene.paths(count)
    apart = np.linalg.norm(places[:, 0] - places[:, 1], axis=1)
    assert apart.min() > 2 * scene.RADIUS  # balls do not meet
    assert forces.min() == pytest.approx(0.3, abs=0.01)
    assert forces.max() == pytest.approx(2.0, abs=0.01)
    speed = np.linalg.norm(np.diff(places, axis=0), axis=2) * scene.RATE
    assert 0.01 < np.median(speed) < speed.max() < 0.1  # some centimetres a second
    reach = np.abs(TINY.patch.plane).max(axis=0)
    assert (np.abs(places).max(axis=(0, 1)) < reach).all()


def test_readings_are_the_truth_and_noise(tiny: scene.Scene) -> None:
    assert len(tiny) == 3
    assert tiny.readings.shape == (scene.LEAD + 3, len(TINY.patch))
    noise = tiny.readings - tiny.exact
    assert noise.std() == pytest.approx(TINY.noise, rel=0.1)
    assert abs(noise.mean()) < 4 * TINY.noise / noise.size**0.5
    distance = np.linalg.norm(TINY.patch.plane - tiny.places[-1][:, None], axis=2).min(axis=0)
    highest = int(tiny.readings[-1].argmax())
    assert tiny.readings[-1][highest] > 10 * TINY.noise
    assert distance[highest] < 6e-3  # of a finger: a taxel sees no farther
    assert np.array_equal(tiny.part(-1, 3), tiny.readings)
    assert np.array_equal(tiny.part(0, 2), tiny.readings[: scene.LEAD + 2])
    assert np.array_equal(tiny.part(3, 1), tiny.readings[: scene.LEAD + 1])


def test_a_chain_has_deadlines_of_its_own_and_no_lead() -> None:
    readings = np.arange(6.0)[:, None]
    warm, cold = Scripted(np.ones(4)), Scripted(np.ones(4))
    chain = run_chain(warm, readings, 0.5, cold=False, lead=2)
    assert [first for first, _ in warm.asked] == list(range(6))
    assert all(0 < left <= 500_000_000 for _, left in warm.asked)
    assert (warm.resets, len(chain.seconds), len(chain.answers)) == (1, 4, 4)
    run_chain(cold, readings, None, cold=True, lead=2)
    assert cold.resets == 7
    assert all(left is None for _, left in cold.asked)


def track_of(deadline: float | None, pressure: float, reference: np.ndarray) -> run._Track:
    return run._Track(Scripted(np.full(4, pressure)), "warm", deadline, reference)


def test_a_point_says_error_lateness_and_share_in_time(tiny: scene.Scene) -> None:
    reference = np.array([[2.0, 2, 2, 2], [4, 4, 4, 4], [1, 1, 1, 1]])
    track = track_of(1e-3, 1.0, reference)
    for seconds in ([0.5e-3, 2e-3, 1e-3], [0.5e-3, 4e-3, 3e-3]):
        answers = [track.contender.last()] * 3
        track.take(Chain(np.array(seconds), answers), tiny, TINY)
    point = track.point()
    # Differences 1, 3, 0 per node against 2, 4, 1: relative 0.5, 0.75, 0.
    assert point.error == pytest.approx(np.sqrt((1 + 9) / (4 + 16 + 1)))
    assert point.errors["p50"] == pytest.approx(0.5)
    assert point.usual_errors["count"] == 3
    assert point.usual_seconds["max"] == pytest.approx(3e-3)  # median of 2 and 4 ms
    assert point.met == pytest.approx(3 / 6)
    assert point.late["max"] == pytest.approx(3e-3)
    assert point.late["min"] == 0.0
    assert (point.gap["p50"], point.reported, point.iterations["max"]) == (0.25, 1.0, 3)
    assert (point.missed, point.extra, point.place_median) == (2.0, 0.0, None)
    assert point.force["p50"] == 1.0  # nothing found: all of the force is missing


def test_without_a_deadline_nothing_is_late(tiny: scene.Scene) -> None:
    track = track_of(None, 1.0, np.ones((3, 4)))
    track.take(Chain(np.ones(3), [track.contender.last()] * 3), tiny, TINY)
    point = track.point()
    assert (point.late, point.met, point.error) == (None, None, 0.0)


@given(st.lists(st.floats(0, 1), max_size=9), st.integers(1, 9))
def test_a_missed_finger_is_infinitely_far(found: list[float], missed: int) -> None:
    ordered = sorted([*found, *[float("inf")] * missed])
    middle = run.median_of_all(found, missed)
    half = ordered[len(ordered) // 2]
    if half == float("inf"):
        assert middle is None
    else:
        assert ordered[(len(ordered) - 1) // 2] <= middle <= half


def test_a_contact_beside_its_finger_and_one_that_is_none() -> None:
    from dataclasses import dataclass

    @dataclass
    class Found:
        position: np.ndarray
        normal_force: float

    places, forces = np.array([[0.0, 0.0], [20e-3, 0.0]]), np.array([1.0, 3.0])
    found = [
        Found(np.array([1e-3, 0, 0]), 0.5),
        Found(np.array([-20e-3, 0, 0]), 1.5),
    ]
    error = miss(TINY.patch, places, forces, found)
    assert error.force == pytest.approx(0.5)  # 2 N of 4 N
    assert error.place == pytest.approx((1e-3,))
    assert (error.missed, error.extra) == (1, 1)


def test_contenders_answer_as_a_reconstructor_does(tiny: scene.Scene) -> None:
    nodes, reading = 10, tiny.readings[-1]
    model = costs.model_of(TINY, nodes)
    for made, solver in (
        (costs.gaussian("g", TINY, nodes), costs.GaussianField()),
        (costs.non_negative("n", model, NonNegative()), NonNegative()),
    ):
        made.reset()
        made.answer(reading, None)
        grid = Grid.square(TINY.patch, nodes=nodes)
        estimate = Reconstructor(
            TINY.patch, TINY.layer, grid, quantity=TINY.quantity, solver=solver,
            noise_std=TINY.noise,
        )(reading)  # fmt: skip
        size = np.abs(estimate.pressure).max()
        assert made.last().pressure == pytest.approx(estimate.pressure, abs=1e-4 * size)
        found = made.contacts(made.last().pressure)
        assert [c.normal_force for c in found] == pytest.approx(
            [c.normal_force for c in estimate.contacts], rel=1e-3
        )


def test_the_papers_inverse_prepared_is_its_algorithm(tiny: scene.Scene) -> None:
    grid = Grid.square(TINY.patch, nodes=10)
    made = costs.paper_prepared("paper", TINY, 10)
    made.answer(tiny.readings[-1], None)
    printed = reconstruct_as_paper(
        tiny.readings[-1], TINY.patch.plane, grid.plane, TINY.layer, grid.cell_area
    )
    pressure = printed.force / grid.cell_area
    off = np.abs(made.last().pressure - pressure) / np.abs(pressure).max()
    # Where four taxels lie on a circle, a Delaunay triangulation may have either diagonal.
    assert np.median(off) < 1e-5
    assert off.max() < 0.03


def test_what_converged_is_no_worse_than_what_is_compared_with_it(tiny: scene.Scene) -> None:
    model = costs.model_of(TINY, 10)
    exact, long = (
        costs.non_negative("n", model, solver) for solver in (costs.CONVERGED, costs.LONG)
    )
    for made, gap in ((exact, 1e-9), (long, 1e-5)):
        made.answer(tiny.readings[-1], None)
        assert 0.0 <= made.last().gap <= gap
        assert made.last().met


def bench(points: list[run.Point], times: list[costs.GridTime]) -> run.Bench:
    call = Call(
        solver="NonNegative", deadline=2e-5, seconds=spread([1e-5]), latency=None, gap=None,
        reported=1.0, late=spread([0.0]),
    )  # fmt: skip
    return run.Bench(
        size="smoke", seed=0, when="2024-01-01T00:00:00+00:00", machine=machine.this_machine(),
        company=machine.Company(0.1, 0.0, 0.0, 1.0), warnings=(), nodes=10, readings=3,
        grids=tuple(times), points=tuple(points), calls=(call,),
    )  # fmt: skip


def test_numbers_have_their_units(tiny: scene.Scene) -> None:
    track = track_of(20e-6, 1.0, np.ones((3, 4)))
    track.take(Chain(np.full(3, 30e-6), [track.contender.last()] * 3), tiny, TINY)
    times = [costs.GridTime(10, costs.PAPER, spread([1e-3, 3e-3]))]
    measured = bench([track.point()], times)
    read = json.loads(json.dumps(run.bench_as_json(measured), allow_nan=False))
    assert read["format"] == 1
    assert set(read["machine"]) == {"processor", "cores", "system", "python", "packages", "blas"}
    assert read["grids"][0]["seconds_us"]["mean"] == 2000.0
    point = read["points"][0]
    assert (point["deadline_us"], point["seconds_us"]["p50"]) == (20.0, 30.0)
    assert point["late_us"]["p99"] == pytest.approx(10.0)
    assert point["place_mm"] is None
    assert read["calls"][0]["seconds_us"]["p50"] == 10.0


def test_the_papers_point_has_the_time_of_all_its_work() -> None:
    track = track_of(None, 1.0, np.ones((3, 4)))
    track.contender.name = costs.PAPER
    track.seconds, track.off = [np.ones(3)], [np.zeros(3)]
    track.misses = [miss(TINY.patch, np.zeros((1, 2)), np.ones(1), [])]
    times = [costs.GridTime(n, costs.PAPER, spread([n * 1e-3])) for n in (10, 20)]
    (point,) = run.as_printed([track.point()], times, 20)
    assert point.seconds["p50"] == point.usual_seconds["p50"] == pytest.approx(20e-3)
    assert point.error == 0.0


def test_sizes() -> None:
    assert [bench_size(name).name for name in ("smoke", "short", "full")] == [
        "smoke", "short", "full",
    ]  # fmt: skip
    assert bench_size("short").readings >= 100
    assert list(LADDER) == sorted(LADDER)
    assert (LADDER[0], LADDER[-1]) == pytest.approx((10e-6, 50e-3))
    with pytest.raises(InputError, match="size is 'long', expected one of full, short, smoke"):
        bench_size("long")


def test_company_is_worth_a_warning_when_it_costs() -> None:
    quiet = machine.Company(0.3, 0.02, 0.0, 1.0)
    assert quiet.warnings(2) == ()
    busy = replace(quiet, others=1.3, stolen=0.4)
    words = busy.warnings(2)
    assert "other processes used 1.3 of 2 cores" in words[0]
    assert "kept 0.4 cores away" in words[1]
    unknown = machine.Company(3.0, None, None, 1.0)
    assert "the load was 3.0 on 2 cores" in unknown.warnings(2)[0]


def test_the_watch_tells_others_from_itself(tmp_path, monkeypatch) -> None:
    ticks = 1000
    file = tmp_path / "stat"
    file.write_text(f"cpu {ticks} 0 0 5 0 0 0 7 0 0\n")
    clock, own = iter([10.0, 20.0]), iter([1.0, 9.0])
    monkeypatch.setattr(machine, "CPU_TIMES", file)
    monkeypatch.setattr(machine.os, "sysconf", lambda name: 100)
    monkeypatch.setattr(machine.time, "monotonic", lambda: next(clock))
    monkeypatch.setattr(machine.time, "process_time", lambda: next(own))
    watch = machine.Watch()
    file.write_text(f"cpu {ticks + 1100} 0 100 5 0 0 0 57 0 0\n")
    company = watch.company()
    assert company.own == pytest.approx(0.8)
    assert company.others == pytest.approx(0.4)  # 12 s busy in 10 s, 8 s of them our own
    assert company.stolen == pytest.approx(0.05)


def test_a_system_that_tells_nothing(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(machine, "CPU_TIMES", tmp_path / "none")
    monkeypatch.setattr(machine, "CPU_INFO", tmp_path / "none")
    company = machine.Watch().company()
    assert company.others is None
    assert company.stolen is None
    assert machine.this_machine().processor


def drawn_bench() -> run.Bench:
    def point(solver: str, start: str, error: float) -> run.Point:
        reference = np.ones((3, 4))
        track = run._Track(Scripted(np.ones(4)), start, None, reference)
        track.contender.name = solver
        track.seconds, track.off = [np.full(3, 1e-4)], [np.full(3, 2.0 * error)]
        track.misses = [miss(TINY.patch, np.zeros((1, 2)), np.ones(1), [])]
        return track.point()

    names = (costs.PAPER, costs.FIELD, "NonNegative to 1e-4, warm", "ContactFit")
    names += ("NonNegative to 1e-2, warm", costs.PREPARED)
    times = [costs.GridTime(n, name, spread([n * 1e-3])) for name in names for n in (10, 20)]
    starts = (("NonNegative", "warm", 0.0), ("NonNegative", "cold", 0.5), (costs.PAPER, "cold", 1))
    return bench([point(*each) for each in starts], times)


def test_costs_and_errors_are_drawn_with_their_units() -> None:
    figure = picture(drawn_bench())
    left, right = figure.axes
    assert {axes.get_xscale() + axes.get_yscale() for axes in figure.axes} == {"loglog"}
    assert [tick.get_text() for tick in left.get_xticklabels()] == ["10", "20"]
    assert left.get_lines()[0].get_ydata() == pytest.approx([10.0, 20.0])  # ms
    assert left.get_lines()[-1].get_ydata() == pytest.approx([0.4])  # as the paper states
    errors = [line.get_ydata()[0] for line in right.get_lines()]
    assert errors == pytest.approx([FLOOR, 50.0, 100.0])
    assert right.get_lines()[2].get_color() == left.get_lines()[0].get_color()  # the paper's
    (legend,) = figure.legends
    names = [text.get_text() for text in legend.get_texts()]
    assert len(names) == len(set(names))
    assert {"NonNegative, cold", "ContactFit"} <= set(names)
    assert any("NumPy" in text.get_text() or "numpy" in text.get_text() for text in figure.texts)


def test_the_legend_covers_nothing() -> None:
    figure = picture(drawn_bench())
    figure.canvas.draw()
    (legend,) = figure.legends
    box = legend.get_window_extent()
    assert box.x0 >= figure.bbox.x0
    assert box.x1 <= figure.bbox.x1
    assert not any(box.overlaps(axes.get_tightbbox()) for axes in figure.axes)


@pytest.mark.parametrize(
    ("value", "what", "text"),
    [
        (2e-5, "time", "20 µs"),
        (1e-3, "time", "1 ms"),
        (0.05, "time", "50 ms"),
        (1.0, "time", "1 s"),
        (5e-7, "time", "500 ns"),
        (1e-4, "share", "0.01 %"),
        (1.0, "share", "100 %"),
        (5e-4, "length", "0.5 mm"),
    ],
)
def test_numbers_as_they_stand_at_ticks(value: float, what: str, text: str) -> None:
    assert written(value, what) == text
