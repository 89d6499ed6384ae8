"""Parts of the fit beside the engine: averages, numbers of contacts, whose contacts count."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.stats import norm

from skinfield.contacts.live import CONTACT
from skinfield.live.best import best_contacts
from skinfield.live.fit_reader import FitReader
from skinfield.live.fit_ring import FitSlot, Fitted, fit_name, is_fit, write_engine
from skinfield.live.fit_tracks import FIRST, FitTracks, Numbers
from skinfield.live.patch_fit import Accuracy, rounding_of
from skinfield.live.slots import PATCH
from skinfield.live.steady import GAP_NS, Mean, Steady

TAXELS, STEP_NS = 20, 10_000_000
NOISE = np.full(TAXELS, 0.002)
ALL = np.ones(TAXELS)
PRESSED = np.zeros(TAXELS)
PRESSED[:3] = 0.03, 0.02, 0.01


def readings(level: np.ndarray, count: int, seed: int) -> np.ndarray:
    return level + np.random.default_rng(seed).normal(0.0, 0.002, (count, TAXELS))


def fed(steady: Steady, rows: np.ndarray, start: int = 0) -> int:
    for number, row in enumerate(rows, start):
        steady.take(row, ALL, (number + 1) * STEP_NS)
    return start + len(rows)


def mean_of(steady: Steady) -> Mean:
    found = steady.mean(NOISE)
    assert found is not None
    return found


@pytest.mark.parametrize("count", [1, 2, 7, 32, 100])
def test_what_rests_is_averaged(count: int) -> None:
    steady, rows = Steady(TAXELS), readings(PRESSED, count, 1)
    fed(steady, rows)
    found = mean_of(steady)
    assert found.readings == count
    assert found.stamp_ns == count * STEP_NS
    assert_allclose(found.values, rows.mean(axis=0), atol=1e-12)


def test_no_more_readings_are_kept_than_asked_for() -> None:
    steady, rows = Steady(TAXELS, most=16), readings(PRESSED, 100, 2)
    fed(steady, rows)
    assert_allclose(mean_of(steady).values, rows[-16:].mean(axis=0), atol=1e-12)


@pytest.mark.parametrize("after", [1, 2, 3, 5, 11, 40])
def test_an_average_ends_where_the_touch_began(after: int) -> None:
    steady = Steady(TAXELS)
    start = fed(steady, readings(np.zeros(TAXELS), 64, 3))
    fed(steady, readings(PRESSED, after, 4), start)
    assert mean_of(steady).readings == after


def test_a_faint_touch_is_seen_to_begin_by_all_of_its_taxels_together() -> None:
    faint = np.zeros(TAXELS)
    faint[:8] = 3.0 * NOISE[:8]  # no taxel stands out of a single reading
    steady = Steady(TAXELS)
    start = fed(steady, readings(np.zeros(TAXELS), 64, 8))
    fed(steady, readings(faint, 24, 9), start)
    assert mean_of(steady).readings == 24


def test_readings_before_a_gap_do_not_count() -> None:
    steady = Steady(TAXELS)
    start = fed(steady, readings(PRESSED, 20, 5))
    steady.take(PRESSED, ALL, start * STEP_NS + GAP_NS + STEP_NS)
    assert mean_of(steady).readings == 1


def test_a_taxel_that_is_left_out_now_and_then_is_the_mean_of_its_own() -> None:
    steady, rows = Steady(TAXELS), readings(PRESSED, 8, 6)
    for number, row in enumerate(rows):
        valid = ALL.copy()
        valid[4] = number % 2
        valid[5] = 0.0
        steady.take(np.where(valid > 0, row, np.nan), valid, (number + 1) * STEP_NS)
    found = mean_of(steady)
    assert found.readings == 8
    assert found.values[4] == pytest.approx(rows[1::2, 4].mean())
    assert found.valid[4]
    assert not found.valid[5]
    assert found.values[5] == 0.0
    assert np.isinf(Accuracy(NOISE, 0.0 * NOISE).of(found)[5])


def test_nothing_is_known_before_the_first_reading() -> None:
    assert Steady(TAXELS).mean(NOISE) is None


@pytest.mark.parametrize("noise", [0.0, 0.2, 0.35, 0.5, 1.0])
def test_rounding_of_averages_against_the_expected_value_of_a_rounded_count(noise: float) -> None:
    places, counts = np.linspace(-0.5, 0.5, 201), np.arange(-8, 9)
    if noise:
        edges = norm.cdf((counts + 0.5 - places[:, None]) / noise)
        chance = np.diff(edges, axis=1, prepend=0.0)
    else:
        chance = (np.rint(places)[:, None] == counts).astype(float)
    off = chance @ counts - places
    total = np.full((1, 4), np.hypot(noise, 12**-0.5))
    found = rounding_of(total, np.array([total[0, 2]]))[0]
    worst = np.sqrt((off**2).mean())
    assert found == pytest.approx(worst, abs=0.02 * worst + 1e-6)


def contact(x: float, y: float, force: float = 1.0, track: int = 0, age: float = 0.0) -> Any:
    row = np.zeros(1, CONTACT)
    row["x"], row["y"], row["normal_force"], row["track"], row["age"] = x, y, force, track, age
    return row


def together(*rows: Any) -> Any:
    return np.concatenate([np.zeros(0, CONTACT), *rows])


def test_numbers_are_those_of_the_engine_and_last() -> None:
    tracks, stamp = FitTracks(Numbers()), 5_000_000_000
    rows = together(contact(0.0, 0.0), contact(0.02, 0.0))
    engine = together(contact(0.019, 0.002, track=7, age=0.5), contact(0.001, 0.0, track=4))
    tracks.number(rows, engine, stamp)
    assert_array_equal(rows["track"], [4, 7])
    assert_allclose(rows["age"], [0.0, 0.5])
    later = together(contact(0.0202, 0.0), contact(0.0, 0.001))
    tracks.number(later, together(contact(0.0, 0.0, track=9)), stamp + 20_000_000)
    assert_array_equal(later["track"], [7, 4])  # though the engine calls it 9 by now
    assert_allclose(later["age"], [0.52, 0.02])
    assert later["speed"][1] > later["speed"][0] > 0.0


def test_what_the_engine_does_not_see_has_a_number_of_its_own() -> None:
    numbers = Numbers()
    first, second = FitTracks(numbers), FitTracks(numbers)
    rows = together(contact(0.0, 0.0), contact(0.03, 0.0))
    first.number(rows, together(contact(0.015, 0.0, track=3)), 1_000_000_000)
    assert_array_equal(rows["track"], [FIRST, FIRST + 1])  # 15 mm away is another one
    again = together(contact(0.0, 0.0))
    second.number(again, together(), 1_000_000_000)
    assert again["track"][0] == FIRST + 2
    first.number(again, together(), 3_000_000_000)
    assert again["track"][0] == FIRST + 3  # after so long it is a new one


class Reader(FitReader):
    """Of a slot that is handed in."""

    def __init__(self, slot: FitSlot | None) -> None:
        self._newest = slot

    def latest(self) -> FitSlot | None:
        return self._newest


def snapshot(stamp_ns: int, contacts: Any, answer: int = 3) -> Any:
    patches = np.zeros(2, PATCH)
    patches["stamp_ns"], patches["answer"] = stamp_ns, answer
    patches["contacts"] = [(contacts["patch"] == n).sum() for n in range(2)]
    return SimpleNamespace(patches=patches, contacts=contacts)


def slot_of(stamp_ns: int, contacts: Any, touched: int = 1) -> FitSlot:
    slot = FitSlot.empty(2, 9, 4)
    slot.patches["state"][0] = int(Fitted.DONE)
    slot.patches["stamp_ns"], slot.patches["touched"] = stamp_ns, touched
    slot.patches["contacts"][0] = len(contacts)
    slot.contacts[0][: len(contacts)] = contacts
    slot.pressure[0] = 5.0
    return slot


def test_the_fits_contacts_count_where_it_has_kept_up() -> None:
    other = contact(0.0, 0.0, 2.0, track=5)
    other["patch"] = 1
    engine = together(contact(0.0, 0.0, 1.6, track=4, age=1.0), other)
    fit = Reader(slot_of(10**9, contact(0.001, 0.0, 1.0, track=4)))
    rows, by = best_contacts(snapshot(10**9 + STEP_NS, engine), fit)
    assert_array_equal(rows["normal_force"], [1.0, 2.0])
    assert by == ["fit", "engine"]
    assert_array_equal(fit.pressure(0), np.full(9, 5.0))
    assert fit.pressure(1) is None


def test_a_contact_that_began_since_is_the_engines() -> None:
    engine = together(
        contact(0.0, 0.0, 1.6, track=4, age=1.0),
        contact(0.01, 0.0, 0.3, track=8, age=1.0),  # of before: the fit does not have it
        contact(0.03, 0.0, 0.5, track=9, age=0.01),
        contact(0.003, 0.0, 0.5, track=10, age=0.01),  # the same as 4, by another number
    )
    fit = Reader(slot_of(10**9, contact(0.001, 0.0, 1.0, track=4)))
    rows, by = best_contacts(snapshot(10**9 + 2 * STEP_NS, engine), fit)
    assert_array_equal(rows["track"], [4, 9])
    assert by == ["fit", "engine"]


@pytest.mark.parametrize(
    "why", ["no fit", "not there", "old", "old and moved", "very old", "lifted", "unhelpful"]
)
def test_else_the_engines_count(why: str) -> None:
    engine = together(contact(0.0, 0.0, 1.6, track=4, age=1.0))
    slot, answer = slot_of(10**9, contact(0.001, 0.0, 1.0, track=4)), 3
    late = 10**9 if why in ("old", "old and moved") else 3 * 10**9 if why == "very old" else 0
    if why != "old":
        write_engine(slot.patches[0], contact(0.0, 0.0, 1.6))
    if why == "old and moved":
        engine["x"] += 5e-3
    if why == "lifted":
        engine, answer = engine[:0], 1
    if why == "unhelpful":
        slot.patches["state"] = int(Fitted.UNHELPFUL)
    fit = None if why == "no fit" else Reader(None if why == "not there" else slot)
    rows, by = best_contacts(snapshot(10**9 + late, engine, answer), fit)
    assert_array_equal(rows, engine)
    assert by == ["engine"] * len(engine)


def test_a_fit_may_be_late_while_the_touch_rests() -> None:
    engine = together(contact(0.0005, 0.0, 1.5, track=4, age=1.0))
    slot = slot_of(10**9, contact(0.001, 0.0, 1.0, track=4))
    write_engine(slot.patches[0], contact(0.0, 0.0, 1.6))
    rows, by = best_contacts(snapshot(2 * 10**9, engine), Reader(slot))
    assert_array_equal(rows["normal_force"], [1.0])
    assert by == ["fit"]


def test_what_only_the_fit_sees_is_shown_while_the_engine_sees_nothing() -> None:
    fit = Reader(slot_of(10**9, contact(0.001, 0.0, 0.2, track=FIRST), touched=0))
    rows, by = best_contacts(snapshot(10**9, together(), answer=1), fit)
    assert_array_equal(rows["normal_force"], [0.2])
    assert by == ["fit"]


def test_a_fit_that_is_not_there_says_nothing() -> None:
    reader = FitReader("no-such-skin")
    assert reader.latest() is None
    assert reader.status() == {}
    reader.close()
    assert is_fit(fit_name("skin"))
    assert not is_fit("skin")
