"""Solve slowly once (`prepare`), apply quickly for ever (`apply`)."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from skinfield.errors import Floats
from skinfield.observation import ObservationModel


@dataclass(frozen=True, eq=False)
class InverseOperator:
    """Prepared linear map from L readings to the pressure on K nodes.

    Attributes
    ----------
    matrix : (K, L) array, Pa per unit of the reading
    pressure_std : (K,) array, Pa
        One standard deviation of the pressure as the solver states it: a Bayesian one states its
        posterior, the others how far the noise of one reading moves their answer.
    """

    matrix: Floats
    pressure_std: Floats

    def apply(self, readings: Floats, out: Floats) -> None:
        """Write into `out` (K,), Pa, the pressure of linearised `readings` (L,). No allocation."""
        np.dot(self.matrix, readings, out=out)


class Solver(Protocol):
    """Anything with `prepare` is a solver: nothing to inherit, nowhere to register."""

    def prepare(self, model: ObservationModel, /) -> InverseOperator:
        """Do every computation that needs no reading."""
        ...


def propagated_std(matrix: Floats, noise_std: Floats) -> Floats:
    """How far independent noise (L,) moves the output of a matrix (K, L): (K,)."""
    return np.asarray(np.sqrt(np.square(matrix) @ np.square(noise_std)))
