"""Pieces of a recording, reconstructed in this process or in many."""

import os
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.campaign import in_order
from skinfield.errors import Floats, Ints
from skinfield.fields import Estimate
from skinfield.pipeline.array_backend import ArrayBackend
from skinfield.pipeline.batch_fields import RUN, BulkFields
from skinfield.pipeline.batch_results import LazyResults
from skinfield.sinks.contact_rows import Row, rows_from_estimate
from skinfield.sinks.field_series import Arrays, series_of
from skinfield.sources import open_results

PIECE = {"fields": 4096, "contacts": 512, "iterative": 2 * RUN}  # readings per piece of work
PATIENCE = 2.0  # s of work in this process before others are thought of
WORTH = 6.0  # s of work left from which they are started: each takes a second or more to begin


@dataclass(frozen=True)
class Task:
    """What is made of every reading.

    Attributes
    ----------
    path : Path
        Of the results that hold the readings.
    contacts, fields : bool
        Whether contacts are found, and fields kept: the pressure's sum is always taken.
    device : str, optional
        Of the products, see `ArrayBackend.on`; default the host.
    """

    path: Path
    contacts: bool
    fields: bool
    device: str | None = None


@dataclass(frozen=True, eq=False)
class Part:
    """What a piece of work gives.

    Attributes
    ----------
    first : int
        Its first reading.
    force : (N,) array, N
        Sum of the pressure.
    load : (N,) array, N
        Sum of the contacts' forces, where they were found; else as `force`.
    contacts : (N,) int array
        Their number.
    dead : (L,) bool array
        Taxels that are valid in none of them.
    rows : list of Row
        For a table of contacts.
    series : dict of arrays, or None
        For a file of fields.
    seconds : float
    """

    first: int
    force: Floats
    load: Floats
    contacts: Ints
    dead: NDArray[np.bool_]
    rows: list[Row]
    series: Arrays | None
    seconds: float


class Worker:
    """Prepared work on pieces of one file of results."""

    def __init__(self, task: Task, results: LazyResults | None = None) -> None:
        self.task = task
        self.results = open_results(task.path) if results is None else results
        self.start_ns = int(self.results.stamp_ns[0])

    @cached_property
    def bulk(self) -> BulkFields:
        """Prepared when the first piece comes."""
        names = ("pressure", "displacement") if self.task.fields else ("pressure",)
        device = self.task.device
        backend = None if device is None else ArrayBackend.on(device)
        return BulkFields(self.results.reconstructor, names, backend=backend)

    def __call__(self, piece: tuple[int, int]) -> Part:
        """Readings first to last."""
        begun, (first, last) = time.perf_counter(), piece
        start = first if self.bulk.is_linear else first - first % RUN
        values = self.results.kept.values(start, last)
        if self.bulk.is_linear and not (self.task.contacts or self.task.fields):
            force, none = self.bulk.normal_force(values), np.zeros(len(values), np.int64)
            dead = np.asarray(np.isnan(values).all(axis=0))
            return Part(first, force, force, none, dead, [], None, time.perf_counter() - begun)
        estimate = self._estimate(values, first - start, self.results.kept.stamps(first, last))
        force = estimate.pressure.sum(axis=1, dtype=np.float64) * self.results.grid.cell_area
        load, rows = force, []
        counts = np.zeros(last - first, np.int64)
        if self.task.contacts:
            load = np.array([sum(c.normal_force for c in each) for each in estimate.contacts])
            counts = np.array([len(each) for each in estimate.contacts])
            rows = list(rows_from_estimate(estimate, first, self.start_ns))
        series = series_of(estimate) if self.task.fields else None
        dead = np.asarray(~estimate.valid.any(axis=0))
        seconds = time.perf_counter() - begun
        return Part(first, force, load, counts, dead, rows, series, seconds)

    def _estimate(self, values: Floats, skip: int, stamps: Ints) -> Estimate:
        """What the task asks for of some readings; the first ones but warm the solver up."""
        bulk, std = self.bulk, self.bulk.std(values)
        if not bulk.is_linear or (self.task.fields and std is None):
            return self._joined(list(bulk.estimates(values)), slice(skip, None), stamps)
        found, grid = bulk(values), self.results.grid
        rest: dict[str, Callable[[], Any]] = {
            "contacts": partial(bulk.contacts, values),
            "displacement": lambda: found["displacement"],
            "pressure_std": lambda: np.broadcast_to(np.asarray(std), found["pressure"].shape),
            "traction": lambda: -found["pressure"][..., None] * grid.normals,
            "residual": lambda: np.full(values.shape, np.nan),
        }
        known = {"grid": grid, "pressure": found["pressure"], "stamp_ns": stamps}
        return Estimate.later(rest, valid=~np.isnan(values), **known)

    def _joined(self, estimates: list[Estimate], part: slice, stamps: Ints) -> Estimate:
        def joined(name: str) -> Any:
            return np.concatenate([getattr(each, name) for each in estimates])[part]

        names = ("displacement", "pressure_std", "traction", "residual")
        rest: dict[str, Callable[[], Any]] = {name: partial(joined, name) for name in names}
        rest["contacts"] = lambda: [c for each in estimates for c in each.contacts][part]
        known = {"grid": self.results.grid, "pressure": joined("pressure"), "stamp_ns": stamps}
        return Estimate.later(rest, valid=joined("valid"), **known)


def parts(
    task: Task, results: LazyResults, readings: range, processes: int | None
) -> Iterator[Part]:
    """Work on some readings in a row, the answers in order.

    Parameters
    ----------
    task : Task
    results : LazyResults
        The same that the task names.
    readings : range
    processes : int, optional
        Default as many as there are cores, once the work has taken some seconds and will take more.
    """
    pieces = list(_pieces(task, results, readings))
    if processes is not None and processes > 1:
        yield from in_order(Worker, (task,), pieces, min(processes, len(pieces)))
        return
    worker, begun = Worker(task, results), time.perf_counter()
    for done, piece in enumerate(pieces, 1):
        yield worker(piece)
        spent, left = time.perf_counter() - begun, len(pieces) - done
        more = processes is None and cores() > 1 and spent > PATIENCE
        if more and spent / done * left > WORTH:
            yield from in_order(Worker, (task,), pieces[done:], min(cores(), left))
            return


def _pieces(task: Task, results: LazyResults, readings: range) -> Iterator[tuple[int, int]]:
    """Cut at multiples of the size, so that runs of an iterative solver stay whole."""
    kind = "contacts" if task.contacts or task.fields else "fields"
    size = PIECE[kind if results.is_linear else "iterative"]
    first = readings.start
    while first < readings.stop:
        last = min(first - first % size + size, readings.stop)
        yield first, last
        first = last


def cores() -> int:
    """Cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on every system
        return os.cpu_count() or 1
