"""Two contacts close to each other: found as two, or one that says that it may be two."""

from typing import Any

import numpy as np
import pytest
from contact_truth import LAYER, PATCH, truth
from numpy.testing import assert_allclose
from numpy.typing import NDArray

import skinfield as sf
from skinfield.compiled import njit
from skinfield.solve.atoms.fit_kernel import MOST
from skinfield.solve.atoms.reading_memory import RESTING, STAGE
from skinfield.solve.atoms.split_kernel import (
    GATHERED,
    MAYBE,
    STATED,
    PairMemory,
    add_rival,
    mix_covariance,
)
from skinfield.solve.contact_fit import ContactData

Floats = NDArray[np.float64]
NOISE, AVERAGED = 0.002, 16
BALL = sf.simulate.Sphere(radius=6e-3, force=1.0)


class Fitted:
    """A fit and its memory."""

    def __init__(self) -> None:
        grid = sf.Grid.square(PATCH, nodes=12)
        rec = sf.Reconstructor(
            PATCH, LAYER, grid, quantity=sf.Capacitance(), noise_std=NOISE, solver=sf.ContactFit()
        )
        self.operator = sf.ContactFit().prepare(rec.model)
        self.data: ContactData = self.operator.data()

    def rows(self, readings: Floats, noise: float = NOISE) -> NDArray[np.void]:
        self.data.noise[:] = noise
        self.operator.solve(readings, self.data)
        return self.data.rows[: self.data.count].copy()

    def cold(self, readings: Floats, noise: float = NOISE) -> NDArray[np.void]:
        self.data.reset()
        return self.rows(readings, noise)


@pytest.fixture(scope="module", name="fitted")
def _fitted() -> Fitted:
    return Fitted()


def pairs(apart: float, count: int) -> list[tuple[Floats, Floats]]:
    """Places (2, 2), m, of two balls, and what both together are read as."""
    rng, made = np.random.default_rng(21), []
    for _ in range(count):
        middle, turn = rng.uniform(-7e-3, 7e-3, 2), rng.uniform(0.0, np.pi)
        half = 0.5 * apart * np.array([np.cos(turn), np.sin(turn)])
        places = np.array([middle + half, middle - half])
        made.append((places, sum(truth(BALL, tuple(at), "capacitance") for at in places)))
    return made  # type: ignore[return-value]


def noisy(readings: Floats, seed: int, noise: float = NOISE) -> Floats:
    return readings + np.random.default_rng(seed).normal(scale=noise, size=len(readings))


def are_at(rows: NDArray[np.void], places: Floats) -> bool:
    """Whether there are two contacts, one near each place."""
    spots = np.array([[row["x"], row["y"]] for row in rows]).reshape(-1, 2)
    away = np.hypot(*(spots[:, None] - places).T)
    return len(rows) == 2 and bool((away.min(axis=1) < np.hypot(*np.ptp(places, axis=0)) / 3).all())


@pytest.mark.parametrize(("apart", "share"), [(8e-3, 0.75), (10e-3, 0.92)])
def test_averages_of_16_tell_two_from_one(fitted: Fitted, apart: float, share: float) -> None:
    noise, made = NOISE / np.sqrt(AVERAGED), pairs(apart, 40)
    found = [
        are_at(fitted.cold(noisy(readings, seed, noise), noise), places)
        for seed, (places, readings) in enumerate(made)
    ]
    assert np.mean(found) >= share


