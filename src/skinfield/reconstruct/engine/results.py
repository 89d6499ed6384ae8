"""Results of a cycle: arrays that stay where they are, and estimates of each patch made of them."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, Ints
from skinfield.estimate import Contact, ContactFinder, Estimate, Wrench
from skinfield.estimate.wrench import wrenches_by_link
from skinfield.reconstruct.engine.patch_kinds import PatchGroup
from skinfield.reconstruct.engine.report import CycleReport
from skinfield.reconstruct.engine.state import FEASIBLE, LINEAR
from skinfield.reconstruct.engine.workspace import Clockwork
from skinfield.reconstruct.plan import details, field_contacts
from skinfield.skin import Grid
from skinfield.solve import Operator, Solution
from skinfield.solve.atoms.fit_kernel import NOW


class PatchResults:
    """Arrays (P,) over the patches in the skin's order, overwritten by each `Engine.run`.

    Parameters
    ----------
    work : Clockwork
    rows : sequence of int
        Of each patch, in the skin's order, among those of `work`.

    Attributes
    ----------
    answer : int64 array
        Of `Answer`: 0 missing, 1 idle, 2 linear, 3 field, 4 contacts.
    rung : int64 array
        Of the answer, counted from the coarsest; -1 where there is none.
    gap : array
        Relative; NaN where none is known.
    iterations : int64 array
    invalid : int64 array
        Taxels that were left out.
    age : int64 array
        Cycles since a touched patch was last searched.
    settled : bool array
        Whether the search of a touched patch came to its end.
    """

    def __init__(self, work: Clockwork, rows: Sequence[int]) -> None:
        self._work, self._rows = work, list(rows)
        self._order = None if self._rows == sorted(self._rows) else np.array(self._rows)
        self._copied: list[tuple[NDArray[Any], NDArray[Any]]] = []
        state = work.state
        self.answer: Ints = self._in_order(state.answer)
        self.rung: Ints = self._in_order(state.rung)
        self.gap: Floats = self._in_order(state.gap)
        self.iterations: Ints = self._in_order(state.iterations)
        self.invalid: Ints = self._in_order(state.invalid)
        self.age: Ints = self._in_order(state.age)
        self.settled: NDArray[np.bool_] = self._in_order(state.settled)
        self._fields = [self._fields_of(row) for row in self._rows]
        self._whites = [work.intake.white[work.intake.rows_of(row)] for row in self._rows]

    def _in_order(self, array: NDArray[Any]) -> NDArray[Any]:
        """The array itself, or room for its numbers in the skin's order."""
        if self._order is None:
            return array
        self._copied.append((array, array.copy()))
        return self._copied[-1][1]

    def update(self) -> None:
        """Bring the answers into the skin's order, where the engine has another."""
        if self._order is not None:
            for source, target in self._copied:
                np.take(source, self._order, out=target, mode="clip")

    def pressure_of(self, patch: int) -> NDArray[Any]:
        """Pressure (K,) of a patch, counted in the skin's order: a view. 0 where it is missing.

        Of a linear answer in float32, else in float64.
        """
        row = self._rows[patch]
        linear, feasible, nothing = self._fields[patch]
        answer, rung = self._work.state.answer[row], int(self._work.state.rung[row])
        fields = linear if answer == LINEAR else feasible if answer >= FEASIBLE else nothing
        return fields[rung]

    def contacts_of(self, patch: int) -> tuple[NDArray[Any], int]:
        """Contacts of a patch that a solver found by itself: rows, of equal geometry's first."""
        data = self._data_of(patch)
        return data.rows, data.count

    def explained_of(self, patch: int) -> tuple[Floats, float, int]:
        """What these explain of its readings (L,), what part may be wrong, and how many."""
        data = self._data_of(patch)
        return data.fit.memory.predicted[NOW], data.fit.misfit, data.count

    def _data_of(self, patch: int) -> Any:
        work, row = self._work, self._rows[patch]
        group, place = work.places[row]
        return group.data[int(work.state.rung[row])][place]

    def shift_of(self, patch: int) -> Floats:
        """From the plane of the first patch of its kind to that of a patch, (2,) m."""
        return patch_shift(*self._work.places[self._rows[patch]])

    def whitened_of(self, patch: int) -> NDArray[Any]:
        """Readings (L,) of a patch in units of their noise, 0 where not valid: a view."""
        return self._whites[patch]

    def row_of(self, patch: int) -> int:
        """Where a patch, counted in the skin's order, stands among those of the engine's work."""
        return self._rows[patch]

    def _fields_of(
        self, row: int
    ) -> tuple[list[NDArray[Any]], list[NDArray[Any]], list[NDArray[Any]]]:
        """Of a patch on each rung: where linear and searched answers are written, and zeros."""
        group: PatchGroup = self._work.places[row][0]
        place = row - group.first
        zeros: list[NDArray[Any]] = [np.zeros(each.shape[1]) for each in group.fields]
        for each in zeros:
            each.setflags(write=False)
        linear = [each[place] for each in group.fields]
        return linear, [each[place].solution.pressure for each in group.data], zeros


def patch_shift(group: PatchGroup, place: int) -> Floats:
    """From the plane of the first patch of a group to that of another one, (2,) m."""
    return np.array(group.kind.patches[place].plane[0] - group.kind.patches[0].plane[0])


def grid_on(group: PatchGroup, place: int, rung: int) -> Grid:
    """Nodes of a rung on one of the patches, which lie where those of the first do."""
    grid, shift = group.rungs.steps[rung].grid, patch_shift(group, place)
    return replace(grid, patch=group.kind.patches[place], origin=grid.origin + shift)


