"""Live rows of contacts against the finder's contacts, and against a brute force in time."""

import tracemalloc
from collections.abc import Iterator

import numpy as np
import pytest
from contact_scenes import bumps, grids, scenes
from engine_scenes import SKIN, engine_of, readings_of
from numpy.testing import assert_array_equal
from scipy.optimize import linear_sum_assignment

import skinfield as sf
from skinfield.errors import InputError
from skinfield.estimate import Contact, LiveContacts, PressureNoise, level_of
from skinfield.estimate.live_contacts import CONTACT
from skinfield.estimate.row_contacts import contacts_of_rows
from skinfield.estimate.track_memory import EVENTS
from skinfield.estimate.tracked import KINDS
from skinfield.estimate.tracking_kernel import pair_best
from skinfield.reconstruct.engine import SkinContacts
from skinfield.skin import Grid

GRID = grids()["hexagon"]
STILL = level_of(GRID, PressureNoise(np.zeros((len(GRID), 1))))


def rows_of(scene) -> tuple[np.ndarray, int]:
    level = level_of(scene.grid, scene.noise, scene.error, scene.model_error, scene.finder)
    live = LiveContacts([level], rows=len(scene.grid))
    out = np.zeros(len(scene.grid), CONTACT)
    return out, live(0, np.ascontiguousarray(scene.pressure, np.float64), 10**9, out)


def check_row(row: np.void, contact: Contact, grid: Grid) -> None:
    """Through both doors the same, to the last bit."""
    (same,) = contacts_of_rows(np.array([row]), grid, np.zeros(len(grid)), [contact.cells])
    for name in ("position", "normal", "force", "covariance", "area", "peak_pressure", "axes"):
        assert_array_equal(getattr(same, name), getattr(contact, name), err_msg=name)
    assert_array_equal(same.outline, contact.outline)
    assert row["cells"] == len(contact.cells)


@pytest.mark.parametrize("kind", list(grids()))
def test_rows_are_the_finders_contacts(kind: str) -> None:
    found = 0
    for scene in scenes(seed=22, each=3, kinds={kind: grids()[kind]}):
        rows, count = rows_of(scene)
        contacts = scene()
        assert count == len(contacts), scene.name
        for row, contact in zip(rows, contacts, strict=False):
            check_row(row, contact, scene.grid)
        found += count
    assert found > (0 if kind == "node" else 4)


def test_what_is_not_known_is_not_a_number() -> None:
    class Told:
        std, felt = np.zeros(len(GRID)), 0

        def covariance_of_sums(self, cells, weights):
            raise AssertionError

    live = LiveContacts([level_of(GRID, Told())])
    out = np.zeros(8, CONTACT)
    assert live(0, bumps(GRID, np.random.default_rng(0), 2).clip(0), 0, out) >= 1
    assert np.isnan(out[0]["force_std"])
    assert np.isnan(out[0]["place_std"])


def picture(cells: list[int]) -> np.ndarray:
    """Single pressed cells, each less than the one before."""
    pressure = np.zeros(len(GRID))
    pressure[cells] = 100.0 - np.arange(len(cells))
    return pressure


def wander(rng: np.random.Generator, steps: int) -> Iterator[tuple[int, np.ndarray]]:
    """Stamps and rows of balls that move, meet, part, vanish, and are weak at times."""
    now, count = 10**18, int(rng.integers(1, 6))
    places, ways = rng.uniform(-2e-2, 2e-2, (count, 2)), rng.normal(0.0, 4e-2, (count, 2))
    forces = rng.uniform(0.05, 3.0, count)
    for _ in range(steps):
        passed = int(rng.integers(1, 30)) * 10**6 if rng.random() > 0.02 else 2 * 10**9
        now, places = now + passed, places + ways * min(passed, 10**8) * 1e-9
        ways = np.where(np.abs(places) > 2e-2, -np.sign(places) * np.abs(ways), ways)
        near = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)) < 7e-3
        owner = near.argmax(axis=1)
        owner[rng.random(count) < 0.1] = -1
        rows = np.zeros(len({*owner} - {-1}), CONTACT)
        for row, each in zip(rows, sorted({*owner} - {-1}), strict=True):
            shares = forces * (owner == each)
            row["normal_force"] = shares.sum()
            place = shares @ places / shares.sum() + rng.normal(0.0, 4e-4, 2)
            row["x"], row["y"] = row["position"][:2] = place
            row["normal"][2], row["area"] = 1.0, 1e-5
            row["place_std"], row["force_std"] = 4e-4, 0.05
            row["covariance"] = (1.6e-7, 4e-8, 2e-7, 3e-6, -2e-6, 2.5e-3)
        yield now, rows[np.argsort(-rows["normal_force"])]