def test_one_that_may_be_two_says_so_and_its_interval_covers_both(fitted: Fitted) -> None:
    ones, holds, one_of_two = 0, [], 0
    for seed, (_, readings) in enumerate(pairs(8e-3, 60)):
        rows = fitted.cold(noisy(readings, seed))
        ones += len(rows) == 1
        one_of_two += len(rows) == 2 and bool((rows["maybe"] == 1).all())
        if len(rows) == 1 and rows[0]["maybe"] == 2:
            off = 2.0 - rows[0]["normal_force"]
            holds.append(abs(off) < 1.645 * rows[0]["force_std"])
    assert len(holds) > ones / 3
    assert np.mean(holds) > 0.75
    assert one_of_two > 0
    rng = np.random.default_rng(22)
    places = rng.uniform(-9e-3, 9e-3, (40, 2))
    alone = [truth(BALL, tuple(place), "capacitance") for place in places]
    rows = [fitted.cold(noisy(readings, seed)) for seed, readings in enumerate(alone)]
    assert all(len(each) <= 1 for each in rows)
    assert np.mean([each["maybe"].any() for each in rows]) < 0.1


def test_two_stay_two_from_reading_to_reading(fitted: Fitted) -> None:
    changes, warm, fresh = 0, [], []
    for seed, (places, readings) in enumerate(pairs(10e-3, 16)):
        numbers = []
        fitted.data.reset()
        for k in range(24):
            rows = fitted.rows(noisy(readings, 100 * seed + k))
            numbers.append(len(rows))
            warm.append(are_at(rows, places))
        fresh += [
            are_at(fitted.cold(noisy(readings, 100 * seed + k)), places) for k in range(0, 24, 8)
        ]
        changes += np.count_nonzero(np.diff(numbers))
    assert changes < 16
    assert np.mean(warm) > np.mean(fresh) - 0.05


def test_a_comparison_in_slices_ends(fitted: Fitted) -> None:
    """It ends where the one without an end does, on readings that do not change, for good."""
    marks = fitted.data.fit.memory.marks
    for seed, (_, readings) in enumerate(pairs(9e-3, 8)):
        once = noisy(readings, seed)
        whole = fitted.cold(once)
        fitted.data.reset()
        marks[MOST] = 60
        stages = []
        for _ in range(60):
            rows = fitted.rows(once)
            stages.append(int(fitted.data.fit.own.marks[STAGE]))
        marks[MOST] = 0
        assert set(stages[-20:]) == {RESTING}
        assert len(rows) == len(whole)


@njit
def mix(pairs: Any, atom: Any, odds: float, one: Any, other: Any, out: Any) -> None:
    add_rival(pairs, 0, atom, odds, 2, one, other, 1.0)
    pairs.rivals[STATED, 0] = pairs.rivals[GATHERED, 0]
    mix_covariance(pairs, 0, out)


def test_a_covariance_is_that_of_the_mixture() -> None:
    """Of draws: the one contact, or either of two with the force of both, about what is stated."""
    rng, pairs = np.random.default_rng(23), PairMemory.of(1, 1)
    atom, one, other = (np.array([*at, np.log(force), 0, 0, 0, 0, 0]) for at, force in (
        ((0.3, -0.2), 1.5), ((2.1, 0.4), 0.8), ((-1.6, 0.1), 1.1)
    ))  # fmt: skip
    own, odds = np.diag([0.04, 0.09, 0.02, 0.1, 0.0, 0.0, 0.0, 0.0]), 1.5
    pairs.spread[:] = spread = np.array([[0.2, 0.05, 0.02], [0.05, 0.1, 0.0], [0.02, 0.0, 0.03]])
    mixed = own.copy()
    mix(pairs, atom, odds, one, other, mixed)

    weight, count, total = 1.0 / (1.0 + np.exp(odds / MAYBE)), 400_000, 0.8 + 1.1
    single = rng.multivariate_normal(np.zeros(3), own[:3, :3], count)
    middles = np.where(rng.random((count, 1)) < 0.8 / total, one[:2], other[:2]) - atom[:2]
    more = total / 1.5
    both = rng.multivariate_normal(np.zeros(3), spread, count) * [1.0, 1.0, more]
    both += np.column_stack([middles, np.full(count, more - 1.0)])
    drawn = np.where(rng.random((count, 1)) < weight, both, single)
    assert_allclose(mixed[:3, :3], drawn.T @ drawn / count, atol=0.015)
