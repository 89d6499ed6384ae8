"""Swapped taxels and boards: what answers to touches, but at the place of another.

Two that are swapped differ as the surroundings of each other do, under touches of either. What is
found is put right before others are judged, boards first.
"""

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from skinfield.errors import Floats, Ints
from skinfield.signal.fault_evidence import (
    CERTAIN,
    LEAST_BOARD,
    RARE,
    Evidence,
    TaxelFault,
    Verdict,
    probability,
)
from skinfield.signal.touch_response import FEWEST, PRESSED, TouchResponse, mean_around

if TYPE_CHECKING:
    from skinfield.signal.touch_response import Links

LEAST_CROSSED = 0.45  # part of how two usually differ as their neighbours do, the other way round
LEAST_SPREAD = 0.25  # of how they do, as Fisher's z of a correlation
FREEDOM = 8.0  # of Student's t, of the same
ALIKE = 0.9  # cosine of the loads around two, from which on they are touched together
ONE_SIDED = 0.3  # least correlation, the other way round, under touches of either of two
LIKE = 0.999  # correlation of two that read alike
MOST_DOUBTFUL = 8  # boards, those that read least as what lies around them


def swapped_taxels(seen: Evidence) -> list[TaxelFault]:
    """Pairs of boards, and of taxels, that answer to touches at each other's places."""
    touches = seen.touches
    touched = np.flatnonzero(touches.felt)
    if len(touched) < FEWEST or seen.patch is None:
        return []
    links, height = touches.links, touches.height.copy()
    boards = _swapped_boards(seen.patch.module, links, height, touches)
    return boards + _swapped_pairs(links, height, touched)


def _swap(height: Floats, rows: Ints, what: str, names: Ints, p: float) -> list[TaxelFault]:
    """Put right heights of (2, N) rows that are swapped, and say of both what they are."""
    height[:] = _mended(height, rows)
    why = "answers to touches on {} {}, and not on its own place: the two are swapped"
    return [
        TaxelFault(Verdict.SWAPPED, each, p, why.format(what, name))
        for each, name in zip(rows, names[::-1], strict=True)
    ]


def _mended(height: Floats, rows: Ints) -> Floats:
    """Heights with two groups of taxels (2, N) exchanged."""
    mended = height.copy()
    mended[:, rows.ravel()] = height[:, rows[::-1].ravel()]
    return mended


def _correlation(one: Floats, other: Floats) -> float:
    """Of changes from rest; 0 where there is none."""
    size = float(np.sum(one**2) * np.sum(other**2))
    return float(np.sum(one * other)) / size**0.5 if size > 0.0 else 0.0


def _mean_outside(links: "Links", height: Floats, rows: Ints) -> Floats:
    """Mean (T, N) of the neighbours of N taxels, these left out; 0 where there is no other."""
    near = links[rows].toarray()
    near[:, rows] = 0.0
    return np.asarray(height @ near.T / np.maximum(near.sum(axis=1), 1.0))


# ---- taxels


def _swapped_pairs(links: "Links", height: Floats, touched: Ints) -> list[TaxelFault]:
    """Pairs of taxels, as sure as their fit is far from that of all pairs."""
    from scipy.stats import t

    fits = _all_crossings(links, height, touched)
    known = fits[np.isfinite(fits)]
    if not len(known):
        return []
    middle = float(np.median(known))
    spread = max(1.4826 * float(np.median(np.abs(known - middle))), LEAST_SPREAD)
    chance = t.cdf((np.nan_to_num(fits, nan=middle) - middle) / spread, FREEDOM)
    likely = (chance <= RARE) & (fits < -LEAST_CROSSED * middle)
    pairs = touched[np.argwhere(np.triu(likely))]
    found: list[TaxelFault] = []
    for pair in sorted(pairs, key=lambda pair: _crossing(links, height, pair)):
        fit = _crossing(links, height, pair)  # now that those before it are put right
        p = probability(float(t.cdf((fit - middle) / spread, FREEDOM)))
        if p >= CERTAIN and fit < -LEAST_CROSSED * middle:
            found += _swap(height, pair[:, None], "taxel", pair, p)
    return found


