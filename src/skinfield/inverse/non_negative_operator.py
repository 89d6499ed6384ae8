"""Prepared search for the pressure of a `NonNegative` field, reading by reading."""

import time
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, check_shape
from skinfield.fields import ModelError, PressureNoise, PressurePosterior
from skinfield.inverse.operator import InverseOperator
from skinfield.observation import ObservationModel

if TYPE_CHECKING:
    from skinfield.inverse.dual.arrays import Problem

BY_TIME = -1  # of the compiled search: it ends by itself, or where its time does
LAPS = 6  # of the run in, after which the times of steps are known


class Linear(Protocol):
    """A solver whose operator is linear."""

    def prepare(self, model: ObservationModel, /) -> InverseOperator:
        """Do every computation that needs no reading."""
        ...


@dataclass(frozen=True, eq=False)
class Backing:
    """The field without the constraint: what contacts and their uncertainty are told by.

    Attributes
    ----------
    solver : Linear
    model : ObservationModel
        Of all taxels.
    whole : Backing, optional
        That of all taxels, if some are left out.
    valid : (L,) bool array, optional
        Which of those are not.
    """

    solver: Linear
    model: ObservationModel
    whole: "Backing | None" = None
    valid: NDArray[np.bool_] | None = None

    @cached_property
    def operator(self) -> InverseOperator:
        """Prepared when it is first asked for: the search itself does not need it."""
        if self.whole is None or self.valid is None:
            return self.solver.prepare(self.model)
        gaussian = self.whole.operator.gaussian
        if gaussian is None:
            return self.solver.prepare(self.model.subset(self.valid))
        sets = gaussian.sets(self.valid[None])  # a low-rank update, some milliseconds
        posterior = sets.posterior(0)
        return InverseOperator(sets.matrix(0), posterior.std, posterior)

    @property
    def noise(self) -> PressureNoise:
        """How the readings' noise moves this field."""
        std = self.model.noise_std if self.valid is None else self.model.noise_std[self.valid]
        return PressureNoise(self.operator.matrix * std)

    def without(self, valid: NDArray[np.bool_]) -> "Backing":
        """Of the valid taxels, by a mask (L,)."""
        return Backing(self.solver, self.model, self, valid)