def test_a_live_robot_gets_what_the_tracker_promises() -> None:
    """The same contacts and stamps through both: equal numbers, ages and events, bit for bit."""
    flat = sf.Grid.square(sf.Patch(0.03 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])), nodes=3)
    level = level_of(flat, PressureNoise(np.zeros((len(flat), 1))))
    blank = dict.fromkeys(("pressure", "traction", "displacement", "pressure_std"), np.zeros(0))
    kinds, out = set(), np.zeros(8, CONTACT)
    for seed in range(40):
        live, tracker = LiveContacts([level], ids=np.full(1, -1)), sf.Tracker()
        for now, rows in wander(np.random.default_rng(seed), 60):
            start = int(live.memory.words[EVENTS])
            assert live.take(rows, len(rows), np.zeros(2), now, out) == len(rows)
            contacts = contacts_of_rows(rows, flat, np.zeros(len(flat)))
            rest = dict.fromkeys(("residual", "readings", "readings_std"), np.zeros(0))
            rest |= {"valid": np.ones(4, bool), "stamp_ns": now}
            tracked = tracker(sf.Estimate(grid=flat, contacts=contacts, **blank, **rest))
            ages = {int(row["track"]): float(row["age"]) for row in out[: len(rows)]}
            measured = {each.track_id: each for each in tracked if not each.is_coasting}
            assert {number: ages.get(number) for number in measured} == {
                number: each.age for number, each in measured.items()
            }
            for row in out[: len(rows)]:
                if row["track"] in measured:
                    known = measured[row["track"]]
                    assert row["speed"] == np.hypot(*known.velocity[:2])
                    assert_array_equal(known.measured.position[:2], (row["x"], row["y"]))
                else:  # not confirmed yet
                    assert row["normal_force"] < 5.0 * 0.06 or row["age"] == 0.0
            events = live.memory.events[np.arange(start, live.memory.words[EVENTS]) % 64]
            for event, known in zip(events, tracker.events, strict=True):
                assert (KINDS[event["kind"]], *event["ids"][: len(known.ids)]) == (
                    known.kind,
                    *known.ids,
                )
                assert_array_equal(event["place"], known.position[:2])
            kinds |= {e.kind for e in tracker.events}
    assert kinds == set(KINDS)


def test_pairs_are_the_best_as_a_whole() -> None:
    rng, work, lists = np.random.default_rng(8), np.zeros((3, 17)), np.zeros((3, 17), int)
    for _ in range(200):
        gains = rng.uniform(0.0, 30.0, np.sort(rng.integers(1, [9, 17])))
        gains[rng.random(gains.shape) < 0.3] = 0.0
        pair_best.py_func(gains, *gains.shape, work, *lists)
        match = lists[0, 1 : gains.shape[1] + 1]
        assert sorted(match[match > 0]) == list(range(1, len(gains) + 1))
        best = gains[linear_sum_assignment(gains, maximize=True)].sum()
        assert gains[match[match > 0] - 1, np.flatnonzero(match)].sum() == pytest.approx(best)


def test_what_lasts_can_be_put_back() -> None:
    one, other = (LiveContacts([STILL], rows=3) for _ in range(2))
    out, again = np.zeros(3, CONTACT), np.zeros(3, CONTACT)
    for step in range(40):
        cells = [400 + step, 900 + 2 * step][: 1 + step % 3]
        if step == 20:
            for mine, its in zip(other.memory, one.memory, strict=True):
                mine[:] = its
        count = one(0, picture(cells), step * 10**6, out)
        if step >= 20:
            assert other(0, picture(cells), step * 10**6, again) == count
            assert out[:count].tobytes() == again[:count].tobytes()
    one.reset()
    assert one(0, picture([400]), 41 * 10**6, out) == 1
    assert out[0]["track"] == one.memory.ids[0]


