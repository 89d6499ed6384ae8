"""Smooth pressure that is nowhere negative."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import InputError, check_positive, check_range
from skinfield.fields import PressureNoise
from skinfield.inverse.gaussian_field import GaussianField, taxel_distance
from skinfield.inverse.model_errors import NON_NEGATIVE
from skinfield.inverse.non_negative_operator import NonNegativeOperator
from skinfield.inverse.non_negative_prior import matern_precision
from skinfield.observation import ObservationModel

PITCHES = 0.4  # of the taxels, per length scale: longer than a linear field's, which may ring


@dataclass(frozen=True, kw_only=True)
class NonNegative:
    r"""The most probable field of a Gaussian prior that is nowhere negative.

    For extended shapes, such as bars, rings and feet, and wherever the sum of the field counts: on
    a capacitive, incompressible skin a linear solver's field sums to 0, this one's does not.

    Parameters
    ----------
    snr : float, dimensionless
        As that of `GaussianField`: amplitude of the expected readings over their noise.
    length_scale : float, m, optional
        Of the Matérn-3/2 covariance. Default 0.4 of the distance of neighbouring taxels.
    false_alarm_rate : float
        Readings of an idle patch that may be answered by anything but 0 everywhere, at most.
    shrinkage : float
        Penalty on the pressure as part of what would keep the idle patch at 0 by itself. 1 makes
        the test of `false_alarm_rate` the very condition that 0 is the minimum; less loses less of
        the force.
    tolerance : float, dimensionless
        The search ends where any weighted sum of the pressure, a force or a moment, is known to
        lie within `tolerance` of its posterior's standard deviations of the exact minimum's.
    most_iterations : int
        End it anyway after so many steps; `gap` of the operator tells how far it came.

    Notes
    -----
    With the whitened readings b = W y, signatures B = W A and the covariance Q of `GaussianField`

    .. math:: \min_{p \ge 0} \; f(p) = \tfrac12 |B p - b|^2 + \tfrac12 p^T Q^{-1} p + \mu^T p,
              \qquad \mu_i = s z |B_i|,

    with :math:`Q^{-1}` that of a field without end which is 0 beyond the grid, s `shrinkage` and z
    such that :math:`K (1 - \Phi(z))` is the false-alarm rate: on noise alone
    :math:`B_i^T b / |B_i|` is a standard normal number at each of the K nodes, so their largest
    exceeds z at most at that rate (Boole's inequality). Readings that do not exceed it are answered
    by p = 0. The penalty goes by node, as the same :math:`\mu` for all would take half of the
    force between taxels.

    Each step chooses free nodes, all with pressure and the steepest of the others, solves for them
    exactly (Cholesky) and goes there, clipped at 0, if f falls by enough (projected Newton,
    Bertsekas 1982). Where it does not, nodes are exchanged one by one until a step succeeds (Lawson
    and Hanson 1974), so that f never rises and the search ends. With the slope r at any p >= 0,
    its parts :math:`r^\pm` and S the covariance of the posterior without the constraint, the
    multipliers :math:`r^+` are feasible in the dual problem, whose value is below the minimum:

    .. math:: f(p) - f(p^*) \le p^T r^+ + \tfrac12 (r^-)^T S r^- =: \mathrm{gap}, \quad
              |w^T (p - p^*)| \le \sqrt{2\,\mathrm{gap}\; w^T S w}.

    In place of S stand its bounds by `pressure_std` and by the largest eigenvalue of Q, whichever
    is less, so the gap that is reported is an upper bound as well.
    """

    snr: float = 20.0
    length_scale: float | None = None
    false_alarm_rate: float = 1e-3
    shrinkage: float = 0.3
    tolerance: float = 1e-3
    most_iterations: int = 100

    def __post_init__(self) -> None:
        GaussianField(snr=self.snr, length_scale=self.length_scale)  # checks both
        check_range("false_alarm_rate", self.false_alarm_rate, 1e-12, 0.5, "a share of readings")
        check_range("shrinkage", self.shrinkage, 0.0, 1.0, "part of the detection threshold")
        check_positive("tolerance", self.tolerance, "in standard deviations of the posterior")
        if self.most_iterations < 1:
            raise InputError(f"most_iterations is {self.most_iterations}, expected 1 or more")

    def prepare(self, model: ObservationModel) -> NonNegativeOperator:
        """Whiten the taxels, invert the prior and set the threshold, once."""
        from scipy.special import ndtri

        length = self.length_scale or PITCHES * taxel_distance(model.taxels, model.grid.pitch)
        linear = GaussianField(snr=self.snr, length_scale=length).prepare(model)
        posterior = linear.posterior
        assert posterior is not None  # a GaussianField has one
        signatures = np.ascontiguousarray((model.matrix / model.noise_std[:, None]).T)
        strength = np.sqrt(np.einsum("kl,kl->k", signatures, signatures))
        chances = max(int(np.count_nonzero(strength)), 1)
        threshold = float(-ndtri(self.false_alarm_rate / chances))
        operator = NonNegativeOperator(
            signatures=signatures,
            whitening=1.0 / model.noise_std,
            strength=strength,
            threshold=threshold,
            penalty=self.shrinkage * threshold * strength,
            precision=matern_precision(model.grid, length, float(posterior.prior[0, 0])),
            shape=model.grid.shape,
            noise=PressureNoise(linear.matrix * model.noise_std),
            posterior=posterior,
            tolerance=self.tolerance,
            most_iterations=self.most_iterations,
            model_error=NON_NEGATIVE.of(model),
        )
        operator.run_in()
        return operator
