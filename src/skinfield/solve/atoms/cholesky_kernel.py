"""Cholesky factorisation of small matrices, compiled, their rows in one array."""

import numpy as np

from skinfield.compiled import inner
from skinfield.errors import Floats


@inner(_nrt=False)
def factor(matrix: Floats, size: int) -> bool:
    """Replace the lower triangle of a matrix, its rows in one, by Cholesky's factor, if it can."""
    for j in range(size):
        pivot = matrix[j * size + j]
        for k in range(j):
            pivot -= matrix[j * size + k] * matrix[j * size + k]
        if not pivot > 0.0:
            return False
        pivot = np.sqrt(pivot)
        matrix[j * size + j] = pivot
        for i in range(j + 1, size):
            value = matrix[i * size + j]
            for k in range(j):
                value -= matrix[i * size + k] * matrix[j * size + k]
            matrix[i * size + j] = value / pivot
    return True


@inner(_nrt=False)
def solve_factored(matrix: Floats, size: int, right: Floats) -> None:
    """Solve in place by the factor of `factor`."""
    for i in range(size):
        for k in range(i):
            right[i] -= matrix[i * size + k] * right[k]
        right[i] /= matrix[i * size + i]
    for i in range(size - 1, -1, -1):
        for k in range(i + 1, size):
            right[i] -= matrix[k * size + i] * right[k]
        right[i] /= matrix[i * size + i]
