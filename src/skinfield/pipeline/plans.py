"""Plans of a patch for whichever of its taxels answer, and readings dealt out to them."""

from collections import OrderedDict
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints
from skinfield.inverse import Solver
from skinfield.pipeline.contact_plan import make_plan
from skinfield.pipeline.field_plan import FieldPlan
from skinfield.pipeline.missing import distinct
from skinfield.pipeline.plan import Answer, LinearPlan, Plan, Results, Setting

KEPT = 16  # sets of valid taxels whose plans stay prepared, beside that of all


class Plans:
    """What is prepared for all taxels, and for sets of them as they come.

    Parameters
    ----------
    setting : Setting
    solver : Solver
    whole : Plan, optional
        Of all taxels, if it is there already.
    """

    def __init__(self, setting: Setting, solver: Solver, whole: Plan | None = None) -> None:
        self.setting, self._solver = setting, solver
        every = np.ones(len(setting.model.noise_std), np.bool_)
        self.whole = make_plan(setting, solver, every) if whole is None else whole
        self._kept: OrderedDict[bytes, Plan] = OrderedDict()

    def of(self, valid: NDArray[np.bool_]) -> Plan:
        """Plan of the valid taxels, (L,)."""
        if valid.all():
            return self.whole
        key = np.packbits(valid).tobytes()
        if key not in self._kept:
            if len(self._kept) >= KEPT:
                self._kept.popitem(last=False)
            self._kept[key] = self._without(valid)
        self._kept.move_to_end(key)
        return self._kept[key]

    def _without(self, valid: NDArray[np.bool_]) -> Plan:
        shorter = self.whole.without(valid) if isinstance(self.whole, FieldPlan) else None
        return make_plan(self.setting, self._solver, valid) if shorter is None else shorter

    def solve(
        self, table: Floats, valid: NDArray[np.bool_], out: Results, deadline: float | None
    ) -> None:
        """Write the answers of readings (T, L), where `valid` (T, L), into `out`."""
        for pattern, rows in _patterns(valid, self._without_missing(table, valid, out)):
            part = table[rows] if pattern.all() else table[np.ix_(rows, pattern)]
            self.of(pattern).solve(part, rows, out, deadline)

    def prompt(self, reading: Floats, valid: NDArray[np.bool_], end: int | None) -> Answer | None:
        """Answer one reading (L,) at once; None where the plan computes all that there is."""
        whole = bool(valid.all())
        own = reading.copy()  # what is computed later is of this one; the caller may write over his
        if isinstance(self.whole, LinearPlan):
            return self.whole.prompt(own, end) if whole else self.whole.prompt_among(own, valid)
        plan = self.of(valid)
        if not isinstance(plan, FieldPlan):
            return None
        return plan.prompt(own if whole else own[valid], end)

    def within(self, setting: Setting) -> "Plans":
        """The same in another setting of the same patch."""
        other = Plans(setting, self._solver, self.whole.within(setting))
        other._kept.update((key, plan.within(setting)) for key, plan in self._kept.items())
        return other

    def reset(self) -> None:
        """Forget the readings before."""
        for plan in (self.whole, *self._kept.values()):
            plan.reset()

    def run_in(self) -> None:
        """Load what is compiled for contacts and displacement."""
        if isinstance(self.whole, (LinearPlan, FieldPlan)):
            peak = np.zeros(len(self.setting.grid))
            peak[len(peak) // 2] = 1e3 * max(float(self.whole.noise.std.max()), 1.0)
            self.whole.contacts(peak, self.whole.noise, self.whole.posterior)
            self.setting.deformation(np.zeros(len(self.setting.model.grid)))

    def _without_missing(self, table: Floats, valid: NDArray[np.bool_], out: Results) -> Ints:
        """Answer the readings that lack taxels, if the plan of all taxels can; rows that remain."""
        full, plan = valid.all(axis=1), self.whole
        if full.all() or not isinstance(plan, LinearPlan) or plan.missing is None:
            return np.arange(len(valid))
        rows = np.flatnonzero(~full)
        plan.missing.solve(plan, table[rows], valid[rows], rows, out)
        return np.flatnonzero(full)


def _patterns(valid: NDArray[np.bool_], rows: Ints) -> Iterator[tuple[NDArray[np.bool_], Ints]]:
    """Sets of taxels that are valid together in some rows, and the rows that have them."""
    if len(rows) == 1 or valid[rows].all():
        yield from [(valid[rows[0]], rows)] if len(rows) else []
        return
    patterns, which = distinct(valid[rows])
    for index, pattern in enumerate(patterns):
        yield pattern, rows[which == index]
