"""Chosen fields of many readings of one patch, by whatever solver."""

from collections import OrderedDict
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_shape
from skinfield.fields import Contact, Estimate
from skinfield.pipeline.array_backend import ArrayBackend
from skinfield.pipeline.batch import (
    OUTPUTS,
    BulkProduct,
    checked_outputs,
    readings_per_product,
    rows_of,
)
from skinfield.pipeline.device_product import DeviceProduct, chunk_of
from skinfield.pipeline.plan import LinearPlan
from skinfield.pipeline.reconstructor import Reconstructor

RUN = 64  # readings that an iterative solver answers one from the other; the first starts anew
KEPT = 16  # sets of valid taxels that stay prepared
Fields = dict[str, NDArray[Any]]


class BulkFields:
    """Fields of many readings, in chunks; what is linear by one product per chunk.

    Parameters
    ----------
    reconstructor : Reconstructor
    outputs : iterable of str
        Of `OUTPUTS`: what to compute of each reading.
    precision : numpy.float32 or numpy.float64
        Of the answers.
    backend : ArrayBackend, optional
        Device of a linear solver's products. Default the host, where contacts are always found.

    Attributes
    ----------
    run : int
        Readings that belong together: a product's, or those that an iterative solver starts one
        from the other. Runs begin at multiples of it, and each begins anew, so that what a reading
        gives does not depend on which others are asked for.
    """

    def __init__(
        self,
        reconstructor: Reconstructor,
        outputs: Iterable[str] = ("pressure", "indentation"),
        precision: type[np.floating[Any]] = np.float32,
        backend: ArrayBackend | None = None,
    ) -> None:
        self.reconstructor = reconstructor
        self.outputs = checked_outputs(outputs)
        self.precision = precision
        plan = reconstructor.plans.whole
        self._linear = plan if isinstance(plan, LinearPlan) else None
        row_bytes = self.width * np.dtype(precision).itemsize
        self.run = RUN if self._linear is None else readings_per_product(row_bytes)
        self._backend = backend
        if backend is not None:
            if self._linear is None:
                raise InputError(
                    f"solver is {type(reconstructor.solver).__name__}(), expected a linear one "
                    f"such as GaussianField() for products on {backend.name}: leave the device out"
                )
            taxels = len(reconstructor.patch) * np.dtype(precision).itemsize
            self.run = chunk_of(backend, row_bytes + taxels)
        self._products: OrderedDict[bytes, BulkProduct | DeviceProduct] = OrderedDict()
        self._sets: OrderedDict[bytes, Any] = OrderedDict()

    @property
    def is_linear(self) -> bool:
        """Whether one product answers."""
        return self._linear is not None

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Of each output of one reading: (K,), or (K, 3) for a vector field."""
        nodes = len(self.reconstructor.grid)
        return {name: (nodes, 3) if OUTPUTS[name] == 3 else (nodes,) for name in self.outputs}

    @property
    def width(self) -> int:
        """Numbers that all outputs of one reading take."""
        return len(self.reconstructor.grid) * sum(OUTPUTS[name] for name in self.outputs)

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
            return self._joined(readings)
        out = np.empty((len(readings), self.width), self.precision)
        for first in range(0, len(readings), self.run):
            part = slice(first, first + self.run)
            self.into(readings[part], out[part])
        return self.named(out)

    def named(self, table: NDArray[Any]) -> Fields:
        """Views of a table (T, R) of all outputs, by name."""
        found, at = {}, 0
        for name, shape in self.shapes.items():
            width = int(np.prod(shape))
            found[name] = table[:, at : at + width].reshape(len(table), *shape)
            at += width
        return found

    def into(self, readings: Floats, out: NDArray[Any]) -> None:
        """Write all outputs of some readings (T, L), one after the other, into `out` (T, R).

        For linear solvers alone. With all taxels valid, nothing of the size of `out` is allocated.
        """
        plan = self._linear
        assert plan is not None
        mask = ~np.isnan(readings)
        if (mask == mask[0]).all():
            linear = self._linearised(readings if mask[0].all() else readings[:, mask[0]])
            self._product(mask[0]).fields(linear, out)
        elif plan.missing is not None:
            self._filled(readings, mask, out)
        else:
            for pattern, rows in _patterns(mask):
                linear = self._linearised(readings[np.ix_(rows, pattern)])
                out[rows] = self._product(pattern).fields(linear)

    def normal_force(self, readings: Floats) -> Floats:
        """Sum of the pressure of each of some readings, (T,) N; outputs: the pressure first.

        Fields are made one run at a time and let go: for the highest reading of hours.
        """
        nodes, area = len(self.reconstructor.grid), self.reconstructor.grid.cell_area
        if self._linear is None:
            return np.concatenate([e.normal_force for e in self.estimates(readings)])
        found = np.empty(len(readings))
        out = np.empty((min(self.run, len(readings)), self.width), self.precision)
        cells = np.full(nodes, area, self.precision)
        for first in range(0, len(readings), self.run):
            part = readings[first : first + self.run]
            self.into(part, out[: len(part)])
            found[first : first + len(part)] = out[: len(part), :nodes] @ cells
        return found

    def contacts(self, readings: Floats) -> list[tuple[Contact, ...]]:
        """Contacts of some readings (T, L), by the reconstructor's finder.

        Of a linear solver by the pressure in double precision alone, where the same taxels are
        valid in all of them.
        """
        mask = ~np.isnan(readings)
        if self._linear is None or not (mask == mask[0]).all():
            return [each for estimate in self.estimates(readings) for each in estimate.contacts]
        plan = self._plan(mask[0])
        linear = self._linearised(readings[:, mask[0]])
        product = BulkProduct(plan.operator[: len(self.reconstructor.grid)], np.float64, RUN)
        learnt, found = self.reconstructor.intervals, []
        for first in range(0, len(linear), RUN):
            for pressure in product.fields(linear[first : first + RUN]):
                each = plan.contacts(pressure, plan.noise, plan.posterior)
                found.append(each if learnt is None else learnt(each))
        return found

    def std(self, readings: Floats) -> Floats | None:
        """Deviation of the pressure (K,), Pa, if it is one for all of some readings (T, L)."""
        mask = ~np.isnan(readings)
        if self._linear is None or not (mask == mask[0]).all():
            return None
        return self._plan(mask[0]).pressure_std

    def estimates(self, readings: Floats) -> Iterator[Estimate]:
        """Everything of some readings, contacts too, as estimates of a run each."""
        for first in range(0, len(readings), RUN):
            self.reconstructor.reset()
            yield self.reconstructor(readings[first : first + RUN])

    def of_estimate(self, estimate: Estimate) -> Fields:
        """The outputs of an estimate of many readings."""
        return {
            name: np.asarray(getattr(estimate, name), dtype=self.precision) for name in self.outputs
        }

    def _joined(self, readings: Floats) -> Fields:
        found = {
            name: np.empty((len(readings), *shape), self.precision)
            for name, shape in self.shapes.items()
        }
        for number, estimate in enumerate(self.estimates(readings)):
            part = slice(number * RUN, (number + 1) * RUN)
            for name, values in self.of_estimate(estimate).items():
                found[name][part] = values
        return found

    def _linearised(self, readings: Floats) -> Floats:
        quantity = self.reconstructor.quantity
        return quantity.linearise(readings, np.empty(readings.shape))

    def _plan(self, valid: NDArray[np.bool_]) -> LinearPlan:
        plan = self._linear if valid.all() else self.reconstructor.plans.of(valid)
        assert isinstance(plan, LinearPlan)
        return plan

    def _product(self, valid: NDArray[np.bool_]) -> BulkProduct | DeviceProduct:
        key = np.packbits(valid).tobytes()
        if key not in self._products:
            rows = rows_of(self._plan(valid).operator, self.reconstructor.grid, self.outputs)
            _let_go(self._products)
            backend = self._backend
            self._products[key] = (
                BulkProduct(rows, self.precision, self.run)
                if backend is None
                else DeviceProduct(rows, backend, self.precision, self.run)
            )
        self._products.move_to_end(key)
        return self._products[key]

    def _filled(self, readings: Floats, mask: NDArray[np.bool_], out: NDArray[Any]) -> None:
        """Taxels that are missing are filled in from the others, so that one product serves all."""
        plan = self._linear
        assert plan is not None
        assert plan.missing is not None
        patterns, which = np.unique(mask, axis=0, return_inverse=True)
        key = np.packbits(patterns, axis=1).tobytes()
        if key not in self._sets:
            _let_go(self._sets)
            self._sets[key] = plan.missing.model.sets(patterns)
        self._sets.move_to_end(key)
        linear = self._linearised(np.where(mask, readings, 0.0))
        filled = self._sets[key].filled(linear, which.ravel())
        self._product(np.ones(mask.shape[1], np.bool_)).fields(filled, out)


def _let_go(kept: OrderedDict[bytes, Any]) -> None:
    if len(kept) >= KEPT:
        kept.popitem(last=False)


def _patterns(mask: NDArray[np.bool_]) -> Iterator[tuple[NDArray[np.bool_], NDArray[np.int64]]]:
    """Sets of taxels that are valid together, and the readings that have them."""
    patterns, which = np.unique(mask, axis=0, return_inverse=True)
    for number, pattern in enumerate(patterns):
        yield pattern, np.flatnonzero(which.ravel() == number)
