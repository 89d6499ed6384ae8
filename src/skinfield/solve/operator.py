"""Solve slowly once (`prepare`), apply quickly for ever."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import ObservationModel
from skinfield.errors import Floats
from skinfield.estimate import Contact, ModelError, PressureError, PressureNoise, PressurePosterior
from skinfield.solve.gaussian_model import GaussianModel

EXACT = ModelError()


@dataclass(frozen=True, eq=False)
class InverseOperator:
    """Prepared linear map from L readings to the pressure on K nodes.

    Attributes
    ----------
    matrix : (K, L) array, Pa per unit of the reading
    pressure_std : (K,) array, Pa
        One standard deviation of the pressure as the solver states it: a Bayesian one states its
        posterior, the others how far the noise of one reading moves their answer.
    posterior : PressurePosterior, optional
        Of a Bayesian solver: its contacts' covariance. Else that is of the readings' noise alone.
    model_error : ModelError
        What is wrong with its contacts beside: added to their covariance.
    gaussian : GaussianModel, optional
        Of a Bayesian solver: by which it answers without some of its taxels at little cost.
    """

    matrix: Floats
    pressure_std: Floats
    posterior: PressurePosterior | None = None
    model_error: ModelError = EXACT
    gaussian: GaussianModel | None = None

    def apply(self, readings: Floats, out: Floats) -> None:
        """Write into `out` (K,), Pa, the pressure of linearised `readings` (L,). No allocation."""
        np.dot(self.matrix, readings, out=out)

    def without(self, valid: NDArray[np.bool_]) -> "InverseOperator | None":
        """What the solver would prepare, with the same prior, for the taxels of a mask (L,) alone.

        None where that does not follow from this operator: the solver must prepare it then.
        """
        if self.gaussian is None:
            return None
        sets = self.gaussian.sets(np.asarray(valid, dtype=np.bool_)[None])
        posterior = sets.posterior(0)
        return InverseOperator(sets.matrix(0), posterior.std, posterior, self.model_error)


class Beliefs(Protocol):
    """What is known of the errors of an answer."""

    @property
    def pressure_std(self) -> Floats:
        """One standard deviation of the pressure as the solver states it, (K,) Pa."""
        ...

    @property
    def noise(self) -> PressureNoise:
        """How the readings' noise moves the pressure, about: contacts are told from it."""
        ...

    @property
    def posterior(self) -> PressureError | None:
        """By which contacts are said to be sure, if by more than the readings' noise."""
        ...

    @property
    def model_error(self) -> ModelError:
        """What is wrong with contacts beside: added to their covariance."""
        ...


class FieldOperator(Beliefs, Protocol):
    """Prepared map that is not linear, from L readings to the pressure on K nodes."""

    @property
    def posterior(self) -> PressurePosterior | None:
        """See `Beliefs`."""
        ...

    def apply(self, readings: Floats, out: Floats, deadline_ns: int | None = None) -> None:
        """Write into `out` (K,), Pa, the pressure of linearised `readings` (L,).

        `deadline_ns` is a time of `time.perf_counter_ns`, at which the best answer so far is kept.
        """
        ...


class Fit(Protocol):
    """What a solver that finds contacts by itself makes of one reading."""

    @property
    def pressure(self) -> Floats:
        """(K,), Pa."""
        ...

    @property
    def pressure_std(self) -> Floats:
        """(K,), Pa."""
        ...

    @property
    def displacement(self) -> Floats:
        """(K, 3), m, in the patch's frame."""
        ...

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """By falling normal force."""
        ...

    @property
    def predicted(self) -> Floats:
        """What the taxels would read of them, (L,), in the quantity's unit."""
        ...

    @property
    def offset(self) -> float:
        """That all taxels are taken to share, in the quantity's unit; part of what is predicted."""
        ...

    @property
    def explained(self) -> bool:
        """Whether noise accounts for what the contacts leave over."""
        ...

    @property
    def notes(self) -> tuple[str, ...]:
        """On the answer, in sentences."""
        ...


@runtime_checkable
class ContactOperator(Protocol):
    """Prepared search for the contacts that explain L readings."""

    @property
    def extended(self) -> FieldOperator | None:
        """What answers the readings that no few contacts explain."""
        ...

    def fit(self, readings: Floats, deadline_ns: int | None = None) -> Fit:
        """Contacts and fields of `readings` (L,) in the quantity's unit.

        `deadline_ns` is a time of `time.perf_counter_ns`, at which the best answer so far is kept.
        """
        ...

    def reset(self) -> None:
        """Forget the reading before, from which the next one starts."""
        ...


class Solver(Protocol):
    """Anything with `prepare` is a solver: nothing to inherit, nowhere to register."""

    def prepare(
        self, model: ObservationModel, /
    ) -> InverseOperator | FieldOperator | ContactOperator:
        """Do every computation that needs no reading."""
        ...


def propagated_std(matrix: Floats, noise_std: Floats) -> Floats:
    """How far independent noise (L,) moves the output of a matrix (K, L): (K,)."""
    return np.asarray(np.sqrt(np.square(matrix) @ np.square(noise_std)))
