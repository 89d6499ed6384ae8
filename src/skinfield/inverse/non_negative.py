"""Smooth pressure that is nowhere negative, with a proof of how good the answer is."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skinfield.errors import InputError, check_positive, check_range
from skinfield.inverse.bumps import bump_of, seen_through
from skinfield.inverse.gaussian_field import GaussianField, taxel_distance
from skinfield.inverse.model_errors import NON_NEGATIVE
from skinfield.inverse.non_negative_operator import Backing, NonNegativeOperator
from skinfield.inverse.non_negative_problem import problem_of
from skinfield.inverse.tikhonov import Tikhonov
from skinfield.observation import ObservationModel

PITCHES = 0.3  # of the taxels, per length scale: longer than a linear field's, which may ring


@dataclass(frozen=True, kw_only=True)
class NonNegative:
    r"""The most probable sum of smooth bumps, none of which pulls.

    For extended shapes, such as bars, rings and feet, and wherever the sum of the field counts: on
    a capacitive, incompressible skin a linear solver's field sums to 0, this one's does not. Each
    answer carries a bound of what more time could gain, and there is one at any deadline.

    Parameters
    ----------
    snr : float, dimensionless
        As that of `GaussianField`: amplitude of the expected readings over their noise.
    length_scale : float, m, optional
        Of the Matérn-3/2 covariance of the pressure. Default 0.3 of the distance of neighbouring
        taxels; 0 for cells that are independent, the least squares with a penalty on the squared
        pressure and on its sum.
    false_alarm_rate : float
        Readings of an idle patch that may be answered by anything but 0 everywhere, at most.
    shrinkage : float
        Penalty on the pressure as part of what would keep the idle patch at 0 by itself. 1 makes
        the test of `false_alarm_rate` the very condition that 0 is the minimum; less loses less of
        the force.
    tolerance : float, dimensionless
        The search ends where the objective is known to be at most this share of it above the
        minimum.
    most_iterations : int
        End it anyway after so many Newton steps.
    precision : numpy.float32 or numpy.float64
        Of the search. Rounding, of 1e-6 of the objective or so in float32, is part of the gap.

    Notes
    -----
    The pressure is p = G z, where G are bumps that are nowhere negative (a root of the Matérn
    covariance; see `bumps`) and z their amounts. With the whitened readings b = W y and B = W A G

    .. math:: \min_{z \ge 0} \; P(z) = \tfrac12 |B z - b|^2 + \tfrac12 |z|^2 + \mu^T z,
              \qquad \mu_k = s z_* |B_k|,

    with s `shrinkage` and z* such that :math:`K (1 - \Phi(z_*))` is the false-alarm rate: on noise
    alone :math:`B_k^T b / |B_k|` is a standard normal number at each of the K nodes, so their
    largest exceeds z* at most at that rate (Boole's inequality). Readings that do not exceed it are
    those of an idle patch: of these the problem is the one with s = 1, whose minimum is z = 0 if
    and only if they do not exceed it, so that p = 0 is its exact answer, with a gap of 0. Once
    something is felt, the whole threshold would take too much of its force, and s is `shrinkage`.
    The bumps are scaled so that the prior's readings have, over the taxels, `snr` times the noise's
    power: tr(B B') = L snr².

    It is solved in its dual, with an unknown r per taxel, however many nodes there are:

    .. math:: \max_r \; D(r) = b^T r - \tfrac12 |r|^2 - \tfrac12 |z(r)|^2, \quad
              z(r) = \max(0, B^T r - \mu), \quad \nabla D = b - r - B\, z(r).

    Any r gives amounts z(r) that are feasible, and no answer's objective is below D(r): the gap
    P - D is a proof, which one product with B' costs. Each step is a semismooth Newton step
    (Hintermüller, Ito and Kunisch, SIAM J. Optim. 13, 2002) to where D is highest along it, with a
    system of as many equations as there are pressed nodes or taxels, whichever is less; only nodes
    near to being pressed are looked at, until all are at last. The search starts from the dual of
    the reading before, if something there still stands out of the noise; else from where D is
    highest on the way from 0 to b.

    As P is at least as curved as the posterior, :math:`|w^T (p - p^*)|^2 \le 2 (P - D)\, w^T S w`
    for any weights w, a force or a moment, with S the covariance without the constraint.
    """

    snr: float = 15.0
    length_scale: float | None = None
    false_alarm_rate: float = 1e-3
    shrinkage: float = 0.5
    tolerance: float = 1e-4
    most_iterations: int = 100
    precision: type[np.floating[Any]] = np.float32

    def __post_init__(self) -> None:
        check_positive("snr", self.snr, "the prior's variance is proportional to snr**2")
        if self.length_scale is not None and self.length_scale != 0.0:
            check_positive("length_scale", self.length_scale, "in metres, or 0")
        check_range("false_alarm_rate", self.false_alarm_rate, 1e-12, 0.5, "a share of readings")
        check_range("shrinkage", self.shrinkage, 0.0, 1.0, "part of the detection threshold")
        check_range("tolerance", self.tolerance, 1e-12, 1.0, "a share of the objective")
        if self.most_iterations < 1:
            raise InputError(f"most_iterations is {self.most_iterations}, expected 1 or more")
        if self.precision not in (np.float32, np.float64):
            raise InputError(
                f"precision is {self.precision!r}, expected numpy.float32 or numpy.float64"
            )

    def prepare(self, model: ObservationModel) -> NonNegativeOperator:
        """Whiten the taxels, look through the bumps and set the threshold, once."""
        length = self._length(model)
        bump = bump_of(model.grid, length)
        whitening = 1.0 / model.noise_std
        seen = seen_through(bump, model.matrix * whitening[:, None], model.grid)
        power = float(np.square(seen).sum())
        if not power > 0.0:
            raise InputError("no taxel sees any node: the matrix is 0; check grid and layout")
        scale = np.sqrt(self.snr**2 * len(seen) / power)
        problem = problem_of(self, model.grid, seen.T * scale, bump * scale, whitening)
        linear = (
            Tikhonov(snr=self.snr)
            if length == 0.0
            else GaussianField(snr=self.snr, length_scale=length)
        )
        operator = NonNegativeOperator(
            problem, Backing(linear, model), NON_NEGATIVE.of(model), len(whitening)
        )
        operator.run_in()
        return operator

    def _length(self, model: ObservationModel) -> float:
        if self.length_scale is None:
            return PITCHES * taxel_distance(model.taxels, model.grid.pitch)
        return self.length_scale