def estimate_of(
    work: Clockwork,
    finder: ContactFinder,
    patch: int,
    grid_of: Callable[[int, int], Grid],
    stamp_ns: int,
    report: CycleReport,
    relative: bool,
) -> Estimate:
    """Copy a patch's answer out of the arrays; contacts and deformation follow when asked for."""
    state, intake = work.state, work.intake
    group = work.groups[state.group[patch]]
    place, rung, answer = patch - group.first, int(state.rung[patch]), int(state.answer[patch])
    step, grid, rows = group.rungs.steps[rung], grid_of(patch, rung), intake.rows_of(patch)
    pressure, valid = _pressure(group, answer, rung, place), intake.valid[rows].copy()
    filled = work.white[group.index][place] * group.kind.noise_std

    def explained() -> Floats:
        if work.linear:
            return np.asarray(group.rungs.start.explained @ filled)
        return np.asarray(step.operator.model.matrix @ pressure)

    operator: Operator = step.start if answer == LINEAR else step.operator
    name = type(operator.solver).__name__
    solution = Solution(pressure, intake.linear[rows].copy(), name, operator)
    if answer >= FEASIBLE:
        solution = group.data[rung][place].solution.keep()
        if place and solution.fit is not None:  # its contacts stand on the first patch
            shift = patch_shift(group, place)
            solution.fit = solution.fit.keep().on(grid, shift)
    solution.gap, solution.steps = float(state.gap[patch]), int(state.iterations[patch])
    find, deformation = field_contacts(finder, grid), step.deformation.on(grid)
    parts = valid, grid, deformation, find, None, explained if answer < FEASIBLE else None
    rest = details(solution, solution.pressure, *parts)
    return Estimate.later(
        rest,
        grid=grid,
        pressure=solution.pressure,
        valid=valid,
        gap=solution.gap,
        iterations=solution.steps,
        solver=solution.solver,
        is_field=solution.fit is None,
        latency=report.spent,
        stamp_ns=stamp_ns,
        deadline_met=not report.overrun,
        notes=(*_notes(work, answer, valid), *solution.notes),
        relative=relative,
    )


def _pressure(group: PatchGroup, answer: int, rung: int, place: int) -> Floats:
    if answer == LINEAR:
        return np.asarray(group.fields[rung][place], dtype=np.float64)
    if answer >= FEASIBLE:
        return np.array(group.data[rung][place].solution.pressure)
    return np.zeros(len(group.rungs.steps[rung].grid))


def _notes(work: Clockwork, answer: int, valid: NDArray[np.bool_]) -> tuple[str, ...]:
    notes = []
    if answer == LINEAR and not work.linear:
        notes.append("no time to search: the clipped linear answer, without a certificate")
    if not valid.all():
        missing = int(len(valid) - valid.sum())
        which = "" if answer >= FEASIBLE else "; pressure_std is that of all taxels"
        notes.append(f"{missing} taxels left out{which}")
    return tuple(notes)


class MissingPatch(InputError, KeyError):
    """A patch that was not answered in a cycle."""

    __str__ = Exception.__str__


class Estimates(Mapping[str, Estimate]):
    """Estimates of one cycle by the names of patches; those without an answer are not in it.

    An estimate is copied out of the engine's arrays when it is first asked for, which must be
    before the engine's next cycle; `keep` does so for all.

    Parameters
    ----------
    links : mapping of str to str
        Names of the skin's patches, in its order, and of their links.
    estimate_of : function of a name
        Copies the estimate of a patch.
    is_last : function
        Whether the cycle is still the engine's last.
    report : CycleReport
    """

    def __init__(
        self,
        links: Mapping[str, str],
        estimate_of: Callable[[str], Estimate],
        is_last: Callable[[], bool],
        report: CycleReport,
    ) -> None:
        self.report = report
        self._links, self._estimate_of, self._is_last = links, estimate_of, is_last
        self._made: dict[str, Estimate] = {}

    def __getitem__(self, name: str) -> Estimate:
        if name not in self._made:
            self._check(name)
            self._made[name] = self._estimate_of(name)
        return self._made[name]

    def __contains__(self, name: object) -> bool:
        return name in self.report.names and name not in self.report.missing

    def __iter__(self) -> Iterator[str]:
        missing = set(self.report.missing)
        return (name for name in self._links if name not in missing)

    def __len__(self) -> int:
        return len(self.report.names) - len(self.report.missing)

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """Contacts of all patches, by falling normal force; each knows its link."""
        found = [contact for estimate in self.values() for contact in estimate.contacts]
        return tuple(sorted(found, key=lambda contact: -contact.normal_force))

    @property
    def wrenches(self) -> dict[str, Wrench]:
        """Wrench of all contacts on each link, about its origin and in its frame.

        A link is there once all of its patches are answered in this cycle.
        """
        missing = {self._links[name] for name in self.report.missing}
        each = [pair for estimate in self.values() for pair in estimate.wrenches.items()]
        return wrenches_by_link(pair for pair in each if pair[0] not in missing)

    def keep(self) -> "Estimates":
        """Copy all estimates now, so that they outlast the engine's next cycle."""
        for name in self:
            self[name]
        return self

    def _check(self, name: str) -> None:
        why = self.report[name].skipped
        if name in self.report.missing:
            raise MissingPatch(
                f"patch {name!r} was not answered in this cycle: {why}; see `report.missing`"
            )
        if not self._is_last():
            raise InputError(
                f"the estimate of {name!r} was asked for after the engine's next cycle, expected "
                "before: its arrays hold newer answers; take what you need, or call "
                "`estimates.keep()`, before the next cycle"
            )
