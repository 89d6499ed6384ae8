"""Accelerated gradient on the dual of `NonNegative`, as a contender of its Newton steps."""

import numpy as np
from numba import njit

MOST = 2000  # steps
LOWER = 0.9  # of the curvature, after each step


@njit(fastmath=True, nogil=True)
def correlate(rows, values, out):
    """Write into `out` (K,) the product of each row with `values` (L,)."""
    for node in range(len(rows)):
        row = rows[node]
        total = row[0] * values[0]
        for taxel in range(1, len(values)):
            total += row[taxel] * values[taxel]
        out[node] = total


@njit(fastmath=True, nogil=True)
def slope(rows, penalty, target, dual, matched, out):
    """Slope of the negative dual value into `out` (L,); that value, and the objective there."""
    out[:] = 0.0
    square, cost = 0.0, 0.0
    for node in range(len(rows)):
        amount = matched[node] - penalty[node]
        if amount > 0.0:
            square += amount * amount
            cost += amount * penalty[node]
            row = rows[node]
            for taxel in range(len(out)):
                out[taxel] += amount * row[taxel]
    missing, own, product = 0.0, 0.0, 0.0
    for taxel in range(len(out)):
        left = target[taxel] - out[taxel]
        missing += left * left
        own += dual[taxel] * dual[taxel]
        product += dual[taxel] * target[taxel]
        out[taxel] = dual[taxel] - left
    return 0.5 * own - product + 0.5 * square, 0.5 * missing + 0.5 * square + cost


@njit(fastmath=True, nogil=True)
def negative_dual(penalty, target, dual, matched):
    """Value of |r|^2 / 2 - b.r + |z(r)|^2 / 2."""
    total = 0.0
    for taxel in range(len(dual)):
        total += dual[taxel] * (0.5 * dual[taxel] - target[taxel])
    for node in range(len(penalty)):
        amount = max(matched[node] - penalty[node], 0.0)
        total += 0.5 * amount * amount
    return total


@njit(fastmath=True, nogil=True)
def search(rows, penalty, target, duals, matches, ascent, curve, gap):
    """Move duals[0] until the gap there is proved; return steps and the curvature.

    P(z(r)) - D(r) is half the square of the slope, so the proof costs nothing further.
    """
    here, before, ahead, trial = duals[0], duals[1], duals[2], duals[3]
    at_here, at_before, at_ahead, at_trial = matches[0], matches[1], matches[2], matches[3]
    correlate(rows, here, at_here)
    before[:], at_before[:] = here, at_here
    age = 0.0
    for step in range(MOST):
        push = age / (age + 3.0)
        for taxel in range(len(here)):
            ahead[taxel] = here[taxel] + push * (here[taxel] - before[taxel])
        for node in range(len(at_here)):  # a product is linear: no further pass over the rows
            at_ahead[node] = at_here[node] + push * (at_here[node] - at_before[node])
        value, objective = slope(rows, penalty, target, ahead, at_ahead, ascent)
        square = 0.0
        for each in ascent:
            square += each * each
        if 0.5 * square <= gap * objective:
            here[:] = ahead
            return step, curve
        while True:
            for taxel in range(len(trial)):
                trial[taxel] = ahead[taxel] - ascent[taxel] / curve
            correlate(rows, trial, at_trial)
            reached = negative_dual(penalty, target, trial, at_trial)
            if reached <= value - 0.5 * square / curve + 1e-6 * abs(value):
                break
            curve *= 2.0
        uphill = 0.0
        for taxel in range(len(here)):
            uphill += ascent[taxel] * (trial[taxel] - here[taxel])
        age = 0.0 if uphill > 0.0 else age + 1.0
        before[:], at_before[:] = here, at_here
        here[:], at_here[:] = trial, at_trial
        curve = max(LOWER * curve, 1.0)
    return MOST, curve


class Fista:
    """With what it needs to start from the reading before."""

    def __init__(self, seen: np.ndarray, penalty: np.ndarray, gap: float) -> None:
        self.rows = np.ascontiguousarray(seen.T, dtype=np.float32)
        self.penalty = penalty.astype(np.float32)
        self.gap = gap
        self.duals = np.zeros((4, len(seen)), np.float32)
        self.matches = np.zeros((4, len(penalty)), np.float32)
        self.ascent = np.zeros(len(seen), np.float32)
        self.target = np.zeros(len(seen), np.float32)
        self.reset()
        self(seen @ np.ones(len(penalty)))  # compile
        self.reset()

    def reset(self) -> None:
        """Forget the reading before."""
        self.duals[:] = 0.0
        self.curve = 10.0

    def __call__(self, white: np.ndarray) -> int:
        """Steps that a whitened reading takes."""
        self.target[:] = white
        steps, curve = search(
            self.rows,
            self.penalty,
            self.target,
            self.duals,
            self.matches,
            self.ascent,
            self.curve,
            self.gap,
        )
        self.curve = float(curve)
        return int(steps)
