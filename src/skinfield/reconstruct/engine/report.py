"""Report of a cycle: what it did for each patch, and what it left undone."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skinfield.errors import InputError
from skinfield.reconstruct.engine.state import Answer, EngineState
from skinfield.reconstruct.engine.workspace import Clockwork

WORDS = {
    Answer.MISSING: "missing",
    Answer.IDLE: "idle",
    Answer.LINEAR: "linear",
    Answer.FEASIBLE: "field",
    Answer.CONTACTS: "contacts",
}


@dataclass(frozen=True)
class PatchReport:
    """How one patch was answered in one cycle.

    Attributes
    ----------
    name : str
    answer : str
        ``"idle"``: nothing stands out of the noise at the solver's false-alarm rate, so that 0 is
        the exact minimum with the whole threshold as the penalty, see `NonNegative`; ``"linear"``:
        of a linear solver, or the clipped start of an iterative one; ``"field"``: searched,
        with its gap; ``"missing"``: no reading.
    rung : int
        Nodes a side of the grid of the answer; 0 where there is none.
    gap : float
        Relative duality gap; NaN where none is known.
    iterations : int
    invalid : int
        Taxels that were left out.
    spent : float, s
        Of the steps for this patch alone.
    waited : int
        Cycles since it was last searched, where it has a contact.
    skipped : str
        What more time would have brought, and why it was not done; empty if nothing.
    """

    name: str
    answer: str
    rung: int
    gap: float
    iterations: int
    invalid: int
    spent: float
    waited: int
    skipped: str


@dataclass(frozen=True, eq=False)
class CycleReport:
    """How the budget of one cycle was spent; the report of a patch by its name.

    Attributes
    ----------
    budget, spent : float, s
    first : float, s
        Until every patch had its idle test, or its first answer of a linear solver.
    started : int, ns
        Of the engine's clock.
    overrun : bool
        Whether more than the budget was spent.
    names : tuple of str
        Of the patches.
    """

    budget: float
    spent: float
    first: float
    started: int
    overrun: bool
    names: tuple[str, ...]
    _state: EngineState
    _left: float
    _sides: Sequence[int]
    _linear: bool
    _why_missing: Mapping[int, str]

    @classmethod
    def of(
        cls,
        work: Clockwork,
        names: tuple[str, ...],
        sides: Sequence[int],
        left: float,
        **known: Any,
    ) -> "CycleReport":
        """Copy what of a cycle's work the next one changes, as it left it."""
        missing = np.flatnonzero(~work.intake.present).tolist()
        return cls(
            **known,
            names=names,
            _state=work.state.copy(),
            _left=left,
            _sides=sides,
            _linear=work.linear,
            _why_missing={place: _why(work, place) for place in missing},
        )

    def __getitem__(self, name: str) -> PatchReport:
        if name not in self.names:
            raise InputError(
                f"no patch is named {name!r}, expected one of {', '.join(self.names[:8])}"
            )
        place, state = self.names.index(name), self._state
        rung = int(state.rung[place])
        return PatchReport(
            name=name,
            answer=WORDS[Answer(state.answer[place])],
            rung=self._sides[rung] if rung >= 0 else 0,
            gap=float(state.gap[place]),
            iterations=int(state.iterations[place]),
            invalid=int(state.invalid[place]),
            spent=float(state.spent[place]),
            waited=int(state.age[place]),
            skipped=self._skipped(place),
        )

    def __iter__(self) -> Iterator[PatchReport]:
        return (self[name] for name in self.names)

    def __len__(self) -> int:
        return len(self.names)

    @property
    def missing(self) -> tuple[str, ...]:
        """Patches that were not answered: they gave no reading, or none that can be used."""
        return self._named(Answer.MISSING)

    @property
    def idle(self) -> tuple[str, ...]:
        """Patches on which nothing stands out of the noise, at the solver's false-alarm rate."""
        return self._named(Answer.IDLE)

    @property
    def skipped(self) -> tuple[str, ...]:
        """What was left undone, and why, in sentences."""
        return tuple(f"{each.name}: {each.skipped}" for each in self if each.skipped)

    def _named(self, answer: Answer) -> tuple[str, ...]:
        there = np.flatnonzero(self._state.answer == answer)
        return tuple(self.names[place] for place in there)

    def _skipped(self, place: int) -> str:
        answer = Answer(self._state.answer[place])
        if answer == Answer.MISSING:
            return self._why_missing.get(place, "no reading")
        left = f"{max(self._left, 0.0) * 1e6:.0f} µs left"
        if answer == Answer.IDLE or self._linear:
            return ""
        if answer == Answer.LINEAR:
            return f"search: no time, {left}"
        return "" if self._state.settled[place] else f"more iterations: no time, {left}"


def _why(work: Clockwork, place: int) -> str:
    """Why a patch was not answered."""
    invalid = int(work.state.invalid[place])
    if not invalid:
        return "no reading"
    if invalid == work.intake.sizes[place]:
        return "no valid taxel"
    return (
        f"{invalid} taxels did not answer, and this solver cannot leave them out within a cycle: "
        "GaussianField(), Tikhonov() and NonNegative() can"
    )
