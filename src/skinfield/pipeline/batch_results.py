"""Results that are kept as readings, and computed when they are looked at."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, check_choice, check_count
from skinfield.fields import Contact, Estimate
from skinfield.layout import Grid, Patch
from skinfield.pipeline.batch import CHUNK
from skinfield.pipeline.batch_fields import RUN, BulkFields, Fields
from skinfield.pipeline.batch_lazy import ChunkCache, LazyArray, LazyList
from skinfield.pipeline.batch_recipe import Recipe
from skinfield.pipeline.reconstructor import Reconstructor

ALL = ("pressure", "indentation", "displacement")


class KeptReadings(Protocol):
    """Readings of a patch that need not be in memory."""

    def __len__(self) -> int: ...

    def stamps(self, first: int, last: int) -> NDArray[np.int64]:
        """Of readings first to last, ns."""
        ...

    def values(self, first: int, last: int) -> Floats:
        """Readings first to last, (last - first, L), in the quantity's unit; NaN where invalid."""
        ...


class LazyResults:
    """Everything that a recording's readings say, computed when it is asked for.

    Attributes
    ----------
    recipe : Recipe
        What the reconstructor is made of: patch, grid, solver and so on.
    notes : tuple of str
        What was assumed, found and left out when the readings were conditioned.
    source : str
        Where the readings come from.
    stamp_ns : (T,) LazyArray of int64, ns
    readings : (T, L) LazyArray of float64, in the quantity's unit
        NaN where a taxel did not answer.
    pressure : (T, K) LazyArray, Pa
    indentation : (T, K) LazyArray, m
    displacement : (T, K, 3) LazyArray, m
    normal_force : (T,) LazyArray of float64, N
        Sum of the pressure over the grid.
    contacts : LazyList of T tuples of Contact

    Notes
    -----
    Chunks are computed as a whole and the last ones are kept, so looking at neighbours is quick.
    A solver that starts from the reading before does so within runs of 64 readings, which begin at
    multiples of 64: what a reading gives never depends on how it was asked for.
    """

    def __init__(
        self,
        recipe: Recipe,
        kept: KeptReadings,
        *,
        precision: type[np.floating[Any]] = np.float32,
        cache_bytes: int = 256 << 20,
        notes: tuple[str, ...] = (),
        source: str = "",
    ) -> None:
        self.recipe, self.kept, self.precision = recipe, kept, precision
        self.notes, self.source = notes, source
        self._cache = ChunkCache(cache_bytes)
        self._bulk: dict[str, BulkFields] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        """For pickles: settings and readings, or where they lie; nothing that was computed."""
        parts = self.recipe, self.kept, self.precision, self._cache.most_bytes
        return _again, (*parts, self.notes, self.source)

    def __len__(self) -> int:
        return len(self.kept)

    def __repr__(self) -> str:
        return (
            f"LazyResults({len(self)} readings of {len(self.patch)} taxels of "
            f"{self.patch.name!r}, grid {self.grid.shape}, {self.recipe.solver})"
        )

    @property
    def patch(self) -> Patch:
        """Whose readings they are."""
        return self.recipe.patch

    @property
    def grid(self) -> Grid:
        """The K nodes."""
        return self.recipe.grid

    @cached_property
    def reconstructor(self) -> Reconstructor:
        """Prepared when it is first needed."""
        return self.recipe.reconstructor()

    def using(self, **parts: Any) -> "LazyResults":
        """The same readings in another way.

        Parameters
        ----------
        **parts
            Of `Recipe`: such as ``solver=NonNegative()`` or a finer ``grid``.
        """
        for name in parts:
            check_choice("part", name, ("grid", "solver", "mechanics", "finder", "noise_std"),
                         "what may be another for the same readings")  # fmt: skip
        return LazyResults(
            replace(self.recipe, **parts), self.kept, precision=self.precision,
            cache_bytes=self._cache.most_bytes, notes=self.notes, source=self.source,
        )  # fmt: skip

    @cached_property
    def stamp_ns(self) -> LazyArray:
        """Of each reading, (T,) ns."""
        return LazyArray((len(self),), np.int64, 65536, self.kept.stamps, self._cache)

    @cached_property
    def readings(self) -> LazyArray:
        """In the quantity's unit, (T, L)."""
        shape = (len(self), len(self.patch))
        return LazyArray(shape, np.float64, 8 * CHUNK, self.kept.values, self._cache)

    @cached_property
    def pressure(self) -> LazyArray:
        """Positive in compression, (T, K) Pa."""
        return self._array("pressure", ())

    @cached_property
    def indentation(self) -> LazyArray:
        """Displacement into the skin along its normal, (T, K) m."""
        return self._array("indentation", ())

    @cached_property
    def displacement(self) -> LazyArray:
        """Of the surface, in the patch's frame, (T, K, 3) m."""
        return self._array("displacement", (3,))

    @cached_property
    def normal_force(self) -> LazyArray:
        """Sum of the pressure over the grid, (T,) N."""
        area = self.grid.cell_area

        def load(first: int, last: int) -> Floats:
            pressure = self.pressure[first:last]
            return np.asarray(pressure.sum(axis=1, dtype=np.float64) * area)

        return LazyArray((len(self),), np.float64, self.pressure.chunk, load, self._cache)

    @cached_property
    def contacts(self) -> LazyList:
        """Of each reading, a tuple in order of falling force."""
        if self.is_linear:
            size = 4096 + 8 * len(self.grid)  # they keep their pressure for what is asked later
            return LazyList(len(self), 1, self._contacts, self._cache, size)
        return LazyList(len(self), RUN, lambda a, b: self._solved(a)[1], self._cache)

    def estimate(self, reading: int) -> Estimate:
        """Everything of one reading, by the reconstructor itself and from nothing before.

        Raises
        ------
        InputError
            If there is no such reading.
        """
        check_count("reading", reading, -len(self), len(self) - 1, "one of those that are kept")
        at = reading % len(self)
        self.reconstructor.reset()
        return self.reconstructor(
            self.kept.values(at, at + 1)[0], stamp_ns=self.kept.stamps(at, at + 1)[0]
        )

    def blocks(self, *names: str, rows: int = CHUNK) -> Iterator[tuple[slice, Fields]]:
        """Chosen fields of all readings, block by block: memory stays bounded.

        Parameters
        ----------
        *names : str
            Of pressure, indentation, displacement, normal_force, readings, stamp_ns.
        rows : int
            Readings per block.

        Yields
        ------
        where : slice
        fields : dict of arrays
        """
        known = (*ALL, "normal_force", "readings", "stamp_ns")
        for name in names:
            check_choice("name", name, known, "a field of results")
        for first in range(0, len(self), rows):
            part = slice(first, min(first + rows, len(self)))
            yield part, {name: getattr(self, name)[part] for name in names}

    def to_xarray(self) -> Any:
        """An `xarray.Dataset` of the fields, computed when looked at; needs `skinfield[xarray]`."""
        from skinfield.fields.lazy_labelled import dataset_from_lazy

        pictures = {name: self._picture(getattr(self, name)) for name in ALL}
        return dataset_from_lazy(self.grid, self.stamp_ns[:], pictures)

    @property
    def is_linear(self) -> bool:
        """Whether one matrix product answers."""
        return self._fields("pressure").is_linear

    def _fields(self, *names: str) -> BulkFields:
        key = " ".join(names)
        if key not in self._bulk:
            self._bulk[key] = BulkFields(self.reconstructor, names, self.precision)
        return self._bulk[key]

    def _array(self, name: str, tail: tuple[int, ...]) -> LazyArray:
        def load(first: int, last: int) -> NDArray[Any]:
            if self.is_linear:
                return self._fields(name)(self.kept.values(first, last))[name]
            return self._solved(first)[0][name]

        def into(first: int, last: int, out: NDArray[Any]) -> None:
            self._fields(name).into(self.kept.values(first, last), out.reshape(last - first, -1))

        shape, run = (len(self), len(self.grid), *tail), self._fields(name).run
        direct = into if self.is_linear else None
        array = LazyArray(shape, self.precision, run, load, self._cache, direct)
        array.origin = self, name
        return array

    def _picture(self, array: LazyArray) -> LazyArray:
        """The same with rows and columns of nodes."""
        shape = (len(self), *self.grid.shape, *array.shape[2:])

        def load(first: int, last: int) -> NDArray[Any]:
            return np.asarray(array[first:last]).reshape(last - first, *shape[1:])

        return LazyArray(shape, array.dtype, array.chunk, load, self._cache)

    def _contacts(self, first: int, last: int) -> tuple[tuple[Contact, ...], ...]:
        return tuple(self._fields("pressure").contacts(self.kept.values(first, last)))

    def _solved(self, first: int) -> tuple[Fields, tuple[tuple[Contact, ...], ...]]:
        """Everything of a run of an iterative solver: it comes at once, so it is kept at once."""

        def make() -> tuple[Fields, tuple[tuple[Contact, ...], ...]]:
            bulk = self._fields(*ALL)
            run = self.kept.values(first, min(first + RUN, len(self)))
            estimate = next(bulk.estimates(run))
            return bulk.of_estimate(estimate), tuple(estimate.contacts)

        found: tuple[Fields, tuple[tuple[Contact, ...], ...]] = self._cache.get(
            ("run", first), make, lambda made: sum(a.nbytes for a in made[0].values())
        )
        return found


def _again(
    recipe: Recipe, kept: KeptReadings, precision: Any, most: int, notes: Any, source: str
) -> LazyResults:
    """Results in another process."""
    return LazyResults(
        recipe, kept, precision=precision, cache_bytes=most, notes=notes, source=source
    )
