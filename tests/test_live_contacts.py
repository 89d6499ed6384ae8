"""Live rows of contacts against the finder's contacts, and against a brute force in time."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from contact_scenes import bumps, grids, scenes
from engine_scenes import SKIN, engine_of, readings_of

import skinfield as sf
from skinfield.errors import InputError
from skinfield.estimate import Contact, Habits, LiveContacts, PressureNoise, level_of
from skinfield.estimate.live_contacts import CONTACT, KNOWN
from skinfield.estimate.row_contacts import covariance_of
from skinfield.reconstruct.engine import SkinContacts
from skinfield.skin import Grid

GRID = grids()["hexagon"]
STILL = level_of(GRID, PressureNoise(np.zeros((len(GRID), 1))))
THINNED = 96  # cells of a region beyond which deviations are those of a sample


def rows_of(scene) -> tuple[np.ndarray, int]:
    level = level_of(scene.grid, scene.noise, scene.error, scene.model_error, scene.finder)
    live = LiveContacts([level], rows=len(scene.grid))
    out = np.zeros(len(scene.grid), CONTACT)
    return out, live(0, np.ascontiguousarray(scene.pressure, np.float64), 10**9, out)


def check_row(row: np.void, contact: Contact, grid: Grid) -> None:
    flat = grid.patch.surface.is_flat
    near = 1e-9 if flat else 0.05  # pitches that a curved skin leaves between its nodes
    assert np.linalg.norm(row["position"] - contact.position) < near * grid.pitch
    assert row["normal"] @ contact.normal > (1 - 1e-12 if flat else 0.995)
    assert row["normal_force"] == pytest.approx(contact.normal_force, rel=1e-9 if flat else 0.01)
    assert row["area"] == pytest.approx(contact.area, rel=1e-9)
    assert row["peak_pressure"] == contact.peak_pressure
    assert row["cells"] == len(contact.cells)
    xx, yy, xy = row["moments"]
    axes = 2.0 * np.sqrt(np.maximum(np.linalg.eigvalsh([[xx, xy], [xy, yy]])[::-1], 0.0))
    assert axes == pytest.approx(contact.axes, rel=1e-6, abs=1e-6 * grid.pitch)
    place = np.sqrt(0.5 * (contact.covariance[0, 0] + contact.covariance[1, 1]))
    exact = row["cells"] <= THINNED
    bracket = 1e-5 if exact else 0.35
    assert row["place_std"] == pytest.approx(place, rel=bracket, abs=1e-9 * grid.pitch)
    assert row["force_std"] == pytest.approx(np.sqrt(contact.covariance[2, 2]), rel=bracket)
    if exact and flat:
        scale = np.sqrt(np.diag(contact.covariance)) + np.array([1e-9, 1e-9, 1.0]) * grid.pitch
        off = (covariance_of(row) - contact.covariance) / np.outer(scale, scale)
        assert np.abs(off).max() < 1e-4


@pytest.mark.parametrize("kind", list(grids()))
def test_rows_are_the_finders_contacts(kind: str) -> None:
    found = 0
    for scene in scenes(seed=22, each=3, kinds={kind: grids()[kind]}):
        rows, count = rows_of(scene)
        contacts = scene()
        assert count == len(contacts), scene.name
        clear = [c for c in contacts if c.normal_force > 1e-5 * contacts[0].normal_force]
        for row in rows[: len(clear)]:
            like = [c for c in clear if c.peak_pressure == row["peak_pressure"]]
            away = [float(np.linalg.norm(c.position - row["position"])) for c in like]
            check_row(row, like[int(np.argmin(away))], scene.grid)
        found += len(clear)
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


def apart(point: tuple[float, float], known: list[float]) -> float:
    dx, dy = point[0] - known[1], point[1] - known[2]
    return float(np.sqrt(dx * dx + dy * dy))


def followed(steps, habits: Habits, rows: int) -> list[list[int]]:
    """Numbers of points (x, y), step by step, in plain Python."""
    memory: list[list[float]] = []  # track, x, y, last
    last, found = 0, []
    for now, points in steps:
        memory = [m for m in memory if abs(1e-9 * (now - m[3])) <= habits.hold]
        pairs = sorted(
            (apart(point, m), i, m[0], j)
            for i, point in enumerate(points)
            for j, m in enumerate(memory)
            if apart(point, m) <= habits.reach + habits.speed * 1e-9 * (now - m[3])
        )
        ids, taken = [0] * len(points), set()
        for _, i, _, j in pairs:
            if not ids[i] and j not in taken:
                ids[i] = int(memory[j][0])
                taken.add(j)
                memory[j][1:] = [*points[i], now]
        for i, point in enumerate(points):
            if not ids[i]:
                last += 1
                ids[i] = last
                memory.append([last, *point, now])
        found.append(ids)
    return found


def picture(cells: list[int]) -> np.ndarray:
    """Single pressed cells, each less than the one before."""
    pressure = np.zeros(len(GRID))
    pressure[cells] = 100.0 - np.arange(len(cells))
    return pressure


def test_numbers_last_as_a_brute_force_says() -> None:
    rng = np.random.default_rng(5)
    habits = Habits(reach=3e-3, speed=0.3, hold=0.02)
    live = LiveContacts([STILL], rows=6, habits=habits)
    now, steps, told = 0, [], []
    walkers = [(20, 20), (8, 30), (33, 9)]
    for _ in range(300):
        now += int(rng.integers(1, 12)) * 1_000_000
        walkers = [(min(max(a + rng.integers(-2, 3), 1), 38), b) for a, b in walkers]
        walkers = [(a, min(max(b + rng.integers(-2, 3), 1), 38)) for a, b in walkers]
        shown = [w for w in walkers if rng.random() < 0.8]
        distinct = [
            w
            for i, w in enumerate(shown)
            if all(np.hypot(*np.subtract(w, v)) > 2 for v in shown[:i])
        ]
        cells = [int(a * GRID.shape[1] + b) for a, b in distinct]
        out = np.zeros(6, CONTACT)
        count = live(0, picture(cells), now, out)
        assert count == len(cells)
        steps.append((now, [(float(r["x"]), float(r["y"])) for r in out[:count]]))
        told.append(out[:count]["track"].tolist())
    assert told == followed(steps, habits, 6)
    assert 3 < max(max(ids, default=0) for ids in told) < 200


def test_what_lasts_can_be_put_back() -> None:
    one, other = (LiveContacts([STILL], rows=3) for _ in range(2))
    out, again = np.zeros(3, CONTACT), np.zeros(3, CONTACT)
    for step in range(40):
        cells = [400 + step, 900 + 2 * step][: 1 + step % 3]
        if step == 20:
            other.memory[:], other.ids[:] = one.memory, one.ids
        count = one(0, picture(cells), step * 10**6, out)
        if step >= 20:
            assert other(0, picture(cells), step * 10**6, again) == count
            assert out[:count].tobytes() == again[:count].tobytes()
    assert one.memory.dtype == KNOWN
    one.reset()
    assert one(0, picture([400]), 41 * 10**6, out) == 1
    assert out[0]["track"] == one.ids[0]


def test_age_and_speed_of_a_steady_contact() -> None:
    live, out = LiveContacts([STILL], rows=2), np.zeros(2, CONTACT)
    for step in range(400):
        place = 0.05 * step
        cell, part = divmod(place, 1.0)
        pressure = np.zeros(len(GRID))
        line = 20 * GRID.shape[1] + 8 + int(cell)
        pressure[line], pressure[line + 1] = 100 * (1 - part), 100 * part
        live(0, pressure, step * 10**6, out)
    assert out[0]["age"] == pytest.approx(0.399)
    assert out[0]["speed"] == pytest.approx(0.05 * GRID.pitch * 1e3, rel=0.1)


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
    with pytest.raises(InputError, match="reach"):
        replace(Habits(), reach=0.0)


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
