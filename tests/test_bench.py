"""Benchmark: what `skinfield bench` computes of its laps, and its two panels."""

import json
import time
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.elastic import BaseStress, BondedLayer
from skinfield.lab.bench import machine, run, scene
from skinfield.lab.bench.machine import spread
from skinfield.lab.bench.picture import FLOOR, picture
from skinfield.lab.bench.run import ContenderRun, miss
from skinfield.lab.bench.scene import NOISE, SMOKE, Contender, Laps, Outcome, run_chain
from skinfield.lab.paper import Method, paper_patch
from skinfield.solve import GaussianField, NonNegative

PATCH = paper_patch()
TINY = replace(SMOKE, readings=3, nodes=10, grids=(10,))


@pytest.fixture(scope="module")
def tiny() -> scene.BenchScene:
    return scene.make_scene(TINY)


def scripted(pressure: float, name: str = "scripted") -> tuple[Contender, list]:
    """A contender that answers at once, and what it was asked for; None for a reset."""
    asked: list = []

    def answer(readings: np.ndarray, deadline_ns: int | None) -> None:
        now = time.perf_counter_ns()
        asked.append((readings[0], None if deadline_ns is None else deadline_ns - now))

    last = Outcome(np.full(4, pressure, np.float32), tuple, gap=0.25)
    return Contender(name, answer, lambda: last, lambda: asked.append(None)), asked


def test_spread_is_of_the_numbers_alone() -> None:
    found = spread([3.0, float("nan"), 1.0, 2.0], scale=2.0)
    assert (found["count"], found["mean"], found["min"], found["max"]) == (3, 4.0, 2.0, 6.0)
    assert (found["p10"], found["p50"], found["p90"]) == pytest.approx((2.4, 4.0, 5.6))
    assert spread([float("nan"), float("inf")]) is None


def test_fingers_move_as_fingers_do() -> None:
    count = 2000
    places, forces = scene.paths(count)
    apart = np.linalg.norm(places[:, 0] - places[:, 1], axis=1)
    assert apart.min() > 2 * scene.RADIUS  # balls do not meet
    assert forces.min() == pytest.approx(0.3, abs=0.01)
    assert forces.max() == pytest.approx(2.0, abs=0.01)
    speed = np.linalg.norm(np.diff(places, axis=0), axis=2) * scene.RATE
    assert 0.01 < np.median(speed) < speed.max() < 0.1  # some centimetres a second
    reach = np.abs(PATCH.plane).max(axis=0)
    assert (np.abs(places).max(axis=(0, 1)) < reach).all()


def test_readings_are_the_truth_and_noise(tiny: scene.BenchScene) -> None:
    assert len(tiny) == 3
    assert tiny.readings.shape == (scene.LEAD + 3, len(PATCH))
    noise = tiny.readings - tiny.exact
    assert noise.std() == pytest.approx(NOISE, rel=0.1)
    assert abs(noise.mean()) < 4 * NOISE / noise.size**0.5
    distance = np.linalg.norm(PATCH.plane - tiny.places[-1][:, None], axis=2).min(axis=0)
    highest = int(tiny.readings[-1].argmax())
    assert tiny.readings[-1][highest] > 10 * NOISE
    assert distance[highest] < 6e-3  # of a finger: a taxel sees no farther
    assert np.array_equal(tiny.part(-1, 3), tiny.readings)
    assert np.array_equal(tiny.part(0, 2), tiny.readings[: scene.LEAD + 2])
    assert np.array_equal(tiny.part(3, 1), tiny.readings[: scene.LEAD + 1])


def test_a_chain_has_deadlines_of_its_own_and_no_lead() -> None:
    readings = np.arange(6.0)[:, None]
    (warm, asked), (cold, each) = scripted(1.0), scripted(1.0)
    chain = run_chain(warm, readings, 0.5, cold=False, lead=2)
    assert asked.pop(0) is None
    assert [first for first, _ in asked] == list(range(6))
    assert all(0 < left <= 500_000_000 for _, left in asked)
    assert (len(chain.seconds), len(chain.answers)) == (4, 4)
    run_chain(cold, readings, None, cold=True, lead=2)
    assert each == [None, *(part for n in range(6) for part in (None, (n, None)))]


def track_of(
    deadline: float | None, *seconds: list[float], name: str = "scripted", start: str = "warm",
    pressure: float = 1.0, reference: np.ndarray | None = None,
) -> ContenderRun:  # fmt: skip
    """A track whose chains took such times."""
    made, _ = scripted(pressure, name)
    chains = [Laps(np.array(each), [made.last()] * len(each)) for each in seconds]
    return ContenderRun(
        made, start, deadline, np.ones((3, 4)) if reference is None else reference, chains
    )


def test_a_point_says_time_and_error(tiny: scene.BenchScene) -> None:
    reference = np.array([[2.0, 2, 2, 2], [4, 4, 4, 4], [1, 1, 1, 1]])
    times = [0.5e-3, 2e-3, 1e-3], [0.5e-3, 4e-3, 3e-3]
    point = track_of(1e-3, *times, reference=reference).point(tiny)
    # Differences 1, 3, 0 per node against 2, 4, 1: relative 0.5, 0.75, 0.
    assert point["errors"]["p50"] == pytest.approx(0.5)
    assert point["usual_errors"]["count"] == 3
    assert point["usual_seconds_us"]["max"] == pytest.approx(3000)  # median of 2 and 4 ms
    assert (point["gap"]["p50"], point["missed"], point["place_median_mm"]) == (0.25, 2.0, None)
    assert point["deadline_us"] == 1000.0
    assert point["force"]["p50"] == 1.0  # nothing found: all of the force is missing
    assert json.loads(json.dumps(point, allow_nan=False)) == point


