"""Bulk reconstruction: chosen fields and contacts of many readings of one patch.

What a linear solver answers is one matrix product per chunk of readings. Run it on one thread of
the BLAS (``OPENBLAS_NUM_THREADS=1``): a chunk is too small to share; more cores are used by more
processes, as `skinfield reconstruct --workers` does.
"""

from collections.abc import Callable, Iterable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, Ints, check_choice, check_shape
from skinfield.estimate import Estimate
from skinfield.reconstruct.plan import LinearFields
from skinfield.reconstruct.reconstructor import Reconstructor

CHUNK = 512  # readings per product at most
FEWEST = 64  # and at least
CACHE_BYTES = 4 << 20  # of a chunk's outputs: more leave the cache before anybody looks at them
RUN = 256  # readings that an iterative solver answers one from the other
WARM = 32  # readings before a run, from which its first one starts
MOST_SETS = 16  # of valid taxels that stay prepared
OUTPUTS = {  # numbers per node; in the patch's frame, signs as in `Estimate`
    "pressure": 1,
    "indentation": 1,
    "displacement": 3,
}
Fields = dict[str, NDArray[Any]]


class BulkFields:
    """Fields of many readings, in chunks; what is linear by one product per chunk.

    Parameters
    ----------
    reconstructor : Reconstructor
    outputs : iterable of str
        Of `OUTPUTS`: what to compute of each reading.
    precision : numpy.float32 or numpy.float64
        Of the answers. A sum of L products in single precision is off by about 1e-6 of the
        largest of them, far below the noise of any skin.

    Notes
    -----
    Runs of an iterative solver begin at multiples of `RUN`, from the `WARM` readings before, and
    these from nothing, so that what a reading gives does not depend on which others are wanted.
    Each output of a linear one is a product of its own,
    so that it does not depend on what else is wanted, to the last bit.
    """

    def __init__(
        self,
        reconstructor: Reconstructor,
        outputs: Iterable[str] = ("pressure", "indentation"),
        precision: type[np.floating[Any]] = np.float32,
    ) -> None:
        self.reconstructor = reconstructor
        self.outputs = (outputs,) if isinstance(outputs, str) else tuple(outputs)
        for name in self.outputs:
            check_choice("outputs", name, OUTPUTS, "a field that a reading is turned into")
        if not self.outputs or len(set(self.outputs)) < len(self.outputs):
            raise InputError(f"outputs is {self.outputs!r}, expected one name or more, each once")
        self.precision = precision
        self._linear = reconstructor.plans.linear
        self._matrix_of = lru_cache(len(OUTPUTS) * MOST_SETS)(self._made_matrix)

    @property
    def is_linear(self) -> bool:
        """Whether one product answers."""
        return self._linear is not None

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Of each output of one reading: (K,), or (K, 3) for a vector field."""
        nodes = len(self.reconstructor.grid)
        return {name: (nodes, 3) if OUTPUTS[name] == 3 else (nodes,) for name in self.outputs}

    def __call__(self, readings: Floats) -> Fields:
        """Fields of some readings.

        Parameters
        ----------
        readings : (T, L) array, in the quantity's unit
            NaN where a taxel did not answer; each with a valid taxel.

        Returns
        -------
        dict
            By the name of the output, (T, K) or (T, K, 3) arrays of the precision.
        """
        check_shape("readings", readings, (None, len(self.reconstructor.patch)), "one per taxel")
        if self._linear is None:
            each = self.estimates(readings)
            return {
                name: np.stack([getattr(one, name) for one in each], dtype=self.precision)
                for name in self.outputs
            }
        found: Fields = {}
        for name, shape in self.shapes.items():
            width = int(np.prod(shape))
            fitting = max(CACHE_BYTES // (width * np.dtype(self.precision).itemsize), 1)
            chunk = min(CHUNK, max(FEWEST, 1 << fitting.bit_length() - 1))
            table = np.empty((len(readings), width), self.precision)
            for first in range(0, len(readings), chunk):
                part = slice(first, first + chunk)
                self._into(self._linear, name, readings[part], table[part])
            found[name] = table.reshape(len(table), *shape)
        return found

    def estimates(
        self, readings: Floats, stamp_ns: Ints | None = None, before: int = 0
    ) -> list[Estimate]:
        """Everything of each of some readings (T, L), stamped (T,), run by run.

        The first run begins after so many readings `before`, whose answers are left out.
        """
        stamps = np.zeros(len(readings), np.int64) if stamp_ns is None else stamp_ns
        each: list[Estimate] = []
        for first in range(before, len(readings), RUN):
            self.reconstructor.reset()
            start = first if self.is_linear else max(first - WARM, 0)
            run = slice(start, first + RUN)
            found = self.reconstructor(readings[run], stamp_ns=stamps[run])
            each += (found[place] for place in range(first - start, len(found)))
        return each

    def estimate(
        self, readings: Floats, stamp_ns: Ints, skip: int = 0, before: int = 0
    ) -> Estimate:
        """One estimate of some readings; its contacts are found when they are looked at.

        Parameters
        ----------
        readings : (T, L) array, in the quantity's unit
        stamp_ns : (T,) array, ns
        skip : int
            Readings at the start that are not wanted,
        before : int
            of which so many come before an iterative solver's first run.
        """
        each = self.estimates(readings, stamp_ns, before)[skip - before :]
        return Estimate.joined(each, stamp_ns=stamp_ns[skip:])

    def _into(self, operator: LinearFields, name: str, readings: Floats, out: NDArray[Any]) -> None:
        """Write an output of some readings (T, L) into `out` (T, R)."""
        mask = ~np.isnan(readings)
        linear = self._linearised(readings, mask)
        patterns, which = np.unique(mask, axis=0, return_inverse=True)
        for number, pattern in enumerate(patterns):
            rows = np.flatnonzero(which.ravel() == number)
            valid = pattern if operator.gaussian is None else np.ones_like(pattern)
            filled = self.reconstructor.plans.linear_of(pattern).filled(linear[rows])
            out[rows] = filled.astype(self.precision) @ self._matrix(name, valid)

    def _linearised(self, readings: Floats, valid: NDArray[np.bool_]) -> Floats:
        """Readings (T, L), 0 where not valid."""
        heard = readings if valid.all() else np.where(valid, readings, 0.0)
        return self.reconstructor.plan.linearised(heard)

    def _matrix(self, name: str, valid: NDArray[np.bool_]) -> NDArray[Any]:
        """From all taxels, of which some are valid, to an output (R): (L, R) of the precision."""
        return self._matrix_of(name, valid.tobytes())

    def _made_matrix(self, name: str, key: bytes) -> NDArray[Any]:
        operator = self.reconstructor.plans.linear_of(np.frombuffer(key, np.bool_))
        fields, grid = operator.fields, self.reconstructor.grid
        pressure, moved = fields[: len(grid)], fields[len(grid) :].reshape(3, len(grid), -1)
        blocks: dict[str, Callable[[], NDArray[Any]]] = {
            "pressure": lambda: pressure,
            "indentation": lambda: -np.einsum("ckl,kc->kl", moved, grid.normals),
            "displacement": lambda: moved.transpose(1, 0, 2).reshape(3 * len(grid), -1),
        }
        return np.ascontiguousarray(blocks[name]().T, dtype=self.precision)
