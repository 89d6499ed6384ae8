"""Conjugate gradients on the taxels of a sheet, from the reading before."""

from dataclasses import dataclass, field
from time import perf_counter_ns
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError, Ints
from skinfield.inverse.sheet.gram import TOO_DENSE, Gram

FORGET = 16  # steps in which a slow one is forgotten
LARGEST = 1e34  # square of the whitened readings: products of single precision end at 3e38


@dataclass
class Conjugate:
    """Solver of D (W A Q A^T W + I) D u = b, whose diagonal is made 1 by D.

    Every array is made once. A taxel that did not answer is left out by holding its u at 0, which
    takes its row and column out of the matrix.

    Parameters
    ----------
    gram : Gram
        Its values scaled, so that the diagonal is 1.
    order : (L,) int array
        Row of each taxel in the readings.
    scale : (L,) array
        From a reading to b.

    Attributes
    ----------
    answer, valid : (L,) arrays
        u, and 1 for each taxel that answered, else 0.
    iterations : int
    relative_residual : float
        As a share of the norm of b.
    stopped : bool
        Whether a deadline cut the last reading short.
    step_ns : int
        What a step took lately, at its slowest.
    """

    gram: Gram
    order: Ints
    scale: NDArray[Any]
    answer: NDArray[Any] = field(init=False)
    valid: NDArray[Any] = field(init=False)
    iterations: int = field(init=False, default=0)
    stopped: bool = field(init=False, default=False)
    step_ns: int = field(init=False, default=0)
    relative_residual: float = field(init=False, default=0.0)

    def __post_init__(self) -> None:
        empty = np.zeros_like(self.scale)
        self.answer, self.valid = empty, np.ones_like(empty)
        self._target, self._residual = empty.copy(), empty.copy()
        self._way, self._moved = empty.copy(), empty.copy()

    def reset(self) -> None:
        """Forget the reading before."""
        self.answer[:] = 0.0

    def solve(
        self, readings: NDArray[Any], tolerance: float, most: int, deadline_ns: int | None = None
    ) -> None:
        """Find the answer to linearised readings (L,), NaN where a taxel did not answer.

        Stops where the norm of the residual falls to `tolerance` of that of b, or after `most`
        steps, or where another step would end after `deadline_ns` of `time.perf_counter_ns`.
        Starts from the answer before if that is nearer than 0.
        """
        from skinfield.inverse.sheet.kernels import descend, take_in, turn

        answer, valid, residual, way, moved = (
            self.answer,
            self.valid,
            self._residual,
            self._way,
            self._moved,
        )
        whole = take_in(readings, self.order, self.scale, self._target, valid, answer)
        if not whole < LARGEST:
            raise InputError(
                f"readings are {np.sqrt(whole):g} deviations of their noise, expected finite ones "
                f"below {np.sqrt(LARGEST):g}: mark taxels that did not answer with NaN"
            )
        square = self._begin(whole)
        self.iterations, self.stopped = 0, False
        enough = tolerance**2 * whole
        turn(0.0, residual, way, moved)
        while square > enough and self.iterations < most:
            begin = perf_counter_ns()
            if deadline_ns is not None and begin + self.step_ns > deadline_ns:
                self.stopped = True
                break
            curved = self._multiply(way, moved)
            if not curved > 0.0:
                raise InputError(TOO_DENSE)
            before, square = square, descend(square / curved, way, moved, valid, answer, residual)
            turn(square / before, residual, way, moved)
            self.iterations += 1
            spent = perf_counter_ns() - begin
            self.step_ns = max(spent, self.step_ns - self.step_ns // FORGET)
        self.relative_residual = float(np.sqrt(square / whole)) if whole > 0.0 else 0.0

    def _begin(self, whole: float) -> float:
        """Write the first residual; return the square of its norm."""
        from skinfield.inverse.sheet.kernels import residual_of

        if self.answer.any():
            self._moved[:] = self.answer
            self._multiply(self.answer, self._moved)
            square = residual_of(self._target, self._moved, self.valid, self._residual)
            if square < whole:
                return float(square)
            self.answer[:] = 0.0
        self._residual[:] = self._target
        return whole

    def _multiply(self, vector: NDArray[Any], out: NDArray[Any]) -> float:
        """Write M v over v in `out`; return v . M v."""
        from skinfield.inverse.sheet.kernels import multiply

        gram = self.gram
        return float(multiply(gram.start, gram.other, gram.value, vector, out))
