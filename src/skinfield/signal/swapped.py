"""Swapped taxels and boards: what answers to touches, but at the place of another.

Two that are swapped differ as the surroundings of each other do, under touches of either. What is
found is put right before others are judged, boards first.
"""

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from skinfield.errors import Floats, Ints
from skinfield.signal.fault_evidence import CERTAIN, LEAST_BOARD, Evidence, Finding, probability
from skinfield.signal.touch_response import FEWEST, PRESSED, TouchResponse, mean_around

if TYPE_CHECKING:
    from skinfield.signal.touch_response import Links

LEAST_CROSSED = 0.45  # part of how two usually differ as their neighbours do, the other way round
FREEDOM = 8.0  # of Student t, of that
LEAST_SPREAD = 0.25  # of how they do, as Fisher's z of a correlation
ALIKE = 0.9  # cosine of the loads around two, from which on they are touched together
ONE_SIDED = 0.3  # least correlation, the other way round, under touches of either of two
MOST_DOUBTFUL = 8  # boards, those that read least as what lies around them


def swapped_taxels(seen: Evidence) -> list[Finding]:
    """Pairs of boards, and of taxels, that answer to touches at each other's places."""
    touches = seen.touches
    told = np.flatnonzero(touches.felt)
    if len(told) < FEWEST or seen.patch is None:
        return []
    links, height = touches.links, touches.height.copy()
    boards = _swapped_boards(seen.patch.module, links, height, touches)
    return boards + _swapped_pairs(links, height, told)


# ---- taxels


def _swapped_pairs(links: "Links", height: Floats, told: Ints) -> list[Finding]:
    """Pairs of taxels, as sure as their fit is far from that of all pairs."""
    from scipy.stats import t

    fits = _all_crossings(links, height, told)
    known = fits[np.isfinite(fits)]
    if not len(known):
        return []
    middle = float(np.median(known))
    spread = max(1.4826 * float(np.median(np.abs(known - middle))), LEAST_SPREAD)

    def sure(fit: Floats) -> Floats:
        """Probability of a swap by fits."""
        chance = t.cdf((np.where(np.isfinite(fit), fit, middle) - middle) / spread, FREEDOM)
        return np.where(fit < -LEAST_CROSSED * middle, probability(chance), 0.0)

    pairs = told[np.argwhere(np.triu(sure(fits) >= CERTAIN))]
    found: list[Finding] = []
    for pair in sorted(pairs, key=lambda pair: _crossing(links, height, *pair)):
        p = float(sure(np.asarray(_crossing(links, height, *pair))))
        if p >= CERTAIN:  # still, after those before it are put right
            height[:, pair] = height[:, pair[::-1]]
            found += _swap("taxel", pair, (pair[:1], pair[1:]), p)
    return found


def _all_crossings(links: "Links", height: Floats, taxels: Ints) -> Floats:
    """How much each two of N taxels differ as their neighbours' means do, (N, N): Fisher's z."""
    own, around = height[:, taxels], mean_around(links[taxels], height)
    told = own.T @ around
    fit = np.diag(told)[:, None] + np.diag(told) - told - told.T
    size = _difference(own.T @ own) * _difference(around.T @ around)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(size > 0.0, _z(fit / np.sqrt(size)), np.nan)


def _crossing(links: "Links", height: Floats, one: int, other: int) -> float:
    """The same of two taxels, by what lies around both; inf where touches of one only tell."""
    near = links[[one, other]].toarray()
    near[:, [one, other]] = 0.0
    mine, yours = (height @ near.T / np.maximum(near.sum(axis=1), 1.0)).T
    load, own = mine - yours, height[:, one] - height[:, other]
    if mine @ yours >= ALIKE * np.sqrt((mine @ mine) * (yours @ yours)):
        return float("inf")
    more = [_correlation(own[side], load[side]) for side in (load > 0.0, load < 0.0)]
    return float("inf") if max(more) > -ONE_SIDED else float(_z(_correlation(own, load)))


