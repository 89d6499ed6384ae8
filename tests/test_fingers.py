"""How many fingers touch, by the size of the touched area."""

from typing import Any

import numpy as np
import pytest

from skinfield.compiled import njit
from skinfield.solve.atoms.fingers_kernel import (
    FIGURES,
    TABLE,
    FingerClasses,
    classify,
    count_fingers,
    learnt_classes,
    measure_hand,
    number_parts,
)

PITCH, UNIT, MOST = 6.5, 2.0, 48  # mm, mm, taxels
COLUMNS = np.stack(np.meshgrid(np.arange(34.0), np.arange(20.0)), axis=-1).reshape(-1, 2)
COLUMNS[:, 0] += 0.5 * (COLUMNS[:, 1] % 2)
PLACES = COLUMNS * [PITCH, PITCH * 0.866]  # mm, of a hexagonal lattice


@njit
def count(places: Any, readings: Any, taxels: Any, known: Any) -> int:
    """`count_fingers` for Python."""
    return int(count_fingers(places, readings, 0.0, taxels, len(taxels), known))


@njit
def measured(places: Any, readings: Any, taxels: Any, known: Any) -> int:
    """`measure_hand` of all touched taxels as one hand, for Python."""
    number_parts(places, taxels, len(taxels), 1e9, known.parts[0])
    number_parts(places, taxels, len(taxels), 1.5 * known.pitch, known.parts[1])
    return int(measure_hand(places, readings, 0.0, taxels, len(taxels), 0, known))


@njit
def classified(known: Any) -> int:
    """`classify` for Python."""
    return int(classify(known))


def fingers_of(readings: np.ndarray, unit: float = UNIT) -> int:
    """Fingers in readings; touched is what reads a fifth of the highest."""
    taxels = np.flatnonzero(readings > 0.2 * readings.max())
    known = FingerClasses.of(unit, PITCH / unit, MOST)
    return count(PLACES / unit, readings, taxels, known)


def tips(rng: np.random.Generator, fingers: int, middle: tuple[float, float]) -> np.ndarray:
    """Readings of fingers on their tips, 22 to 45 mm from each other, in a hand."""
    while True:
        at = middle + rng.uniform(-45, 45, (fingers, 2))
        between = np.linalg.norm(at[:, None] - at, axis=-1)[np.triu_indices(fingers, 1)]
        if not len(between) or between.min() > 22:
            break
    away = np.square(PLACES[:, None] - at).sum(axis=-1)
    size = rng.uniform(4.0, 6.5, fingers)
    return np.asarray((rng.uniform(0.4, 0.7, fingers) * np.exp(-0.5 * away / size**2)).sum(axis=1))


def test_what_was_learnt_is_a_distribution_for_each_number_and_pose() -> None:
    fingers, means, factors, offsets = learnt_classes()
    assert list(fingers) == 2 * [1, 2, 3, 4, 5]
    assert (np.diff(means[:5, [0, 2, 3]], axis=0) > -0.1).all()  # more fingers, larger areas
    table = np.loadtxt(TABLE, delimiter=",")
    for row, factor, offset in zip(table, factors, offsets, strict=True):
        covariance = row[1 + FIGURES :].reshape(FIGURES, FIGURES)
        assert factor @ covariance @ factor.T == pytest.approx(np.eye(FIGURES), abs=1e-6)
        assert offset == pytest.approx(-0.5 * np.linalg.slogdet(covariance)[1])


def test_figures_are_those_of_numpy() -> None:
    rng = np.random.default_rng(0)
    taxels = np.sort(rng.choice(len(PLACES), 20, replace=False))
    readings = np.zeros(len(PLACES))
    readings[taxels] = rng.uniform(0.2, 0.6, 20)
    known = FingerClasses.of(UNIT, PITCH / UNIT, MOST)
    assert measured(PLACES / UNIT, readings, taxels, known) == 20
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial.distance import pdist

    its, weights = PLACES[taxels], readings[taxels]
    spread = np.linalg.eigvalsh(np.cov(its.T, aweights=weights, ddof=0)) + PITCH**2 / 12
    islands = fcluster(linkage(its, "single"), 1.5 * PITCH, "distance").max()
    area, length = 20 * 0.866 * PITCH**2, pdist(its).max() + PITCH
    assert np.exp(known.figures) == pytest.approx([area, islands, *np.sqrt(spread), length])


@pytest.mark.parametrize("fingers", [1, 2, 3, 4, 5])
def test_fingers_on_their_tips_are_counted(fingers: int) -> None:
    rng = np.random.default_rng(fingers)
    found = np.array([fingers_of(tips(rng, fingers, (110.0, 55.0))) for _ in range(40)])
    assert abs(found.mean() - fingers) < 0.6
    assert (found == fingers).mean() > 0.35


def test_the_unit_of_places_does_not_matter() -> None:
    rng = np.random.default_rng(7)
    readings = tips(rng, 3, (110.0, 55.0))
    assert fingers_of(readings, 0.7) == fingers_of(readings, 3.0) > 0


def test_hands_far_from_each_other_are_counted_each() -> None:
    one, other = (tips(np.random.default_rng(1), 1, (x, 55.0)) for x in (35.0, 190.0))
    assert fingers_of(one) == fingers_of(other) == 1
    assert fingers_of(one + other) == 2


def test_a_lone_taxel_far_from_a_hand_is_no_finger() -> None:
    readings = tips(np.random.default_rng(1), 2, (50.0, 55.0))
    alone = fingers_of(readings)
    readings[np.argmin(np.linalg.norm(PLACES - (200.0, 55.0), axis=1))] = 0.5
    assert fingers_of(readings) == alone > 0


def test_what_is_unlike_any_hand_has_no_fingers() -> None:
    readings = np.where(np.abs(PLACES[:, 1] - 55.0) < 3.0, 0.5, 0.0)  # a bar of 220 mm
    assert fingers_of(readings) == 0
    known = FingerClasses.of(UNIT, PITCH / UNIT, MOST)
    known.figures[:] = known.means[3]
    assert classified(known) == 4