@given(st.lists(st.floats(0, 1), max_size=9), st.integers(1, 9))
def test_a_missed_finger_is_infinitely_far(found: list[float], missed: int) -> None:
    ordered = sorted([*found, *[float("inf")] * missed])
    middle, half = run.median_of_all(found, missed), ordered[len(ordered) // 2]
    assert (middle is None) == (half == float("inf"))
    assert middle is None or ordered[(len(ordered) - 1) // 2] <= middle <= half


def test_a_contact_beside_its_finger_and_one_that_is_none() -> None:
    places, forces = np.array([[0.0, 0.0], [20e-3, 0.0]]), np.array([1.0, 3.0])
    found = [
        SimpleNamespace(position=np.array([x, 0.0, 0.0]), normal_force=force)
        for x, force in ((1e-3, 0.5), (-20e-3, 1.5))
    ]
    force, place, missed = miss(places, forces, found)
    assert (force, place, missed) == (pytest.approx(0.5), pytest.approx((1e-3,)), 1)  # 2 N of 4 N


def test_contenders_answer_as_a_reconstructor_does(tiny: scene.BenchScene) -> None:
    nodes, reading = 10, tiny.readings[-1]
    model = scene.model_of(nodes)
    for made, solver in (
        (scene.gaussian("g", nodes), GaussianField()),
        (scene.iterative("n", model, NonNegative()), NonNegative()),
    ):
        made.reset()
        made.answer(reading, None)
        estimate = Method("", solver, BondedLayer(), BaseStress()).prepared(nodes, NOISE)(reading)
        size = np.abs(estimate.pressure).max()
        assert made.last().pressure == pytest.approx(estimate.pressure, abs=1e-4 * size)
        assert [c.normal_force for c in made.last().contacts()] == pytest.approx(
            [c.normal_force for c in estimate.contacts], rel=1e-3
        )


def test_the_papers_point_has_the_time_of_all_its_work(tiny: scene.BenchScene) -> None:
    point = track_of(None, [1.0] * 3, name=run.PAPER, pressure=1.5).point(tiny)
    times = [{"nodes": n, "name": run.PAPER, "seconds_us": spread([n * 1e3])} for n in (10, 20)]
    (found,) = run.as_printed([point], times, 20)
    assert found["seconds_us"]["p50"] == found["usual_seconds_us"]["p50"] == pytest.approx(20e3)
    assert (found["start"], found["errors"]["p50"]) == ("cold", pytest.approx(0.5))


def test_company_is_worth_a_warning_when_it_costs() -> None:
    quiet = {"others": 0.02, "stolen": 0.0, "own": 1.0}
    assert machine.warnings(quiet, 2) == []
    words = machine.warnings(quiet | {"others": 1.3, "stolen": 0.4}, 2)
    assert "other processes used 1.3 of 2 cores" in words[0]
    assert "kept 0.4 cores away" in words[1]


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
    assert company["own"] == pytest.approx(0.8)
    assert company["others"] == pytest.approx(0.4)  # 12 s busy in 10 s, 8 s of them our own
    assert company["stolen"] == pytest.approx(0.05)


def test_a_system_that_tells_nothing(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(machine, "CPU_TIMES", tmp_path / "none")
    monkeypatch.setattr(machine, "CPU_INFO", tmp_path / "none")
    company = machine.Watch().company()
    assert company["others"] is company["stolen"] is None
    assert machine.this_machine()["processor"]


def drawn_bench(tiny: scene.BenchScene) -> dict:
    def point(solver: str, start: str, error: float) -> dict:
        track = track_of(None, [1e-4] * 3, name=solver, start=start, pressure=1.0 + error)
        return track.point(tiny)

    names = (run.PAPER, run.FIELD, "NonNegative to 1e-4, warm", "ContactFit")
    names += ("NonNegative to 1e-2, warm", run.PREPARED)
    starts = (("NonNegative", "warm", 0.0), ("NonNegative", "cold", 0.5), (run.PAPER, "cold", 1))
    return {
        "when": "2024-01-01T00:00:00+00:00",
        "machine": machine.this_machine(),
        "warnings": [],
        "nodes": 10,
        "readings": 3,
        "grids": [
            {"nodes": n, "name": name, "seconds_us": spread([n * 1e3]), "certified": None}
            for name in names
            for n in (10, 20)
        ],
        "points": [point(*each) for each in starts],
    }


def test_costs_and_errors_are_drawn_with_their_units(tiny: scene.BenchScene) -> None:
    bench = drawn_bench(tiny)
    figure = picture(bench)
    left, right, true = figure.axes
    assert [axes.get_xscale() + axes.get_yscale() for axes in figure.axes] == [
        *("loglog", "loglog", "loglinear")
    ]
    assert [tick.get_text() for tick in left.get_xticklabels()] == ["10", "20"]
    assert left.get_lines()[0].get_ydata() == pytest.approx([10.0, 20.0])  # ms
    errors = [line.get_ydata()[0] for line in right.get_lines()]
    assert errors == pytest.approx([FLOOR, 50.0, 100.0])
    for panel in (right, true):
        assert panel.get_lines()[2].get_color() == left.get_lines()[0].get_color()  # the paper's
    off = [100 * row["force"]["p50"] for row in bench["points"]]
    assert [line.get_ydata()[0] for line in true.get_lines()] == pytest.approx(off)
    (legend,) = figure.legends
    names = [text.get_text() for text in legend.get_texts()]
    assert len(names) == len(set(names))
    assert {"NonNegative, cold", "ContactFit"} <= set(names)
    assert "numpy" in legend.get_title().get_text()
    figure.canvas.draw()
    box = legend.get_window_extent()
    assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
    assert not any(box.overlaps(axes.get_tightbbox()) for axes in figure.axes)