@dataclass(eq=False)
class NonNegativeOperator:
    """Prepared search, with what it needs to start from the reading before.

    One reading at a time: it works in its own arrays. Patches of equal geometry share what is
    prepared by `twin`.

    Parameters
    ----------
    problem : Problem
        Arrays of the compiled search.
    backing : Backing
        The field without the constraint. The constraint only narrows a posterior, so that one's is
        too wide rather than too narrow where the model is right.
    model_error : ModelError
        That a contact has without noise.
    taxels : int
        L.

    Attributes
    ----------
    iterations : int
        Newton steps that the last reading took.
    gap : float, dimensionless
        The share of its objective by which the last answer may be above the minimum, at most: 0 to
        1. It is proved, by a dual value; of an idle patch by its test, with the `penalty` of then.
    objective : float, dimensionless
        That of the last answer.
    deadline_met : bool
        Whether the last answer was there in time.
    rooms : tuple of uint8 arrays
        What it works in, to be touched so that a processor has it at hand.
    """

    problem: "Problem"
    backing: Backing
    model_error: ModelError
    taxels: int
    deadline_met: bool = field(default=True, init=False)

    def __post_init__(self) -> None:
        from skinfield.inverse.dual.arrays import memory_in, packed, room_for
        from skinfield.inverse.dual.search import answer

        nodes, width = self.problem.rows.shape
        room = room_for(nodes, width, self.problem.rows.dtype)
        self._memory = memory_in(nodes, width, room)
        self._packed, self._answer = packed(self.problem, room), answer
        self.rooms = tuple(each.view(np.uint8) for each in room)
        self._readings = np.zeros(self.taxels)

    @property
    def pressure_std(self) -> Floats:
        """Posterior deviation of the linear field without the constraint, (K,) Pa."""
        return self.backing.operator.pressure_std

    @property
    def posterior(self) -> PressurePosterior | None:
        """Posterior of the linear field without the constraint."""
        return self.backing.operator.posterior

    @property
    def noise(self) -> PressureNoise:
        """How noise moves the linear field: a stand-in by which contacts are told."""
        return self.backing.noise

    @property
    def gap(self) -> float:
        """Share of the objective by which the last answer may be above the minimum."""
        return float(self._memory.measures[0])

    @property
    def objective(self) -> float:
        """Objective of the last answer."""
        return float(self._memory.measures[1])

    @property
    def idle(self) -> bool:
        """Whether the last reading was proved to hold no contact."""
        return bool(self._memory.counts[0])

    @property
    def iterations(self) -> int:
        """Newton steps that the last reading took."""
        return int(self._memory.counts[2])

    @property
    def ending(self) -> int:
        """How the last search ended, for `again`: all of it that depended on time."""
        return int(self._memory.counts[6])

    @property
    def dual(self) -> NDArray[Any]:
        """Multipliers r of the last answer, (L,), in whitened units: the grid is not in them."""
        return self._memory.dual[: self.taxels]

    @property
    def penalty(self) -> NDArray[Any]:
        """Penalty on the amount of each node in the last answer's problem, (K,).

        That of the full threshold if the patch was idle, for which 0 is the minimum.
        """
        if self.idle:
            return np.asarray(self.threshold * self.problem.norms)
        return self.problem.penalty

    @property
    def threshold(self) -> float:
        """Standard deviations that the most significant node must exceed."""
        return float(self.problem.threshold)

    def start_from(self, dual: Floats) -> None:
        """Begin the next reading from another operator's `dual` (L,), such as a coarser grid's."""
        check_shape("dual", dual, (self.taxels,), "one per taxel")
        self._memory.dual[: self.taxels] = dual
        self._memory.counts[4] = 1

    def reset(self) -> None:
        """Forget the reading before."""
        self._memory.counts[:] = 0
        self._memory.dual[:] = 0.0
        self._memory.measures[:2] = np.nan
        self._memory.measures[5] = 0.0

    def twin(self) -> "NonNegativeOperator":
        """Share all that is prepared, with a memory of its own: for a patch of equal geometry."""
        return self._with(self.problem)

    def within(self, nodes: NDArray[np.bool_]) -> "NonNegativeOperator":
        """Search only some nodes, by a mask (K,); the gap is still that of all nodes."""
        check_shape("nodes", nodes, self.problem.norms.shape, "one per node")
        allowed = np.array(nodes, dtype=np.bool_)
        return self._with(self.problem._replace(allowed=allowed))

    def without(self, valid: NDArray[np.bool_]) -> "NonNegativeOperator":
        """Leave out taxels, by a mask (L,) of those to use.

        It still takes all L readings; those left out may be anything, NaN as well. The bumps keep
        their size, where a fresh `prepare` would have the same power spread over fewer taxels.
        """
        check_shape("valid", valid, (self.taxels,), "one per taxel")
        old = self.problem
        rows = old.rows.copy()
        rows[:, : self.taxels][:, ~valid] = 0.0
        norms = np.linalg.norm(rows, axis=1).astype(rows.dtype)
        rate = np.divide(old.penalty, old.norms, out=np.zeros_like(norms), where=old.norms > 0.0)
        whitening = np.where(valid, old.whitening, 0.0)
        changed = old._replace(rows=rows, norms=norms, penalty=rate * norms, whitening=whitening)
        return self._with(changed, self.backing.without(valid))

    def leave_out(self, whole: "NonNegativeOperator", valid: NDArray[np.bool_]) -> None:
        """Become `whole.without(valid)` in place, from any other operator of `whole.without`.

        It takes a few passes over one matrix and no memory: for taxels that fail while readings
        come in. The uncertainty that it states stays what it was.
        """
        from skinfield.inverse.dual.masking import mask_taxels

        old, now, vectors = whole.problem, self.problem, self._packed.vectors
        mask_taxels(old.rows, old.norms, old.penalty, valid, now.rows, now.norms, now.penalty)
        nodes = len(now.norms)
        vectors[:nodes], vectors[nodes : 2 * nodes] = now.norms, now.penalty
        np.multiply(old.whitening, valid, out=now.whitening)
        self.reset()

    def apply(self, readings: Floats, out: Floats, deadline_ns: int | None = None) -> None:
        """Write into `out` (K,), Pa, the pressure of linearised `readings` (L,).

        At `deadline_ns` of `time.perf_counter_ns` it holds the best pressure so far, which is
        nowhere negative and explains the readings no worse than 0; no step is begun that would
        take longer than is left, going by those before.
        """
        self._readings[:] = readings
        limit = 0 if deadline_ns is None else max(deadline_ns, 1)
        self._answer(self._packed, self._readings, out, limit, BY_TIME)
        self.deadline_met = deadline_ns is None or time.perf_counter_ns() <= deadline_ns

    def again(self, readings: Floats, out: Floats, ending: int) -> None:
        """As `apply`, up to where a search had come that ended so: the same, bit for bit.

        If this operator began where that one began, which is what `reset`, the readings since and
        `start_from` make it. Where `ending` is another afterwards, it did not.
        """
        self._readings[:] = readings
        self._answer(self._packed, self._readings, out, 0, max(ending, 0))
        self.deadline_met = True

    def run_in(self) -> None:
        """Compile, and learn how long steps take, so that the first reading is in time."""
        out = np.empty(len(self.problem.norms))
        white = self.problem.whitening
        strongest = int(np.argmax(self.problem.norms))
        clear = self.problem.rows[strongest, : self.taxels].astype(np.float64)
        clear *= 4.0 * self.threshold / max(float(np.linalg.norm(clear)), 1e-300)
        paces = []
        for lap in range(LAPS):
            self._memory.measures[:] = 0.0
            bend = 1.0 + 0.1 * lap * np.cos(np.arange(self.taxels))
            self.apply(clear * bend / white, out)
            paces.append(self._memory.measures.copy())
        self._memory.measures[:] = np.median(paces, axis=0)
        self.reset()

    def _with(self, problem: "Problem", backing: Backing | None = None) -> "NonNegativeOperator":
        backing = self.backing if backing is None else backing
        other = NonNegativeOperator(problem, backing, self.model_error, self.taxels)
        other._memory.measures[2:] = self._memory.measures[2:]
        other._memory.measures[:2] = np.nan
        return other
