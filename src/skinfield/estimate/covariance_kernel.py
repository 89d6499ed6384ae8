"""Covariances of sums over cells, and the chance of a distance, compiled."""

import math

import numpy as np

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints

FAST = {"reassoc", "contract", "nsz"}  # sums in any order, but NaN stays NaN


@njit(fastmath=FAST)
def of_factor(factor: Floats, cells: Ints, weights: Floats) -> Floats:
    """Covariance (M, M) of sums with weights (M, N) of rows `cells` of a factor (K, L)."""
    sums, readings = len(weights), factor.shape[1]
    moved, covariance = np.zeros((sums, readings)), np.zeros((sums, sums))
    for index in range(len(cells)):
        for m in range(sums):
            for reading in range(readings):
                moved[m, reading] += weights[m, index] * factor[cells[index], reading]
    for m in range(sums):
        for n in range(sums):
            for reading in range(readings):
                covariance[m, n] += moved[m, reading] * moved[n, reading]
    return covariance


@njit(fastmath=FAST)
def of_lattice(prior: Floats, steps: Ints, cells: Ints, weights: Floats) -> Floats:
    """Covariance (M, M) of sums with weights (M, N), by the offset of each pair of cells.

    `prior` (rows, columns) is the covariance by offset, `steps` (K, 2) row and column of each node.
    """
    sums, count = weights.shape
    row, column = np.empty(count, np.int64), np.empty(count, np.int64)
    for index in range(count):
        row[index], column[index] = steps[cells[index], 0], steps[cells[index], 1]
    smooth = np.zeros((sums, count))  # twice the pairs with those before, once each with itself
    line = np.empty(count)
    for index in range(count):
        for other in range(index):
            line[other] = prior[abs(row[index] - row[other]), abs(column[index] - column[other])]
        for m in range(sums):
            total = 0.0
            for other in range(index):
                total += line[other] * weights[m, other]
            smooth[m, index] = total
    covariance = np.zeros((sums, sums))
    for m in range(sums):
        for n in range(m + 1):
            total = 0.0
            for index in range(count):
                own = prior[0, 0] * weights[m, index] * weights[n, index]
                total += own + weights[m, index] * smooth[n, index]
                total += smooth[m, index] * weights[n, index]
            covariance[m, n] = covariance[n, m] = total
    return covariance


@inner
def chance_beyond(square: float) -> float:
    """Chance of a larger squared Mahalanobis distance of three numbers, by chi-squared."""
    root = math.sqrt(0.5 * square)
    return math.erfc(root) + 2.0 / math.sqrt(math.pi) * root * math.exp(-0.5 * square)