def _all_crossings(links: "Links", height: Floats, taxels: Ints) -> Floats:
    """How much each two of N taxels differ as their neighbours' means do, (N, N): Fisher's z."""
    own, around = height[:, taxels], mean_around(links[taxels], height)
    both = own.T @ around
    fit = np.diag(both)[:, None] + np.diag(both) - both - both.T
    size = _difference(own.T @ own) * _difference(around.T @ around)
    with np.errstate(invalid="ignore", divide="ignore"):
        found = np.where(size > 0.0, fit / np.sqrt(size), np.nan)
    return np.asarray(np.arctanh(np.clip(found, -LIKE, LIKE)))


def _difference(products: Floats) -> Floats:
    """Squared sums of the differences of each two columns, from their products (N, N)."""
    square = np.diag(products)
    return np.asarray(np.maximum(square[:, None] + square - 2.0 * products, 0.0))


def _crossing(links: "Links", height: Floats, pair: Ints) -> float:
    """The same of two taxels, by what lies around both; LIKE where touches of one only tell."""
    one, other = _mean_outside(links, height, pair).T
    load, own = one - other, height[:, pair[0]] - height[:, pair[1]]
    either = [_correlation(own[side], load[side]) for side in (load > 0.0, load < 0.0)]
    alike = _correlation(one, other) >= ALIKE or max(either) > -ONE_SIDED
    return float(np.arctanh(LIKE if alike else np.clip(_correlation(own, load), -LIKE, LIKE)))


# ---- boards


def _swapped_boards(
    module: Ints, links: "Links", height: Floats, touches: TouchResponse
) -> list[TaxelFault]:
    """Pairs of boards whose exchange makes all fit best to what lies around them, one by one."""
    boards = {int(name): np.flatnonzero(module == name) for name in np.unique(module)}
    ends = links.tocoo()
    outside = links.copy()
    outside.data = outside.data * (module[ends.row] != module[ends.col])
    found: list[TaxelFault] = []
    while len(boards) > 2:
        fits = {name: _fit(outside[rows], height, rows) for name, rows in boards.items()}
        doubtful = sorted((name for name in fits if fits[name] != 0.0), key=fits.__getitem__)
        best, gain = None, 0.0
        for pair in combinations(doubtful[:MOST_DOUBTFUL], 2):
            if not len(boards[pair[0]]) == len(boards[pair[1]]) >= LEAST_BOARD:
                continue
            rows = np.array([boards[name] for name in pair])
            p = _exchanged(links, height, rows, touches)
            if p >= CERTAIN:
                more = _fit(outside, _mended(height, rows)) - _fit(outside, height)
                best, gain = ((pair, rows, p), more) if more > gain else (best, gain)
        if best is None:
            break
        pair, rows, p = best
        found += _swap(height, rows, "board", np.array(pair), p)
        boards = {name: boards[name] for name in boards if name not in pair}
    return found


def _fit(outside: "Links", height: Floats, rows: Ints | slice = slice(None)) -> float:
    """Correlation of taxels with what lies around their boards; 0 if nothing."""
    around = mean_around(outside, height)
    return _correlation(height[:, rows] * (around != 0.0).any(axis=0), around)


def _exchanged(links: "Links", height: Floats, rows: Ints, touches: TouchResponse) -> float:
    """Probability that two boards (2, N) are exchanged, as many taxels fit the other place better.

    Only places beside both boards count, that are touched. How often a healthy taxel fits another
    place better is told by all pairs, once the two are put right.
    """
    from scipy.stats import binom

    load = _mean_outside(links, height, rows.ravel())
    mended = _mended(height, rows)
    touched = load.max(axis=0) > PRESSED * touches.usual
    fit = np.where(touched, np.sum(load * (height - mended)[:, rows.ravel()], axis=0), 0.0)
    if max(side.sum() for side in np.split(fit, 2)) >= 0.0:
        return 0.0
    felt = np.flatnonzero(touches.felt)
    fits = mended[:, felt].T @ mean_around(links[felt], mended)
    better = float(np.mean(fits > np.diag(fits)))
    chance = binom.sf(int((fit < 0.0).sum()) - 1, int(touched.sum()), better)
    return probability(float(chance) ** 0.5)  # not independent