def test_age_and_speed_of_a_steady_contact() -> None:
    live, out = LiveContacts([STILL], rows=2), np.zeros(2, CONTACT)
    row = np.zeros(1, CONTACT)
    row["normal_force"], row["force_std"], row["place_std"] = 1.0, 0.03, 1e-4
    row["covariance"] = np.nan
    for step in range(400):
        row["x"] = 6e-5 * step
        assert live.take(row, 1, np.zeros(2), step * 10**6, out) == 1
        assert out[0]["age"] == pytest.approx(1e-3 * step)
    assert out[0]["speed"] == pytest.approx(0.06, rel=0.02)


def test_a_row_that_is_no_number_disturbs_no_other() -> None:
    live, out, numbers = LiveContacts([STILL]), np.zeros(8, CONTACT), set()
    for step in range(6):
        rows = np.zeros(3, CONTACT)
        rows["x"], rows["normal_force"], rows["force_std"] = (0.0, np.nan, 0.02), 1.0, 0.03
        rows["place_std"], rows["covariance"] = (1e-4, np.nan, np.nan), np.nan  # not known
        assert live.take(rows, 3, np.zeros(2), 10**9 + step * 10**7, out) == 3
        numbers.add((int(out[0]["track"]), int(out[2]["track"])))
    assert len(numbers) == 1


def test_nothing_is_allocated() -> None:
    rng = np.random.default_rng(3)
    noise, error = PressureNoise(np.zeros((len(GRID), 4))), None
    live, out = LiveContacts([level_of(GRID, noise, error)]), np.zeros(8, CONTACT)
    pressure = bumps(GRID, rng, 3).clip(0)
    live(0, pressure, 0, out)
    tracemalloc.start()
    try:
        for step in range(200):  # for what the compiler keeps of its arguments
            live(0, pressure, step * 10**6, out)
        before = tracemalloc.get_traced_memory()[0]
        for step in range(1000):
            live(0, pressure, step * 10**6, out)
        assert tracemalloc.get_traced_memory()[0] - before < 2000  # Python's own numbers
    finally:
        tracemalloc.stop()


def test_refusals() -> None:
    live = LiveContacts([STILL], rows=2)
    with pytest.raises(InputError, match="one per node"):
        live(0, np.zeros(5), 0, np.zeros(2, CONTACT))
    with pytest.raises(InputError, match="at most 2"):
        live(0, np.zeros(len(GRID)), 0, np.zeros(3, CONTACT))
    with pytest.raises(InputError, match="rows is 0"):
        LiveContacts([STILL], rows=0)


@pytest.mark.parametrize("solver", [sf.NonNegative(), sf.GaussianField()], ids=["search", "linear"])
def test_contacts_of_a_skin_are_those_of_its_estimates(solver) -> None:
    engine = engine_of(solver)
    live = SkinContacts(engine, rows=4)
    out, counts = np.zeros((len(SKIN), 4), CONTACT), np.zeros(len(SKIN), np.int64)
    readings = readings_of(SKIN, ("hexagon72", "moved"), seed=3)
    ids = []
    for step in range(3):
        estimates = engine(readings)
        live(step * 10**6, out, counts)
        for index, patch in enumerate(SKIN):
            contacts = estimates[patch.name].contacts
            assert counts[index] == len(contacts)
            for row, contact in zip(out[index], contacts, strict=False):
                check_row(row, contact, estimates[patch.name].grid)
                assert row["patch"] == index
        ids.append([out[i, : counts[i]]["track"].tolist() for i in range(len(SKIN))])
    assert sum(map(len, ids[0])) >= 2
    assert ids[0] == ids[1] == ids[2]
    numbers = [number for its in ids[0] for number in its]
    assert len(set(numbers)) == len(numbers)  # unique over the skin
