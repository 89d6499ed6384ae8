"""Contacts over time: events, numbers that last and times, on contacts made by hand."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skinfield as sf
from skinfield.errors import InputError
from skinfield.estimate import ContactEvent, Motion, TrackedContact
from skinfield.estimate.tracking_kernel import track
from skinfield.skin.generators import cylinder

PATCH = sf.Patch(np.array([(-0.03, -0.03), (0.03, -0.03), (0.03, 0.03), (-0.03, 0.03)]))
GRID = sf.Grid.square(PATCH, nodes=3)
STEP = 0.02
REST = ("pressure", "traction", "displacement", "pressure_std", "residual", "valid")
REST += ("readings", "readings_std")
Place = tuple[float, float, float]  # x mm, y mm, force N


def contact(
    x: float, y: float, force: float, place_std: float = 2e-4, force_std: float = 0.05
) -> sf.Contact:
    """A contact at x, y mm."""
    place = np.array([1e-3 * x, 1e-3 * y, 0.0])
    return sf.Contact(
        position=place,
        force=np.array([0.0, 0.0, -force]),
        moment=np.array([0.0, 0.0, 1e-3]),
        normal=np.array([0.0, 0.0, 1.0]),
        area=1e-5,
        peak_pressure=2e5,
        covariance=np.diag([place_std**2, place_std**2, force_std**2]),
        area_std=1e-6,
        radius=1.8e-3,
        shape="sphere",
        outline=place + np.zeros((5, 3)),
        axes=np.array([1.8e-3, 1.8e-3]),
        angle=0.0,
        cells=np.arange(2),
    )


def estimate(
    contacts: Sequence[sf.Contact], stamp_ns: int = 0, grid: sf.Grid = GRID
) -> sf.Estimate:
    rest = dict.fromkeys(REST, np.zeros(0))
    return sf.Estimate(grid=grid, contacts=tuple(contacts), stamp_ns=stamp_ns, **rest)


def seen(*places: Place) -> sf.Estimate:
    return estimate([contact(*place) for place in places])


def follow(
    tracker: sf.Tracker, readings: Sequence[Sequence[Place]]
) -> tuple[list[tuple[TrackedContact, ...]], list[ContactEvent]]:
    """What each reading gives, and all events."""
    found, events = [], []
    for places in readings:
        found.append(tracker(seen(*places)))
        events += tracker.events
    return found, events


def told(events: Sequence[ContactEvent]) -> list[tuple[str, tuple[int, ...]]]:
    return [(event.kind, event.ids) for event in events]


def test_a_contact_that_stays_keeps_its_number_and_gets_surer() -> None:
    tracker = sf.Tracker()
    found, events = follow(tracker, [[(3.0, -2.0, 1.0)]] * 50)
    assert told(events) == [("made", (0,))]
    (last,) = found[-1]
    assert isinstance(last, sf.Contact)
    assert last.track_id == 0
    assert last.position == pytest.approx([3e-3, -2e-3, 0.0], abs=1e-9)
    assert last.normal_force == pytest.approx(1.0, abs=1e-9)
    assert last.moment == pytest.approx([0.0, 0.0, 1e-3])
    assert last.place_std < last.measured.place_std
    assert last.force_std < last.measured.force_std
    assert last.velocity == pytest.approx(0.0, abs=1e-9)
    assert last.age == last.duration == last.since_slip == pytest.approx(49 * STEP)
    assert not last.is_coasting
    assert not last.is_slipping


def test_the_filter_is_the_textbooks() -> None:
    """Against the matrices of a constant-velocity Kalman filter, written out."""
    motion = Motion(false_onsets=0.0)
    tracker = sf.Tracker(motion=motion)
    rng = np.random.default_rng(0)
    noise = np.array([[4e-8, 1e-8, 2e-6], [1e-8, 9e-8, -3e-6], [2e-6, -3e-6, 4e-3]])
    along = np.eye(6) + STEP * np.eye(6, k=3)
    push = np.diag([motion.acceleration**2 * 0.1] * 2 + [motion.force_rate**2 / 0.1])
    grow = np.block([[push * STEP**3 / 3, push * STEP**2 / 2], [push * STEP**2 / 2, push * STEP]])
    look = np.eye(3, 6)
    mean, spread = np.zeros(6), np.zeros((6, 6))
    for index in range(12):
        value = np.array([1e-3, -2e-3, 1.2]) + rng.multivariate_normal(np.zeros(3), noise)
        measured = replace(contact(1e3 * value[0], 1e3 * value[1], value[2]), covariance=noise)
        (found,) = tracker(estimate([measured]))
        floored = noise + np.diag([1e-10, 1e-10, 1e-6])
        if index == 0:
            mean[:3], spread[:3, :3] = value, floored
            spread[3:, 3:] = np.diag([motion.first_speed**2] * 2 + [motion.first_force_rate**2])
            continue
        mean, spread = along @ mean, along @ spread @ along.T + grow
        gain = spread @ look.T @ np.linalg.inv(look @ spread @ look.T + floored)
        mean = mean + gain @ (value - look @ mean)
        spread = (np.eye(6) - gain @ look) @ spread
        assert found.position[:2] == pytest.approx(mean[:2], rel=1e-9)
        assert found.normal_force == pytest.approx(mean[2], rel=1e-9)
        assert found.velocity[:2] == pytest.approx(mean[3:5], rel=1e-7, abs=1e-9)
        assert found.force_rate == pytest.approx(mean[5], rel=1e-7, abs=1e-9)
        assert found.covariance == pytest.approx(spread[:3, :3], rel=1e-7)
        assert found.velocity_covariance == pytest.approx(spread[3:5, 3:5], rel=1e-7)
        assert found.force_rate_std == pytest.approx(np.sqrt(spread[5, 5]), rel=1e-7)


def test_the_force_follows_a_sudden_touch_within_a_reading() -> None:
    slow = sf.Tracker(motion=Motion(false_onsets=0.0))
    for tracker, low, high in ((sf.Tracker(), 1.95, 2.05), (slow, 1.0, 1.9)):
        found, _ = follow(tracker, [[(0.0, 0.0, 0.3)]] * 20 + [[(0.0, 0.0, 2.0)]])
        assert low < found[-1][0].normal_force < high


def test_a_sliding_contact_moves_and_then_rests() -> None:
    rest, speed = [[(-10.0, 0.0, 1.0)]] * 25, 40.0
    slide = [[(-10.0 + speed * STEP * n, 0.0, 1.0)] for n in range(1, 26)]
    found, events = follow(sf.Tracker(), [*rest, *slide, *[slide[-1]] * 25])
    assert told(events) == [("made", (0,)), ("moved", (0,))]
    assert 0.0 < events[1].time - 24 * STEP <= 4 * STEP
    sliding = found[45][0]
    assert sliding.velocity == pytest.approx([0.04, 0.0, 0.0], abs=4e-3)
    assert sliding.speed == pytest.approx(0.04, abs=4e-3)
    assert sliding.is_slipping
    assert sliding.since_slip == 0.0
    after = found[-1][0]
    assert not after.is_slipping
    assert 15 * STEP < after.since_slip <= 25 * STEP


@pytest.mark.parametrize("rate", [100, 1000])
def test_noise_is_taken_for_an_onset_as_seldom_at_any_rate(rate: int) -> None:
    rng, rest, slide = np.random.default_rng(3), 60 * rate, rate // 2
    memory = sf.Tracker()._memory
    measured, bursts, fast, moving = memory.contacts[0], 0, False, []
    for index in range(rest + slide):
        x = 40e-3 * max(index - rest, 0) / rate
        measured["mean"] = rng.normal((x, 0.0, 1.0), (2e-4, 2e-4, 0.05))
        measured["covariance"] = np.diag([4e-8, 4e-8, 2.5e-3])
        track(memory, 1, round(1e9 * index / rate))
        known = memory.tracks[0]
        before, fast = fast, bool(np.hypot(*known["mean"][3:5]) > 20e-3)
        bursts += fast and not before and index < rest
        moving.append(bool(known["slips"]))
    assert bursts <= 9  # 3 are due, and less than one in a thousand has more than 9
    assert sum(moving[:rest]) < 0.1 * rate
    assert 0 < moving[rest:].index(True) < 0.1 * rate


def test_a_contact_that_is_not_seen_coasts_and_is_then_lost() -> None:
    readings: list[list[Place]] = [[(-10.0 + 0.8 * n, 0.0, 1.0)] for n in range(20)]
    found, events = follow(sf.Tracker(), [*readings, *[[]] * 7])
    coasting = found[22][0]
    assert coasting.is_coasting
    assert coasting.position[0] == pytest.approx(-10e-3 + 22 * 0.8e-3, abs=3e-4)
    assert coasting.duration == pytest.approx(19 * STEP)
    assert coasting.age == pytest.approx(22 * STEP)
    assert coasting.place_std > found[19][0].place_std
    assert [len(each) for each in found[20:]] == [1] * 5 + [0] * 2
    assert told(events)[-1] == ("lost", (0,))
    assert events[-1].time == pytest.approx(25 * STEP)


def test_a_gap_is_bridged() -> None:
    readings: list[list[Place]] = [[(-10.0 + 0.8 * n, 0.0, 1.0)] for n in range(30)]
    readings[15:20] = [[]] * 5
    found, events = follow(sf.Tracker(), readings)
    assert [kind for kind, _ in told(events)] == ["made", "moved"]
    assert {each[0].track_id for each in found} == {0}


def test_weak_contacts_are_told_when_they_are_seen_again() -> None:
    weak = estimate([contact(0.0, 0.0, 0.1, force_std=0.05)])
    tracker = sf.Tracker(weak_readings=3)
    assert [len(tracker(weak)) for _ in range(4)] == [0, 0, 1, 1]
    assert tracker(weak)[0].age == pytest.approx(4 * STEP)  # it counts from the first reading
    tracker.reset()
    assert [len(tracker(weak)) for _ in range(2)] == [0, 0]
    assert tracker(estimate([])) == ()
    assert [len(tracker(weak)) for _ in range(3)] == [0, 0, 1]  # in a row, or from the start
    assert len(sf.Tracker(weak_readings=1)(weak)) == 1


def two(distance: float, y: float = 0.0) -> list[Place]:
    """Two contacts so many mm apart along x, 1.5 and 1 N; one with their sum below 6 mm."""
    if np.hypot(distance, y) >= 6.0:
        return [(-distance / 2, -y / 2, 1.5), (distance / 2, y / 2, 1.0)]
    return [(-distance / 10, -y / 10, 2.5)]


def test_two_that_meet_merge_and_come_back_on_their_sides() -> None:
    distances = [*np.arange(20.0, 4.9, -0.6), *np.arange(5.0, 20.0, 0.6)]
    found, events = follow(sf.Tracker(), [two(d) for d in distances])
    kinds = [one for one in told(events) if one[0] != "moved"]
    assert kinds == [("made", (0,)), ("made", (1,)), ("merged", (0, 1)), ("split", (0, 1))]
    whole = next(each for each in found if len(each) == 1)[0]
    assert whole.track_id == 0  # the stronger
    assert whole.normal_force == pytest.approx(2.5, abs=0.05)
    last = {each.track_id: each for each in found[-1]}
    assert last[0].normal_force == pytest.approx(1.5, abs=0.05)
    assert last[0].position[0] < 0 < last[1].position[0]
    assert last[1].age == pytest.approx((len(distances) - 1) * STEP)


def test_two_that_pass_each_other_come_back_on_the_other_side() -> None:
    """Side by side at 5 mm, so that they merge for a while, with as much force."""
    readings = []
    for x in np.arange(-15.0, 15.1, 1.0):
        if np.hypot(x, 5.0) >= 6.0:
            readings.append([(x / 2, -2.5, 1.0), (-x / 2, 2.5, 1.0)])
        else:
            readings.append([(0.0, 0.0, 2.0)])
    found, events = follow(sf.Tracker(), readings)
    kinds = [kind for kind, _ in told(events) if kind != "moved"]
    assert kinds == ["made", "made", "merged", "split"]
    first = {each.track_id: each.position[1] > 0 for each in found[0]}
    last = {each.track_id: each.position[1] > 0 for each in found[-1]}
    assert first == last  # each keeps to its side


BOTH: list[Place] = [(-4.0, 0.0, 1.5), (4.0, 0.0, 1.0)]
HALVES: list[Place] = [(-3.5, 0.0, 1.2), (5.25, 0.0, 0.8)]
MADE = [("made", (0,)), ("made", (1,))]


@pytest.mark.parametrize(
    ("readings", "expected"),
    [
        ([BOTH] * 10 + [BOTH[:1]] * 8, [*MADE, ("lost", (1,))]),  # not merged
        ([BOTH[:1]] * 10 + [BOTH] * 8, MADE),  # not split
        ([[(0.0, 0.0, 2.0)]] * 10 + [HALVES] * 8, [MADE[0], ("split", (0, 1))]),
        (
            ([[(2.0, 2.0, 1.0)]] * 6 + [[]] * 8) * 3,  # taps
            [(kind, (n,)) for n in range(3) for kind in ("made", "lost")],
        ),
    ],
    ids=["vanishes", "comes", "splits", "taps"],
)
def test_events_of_contacts_that_come_and_go(
    readings: list[list[Place]], expected: list[tuple[str, tuple[int, ...]]]
) -> None:
    found, events = follow(sf.Tracker(), readings)
    assert told(events) == expected
    if expected[-1][0] == "split":
        sides = {each.track_id: each.position[0] > 0 for each in found[-1]}
        assert sides == {0: False, 1: True}


def test_after_the_memory_a_split_gives_a_new_number() -> None:
    readings = [two(d) for d in np.arange(20.0, 4.9, -0.6)]
    readings += [two(5.0)] * 60 + [two(d) for d in np.arange(5.0, 20.0, 0.6)]
    _, events = follow(sf.Tracker(memory=1.0), readings)
    kinds = [one for one in told(events) if one[0] != "moved"]
    assert kinds[2:] == [("merged", (0, 1)), ("split", (0, 2))]


def test_two_that_cross_at_12_mm_keep_their_numbers() -> None:
    rng = np.random.default_rng(3)
    readings = []
    for x in np.arange(-20.0, 20.0, 0.8):
        off = rng.normal(scale=0.4, size=4)
        readings.append([(x + off[0], -6 + off[1], 1.0), (-x + off[2], 6 + off[3], 1.0)])
    found, events = follow(sf.Tracker(), readings)
    assert sorted({kind for kind, _ in told(events)}) == ["made", "moved"]
    assert [{e.track_id: e.position[1] > 0 for e in each} for each in found] == [
        {e.track_id: e.position[1] > 0 for e in found[0]}
    ] * len(found)


def test_times_come_from_stamps() -> None:
    tracker = sf.Tracker(period=123.0)
    start = 1_700_000_000_000_000_000
    for n in range(3):
        (found,) = tracker(estimate([contact(n, 0.0, 1.0)], start + n * 100_000_000))
    assert found.age == pytest.approx(0.2)
    assert found.velocity[0] == pytest.approx(0.01, rel=0.05)
    with pytest.raises(InputError, match="expected after 1700000000200000000"):
        tracker(estimate([], start))
    tracker.reset()
    assert tracker(estimate([contact(0.0, 0.0, 1.0)], start))[0].track_id == 1
    assert tracker.events[0].stamp_ns == start


@pytest.mark.parametrize(
    ("pause", "x", "force", "same"),
    [
        (0.9, 0.3, 1.0, True),
        (2.0, 0.3, 1.0, True),
        (9.9, 0.3, 1.3, True),
        (10.1, 0.0, 1.0, False),  # nobody knows what happened meanwhile
        (2.0, 7.5, 1.0, False),  # elsewhere
        (2.0, 0.0, 3.0, False),  # harder by far
        (2.0, 0.0, None, False),  # readings that go on without it
    ],
)
def test_a_contact_goes_on_after_a_pause_of_readings_where_it_was(
    pause: float, x: float, force: float | None, same: bool
) -> None:
    tracker, second = sf.Tracker(), 1_000_000_000
    for step in range(5):  # at 2 mm/s, until the readings stop
        tracker(estimate([contact(0.2 * step - 0.8, 0.0, 1.0)], second + step * second // 10))
    stamp = second + 4 * second // 10 + round(pause * second)
    if force is None:
        for _ in range(8):
            tracker(estimate([], stamp := stamp + second // 50))
    found = tracker(estimate([contact(x, 0.0, force or 1.0)], stamp + second // 50))
    assert [each.track_id for each in found if not each.is_coasting] == [0 if same else 1]
    kinds = [kind for kind, _ in told(tracker.events) if kind != "moved"]
    assert kinds == ([] if same else ["made"] if force is None or x == 7.5 else ["lost", "made"])


def test_a_run_of_readings_gives_what_single_ones_give() -> None:
    reconstruct = sf.Reconstructor(
        sf.layouts.hexagon72(), solver=sf.GaussianField(), quantity=sf.BaseStress(), noise_std=400.0
    )
    readings = 400.0 * np.random.default_rng(1).normal(size=(6, 72))
    readings[:, 20] += 3e4
    whole, single = sf.Tracker(), sf.Tracker()
    runs = whole(reconstruct(readings))
    events = whole.events
    ones = [(single(reconstruct(reading)), single.events) for reading in readings]
    assert told(events) == told([event for _, each in ones for event in each])
    for run, (one, _) in zip(runs, ones, strict=True):
        assert [c.track_id for c in run] == [c.track_id for c in one]
        for a, b in zip(run, one, strict=True):
            assert a.position == pytest.approx(b.position, abs=1e-9)


def test_another_patch_is_refused() -> None:
    tracker = sf.Tracker()
    tracker(estimate([]))
    with pytest.raises(InputError, match="take a tracker for each patch"):
        tracker(estimate([], grid=sf.Grid.square(sf.layouts.hexagon72(), nodes=4)))


def test_a_covariance_that_is_none_is_refused() -> None:
    broken = replace(contact(0.0, 0.0, 1.0), covariance=np.full((3, 3), np.nan))
    with pytest.raises(InputError, match=r"contacts\[1\] has position"):
        sf.Tracker()(estimate([contact(5.0, 5.0, 1.0), broken]))


@pytest.mark.parametrize(
    ("name", "wrong"),
    [("period", 0.0), ("period", "a"), ("coast", -1.0), ("weak_readings", 0),
     ("weak_readings", 1.5), ("near", float("nan")), ("motion", 0.02), ("gate", "wide")],
)  # fmt: skip
def test_settings_are_checked(name: str, wrong: object) -> None:
    with pytest.raises(InputError, match=name):
        sf.Tracker(**{name: wrong})  # type: ignore[arg-type]


@pytest.mark.parametrize("wrong", [None, np.zeros(72), []])
def test_what_is_no_estimate_is_refused(wrong: object) -> None:
    with pytest.raises(InputError, match=r"(?s)estimate is .*, expected an Estimate: what a Recon"):
        sf.Tracker()(wrong)  # type: ignore[arg-type]


def test_on_a_cylinder_the_plane_unrolls() -> None:
    patch = cylinder(radius=0.02, length=0.04)
    grid = sf.Grid.square(patch, nodes=12)
    middle = patch.plane.mean(axis=0)
    tracker = sf.Tracker()
    for n in range(15):
        plane = middle + np.array([1e-3 * n - 7e-3, 0.3e-3 * n])
        position = patch.surface.position_from_plane(plane[None])[0]
        normal = patch.surface.frame_from_plane(plane[None])[0][:, 2]
        one = replace(contact(0.0, 0.0, 1.0), position=position, force=-normal, normal=normal)
        (found,) = tracker(estimate([one], grid=grid))
    assert found.track_id == 0
    assert found.position == pytest.approx(position, abs=1e-4)
    assert found.normal == pytest.approx(normal, abs=0.02)
    assert abs(found.velocity @ found.normal) < 1e-9
    assert found.speed == pytest.approx(np.hypot(1e-3, 0.3e-3) / STEP, rel=0.03)


places = st.tuples(
    st.floats(-25.0, 25.0), st.floats(-25.0, 25.0), st.floats(0.05, 3.0), st.floats(0.05, 3.0)
)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.lists(places, max_size=5), min_size=1, max_size=12),
    st.randoms(use_true_random=False),
)
def test_numbers_are_never_doubled_or_given_again_and_order_does_not_matter(
    readings: list[list[tuple[float, float, float, float]]], random
) -> None:
    tracker, shuffled = sf.Tracker(), sf.Tracker()
    alive: set[int] = set()
    ended: set[int] = set()
    for reading in readings:
        contacts = [contact(x, y, force, 1e-3 * std, 0.1 * std) for x, y, force, std in reading]
        found = tracker(estimate(contacts))
        random.shuffle(contacts)
        again = shuffled(estimate(contacts))
        numbers = [each.track_id for each in found]
        assert len(set(numbers)) == len(numbers)
        assert numbers == [each.track_id for each in again]
        assert told(tracker.events) == told(shuffled.events)
        assert all(
            np.array_equal(a.position, b.position) for a, b in zip(found, again, strict=True)
        )
        assert all(np.isfinite(each.covariance).all() for each in found)
        assert all(np.linalg.eigvalsh(each.covariance)[0] > 0 for each in found)
        for event in tracker.events:
            if event.kind == "made":
                assert not set(event.ids) & (alive | ended)
            if event.kind == "lost":
                ended |= set(event.ids)
        alive |= set(numbers)
        assert not ended & set(numbers)