def _correlation(one: Floats, other: Floats) -> float:
    """Of two changes from rest; 0 where one has none."""
    size = float(np.sum(one**2) * np.sum(other**2))
    return float(np.sum(one * other)) / size**0.5 if size > 0.0 else 0.0


def _z(correlation: Floats) -> Floats:
    return np.arctanh(np.clip(correlation, -0.999, 0.999))


def _difference(products: Floats) -> Floats:
    """Squared sums of the differences of each two columns, from their products (N, N)."""
    square = np.diag(products)
    return np.asarray(np.maximum(square[:, None] + square - 2.0 * products, 0.0))


def _swap(what: str, names: Ints, rows: tuple[Ints, Ints], p: float) -> list[Finding]:
    """What is said of both."""
    why = "answers to touches on {} {}, and not on its own place: the two are swapped"
    return [
        Finding(each, p, why.format(what, name))
        for each, name in zip(rows, names[::-1], strict=True)
    ]


# ---- boards


def _swapped_boards(
    module: Ints, links: "Links", height: Floats, touches: TouchResponse
) -> list[Finding]:
    """Pairs of boards, as sure as it is rare that so many taxels would fit other places better."""
    boards = {int(name): np.flatnonzero(module == name) for name in np.unique(module)}
    ends = links.tocoo()
    apart = module[ends.row] != module[ends.col]
    outside = links.copy()
    outside.data = outside.data * apart
    told = np.flatnonzero(touches.felt)
    products = height[:, told].T @ mean_around(links[told], height)
    better = float(np.mean(products > np.diag(products)))
    found: list[Finding] = []
    while len(boards) > 2:
        fits = {name: _fit(outside, height, rows) for name, rows in boards.items()}
        doubtful = sorted((name for name in fits if fits[name] != 0.0), key=fits.__getitem__)
        best, gain = None, 0.0
        for pair in combinations(doubtful[:MOST_DOUBTFUL], 2):
            rows = tuple(boards[name] for name in pair)
            if not len(rows[0]) == len(rows[1]) >= LEAST_BOARD:
                continue
            p = _exchanged(links, height, rows, better, PRESSED * touches.usual)
            if p >= CERTAIN:
                more = _fit(outside, _with_swapped(height, rows)) - _fit(outside, height)
                if more > gain:
                    best, gain = (pair, rows, p), more
        if best is None:
            break
        pair, rows, p = best
        height[:] = _with_swapped(height, rows)
        found += _swap("board", np.array(pair), rows, p)
        for name in pair:
            del boards[name]
    return found


def _fit(outside: "Links", height: Floats, rows: Ints | None = None) -> float:
    """Correlation of taxels with what lies around their boards; 0 if nothing."""
    rows = np.arange(height.shape[1]) if rows is None else rows
    around = mean_around(outside[rows], height)
    return _correlation(height[:, rows] * (around != 0.0).any(axis=0), around)


def _with_swapped(height: Floats, rows: tuple[Ints, Ints]) -> Floats:
    swapped = height.copy()
    swapped[:, [*rows[0], *rows[1]]] = height[:, [*rows[1], *rows[0]]]
    return swapped


def _exchanged(
    links: "Links", height: Floats, rows: tuple[Ints, Ints], better: float, least: float
) -> float:
    """Probability that two boards are exchanged, by how many taxels fit the other place better.

    Only places count that are touched, beside both boards.
    """
    from scipy.stats import binom

    both, other = np.concatenate(rows), np.concatenate(rows[::-1])
    near = links[both].toarray()
    near[:, both] = 0.0
    load = height @ near.T / np.maximum(near.sum(axis=1), 1.0)
    told = np.sum(load * (height[:, both] - height[:, other]), axis=0)
    touched = load.max(axis=0) > least
    sides = np.split(np.where(touched, told, 0.0), 2)
    if max(side.sum() for side in sides) >= 0.0:
        return 0.0
    number, crossed = int(touched.sum()), int((told[touched] < 0.0).sum())
    return probability(float(binom.sf(crossed - 1, number, better)) ** 0.5)  # not independent
