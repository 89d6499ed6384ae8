"""What a cycle found: an estimate of each patch, made when it is asked for."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from skinfield.engine.report import CycleReport
from skinfield.errors import InputError
from skinfield.fields import Estimate

if TYPE_CHECKING:
    from skinfield.engine.engine import Engine


class MissingPatch(InputError, KeyError):
    """A patch that was not answered in a cycle."""

    __str__ = Exception.__str__


class Estimates(Mapping[str, Estimate]):
    """Estimates of one cycle by the names of patches; those without an answer are not in it.

    An estimate is copied out of the engine's arrays when it is first asked for, which must be
    before the engine's next cycle; `keep` does so for all.

    Attributes
    ----------
    report : CycleReport
    """

    def __init__(self, engine: "Engine", cycle: int, report: CycleReport, stamp_ns: int) -> None:
        self.report = report
        self._engine, self._cycle, self._stamp_ns = engine, cycle, stamp_ns
        self._made: dict[str, Estimate] = {}

    def __getitem__(self, name: str) -> Estimate:
        if name not in self._made:
            self._check(name)
            self._made[name] = self._engine.estimate_of(name, self._stamp_ns, self.report)
        return self._made[name]

    def __contains__(self, name: object) -> bool:
        return name in self.report.names and name not in self.report.missing

    def __iter__(self) -> Iterator[str]:
        missing = set(self.report.missing)
        return (name for name in self._engine.names if name not in missing)

    def __len__(self) -> int:
        return len(self.report.names) - len(self.report.missing)

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
        if self._engine.cycle != self._cycle:
            raise InputError(
                f"the estimate of {name!r} was asked for after the engine's next cycle, expected "
                "before: its arrays hold newer answers; take what you need, or call "
                "`estimates.keep()`, before the next cycle"
            )
