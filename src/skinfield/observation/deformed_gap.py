r"""Laplace's equation in the gap between the pads' plane and a surface of any shape above it.

The gap g(x, y) = 1 - v, in thicknesses, is mapped to a flat one by zeta = z/g, where the potential
is 1 - zeta, plus modes phi_j(zeta) that vanish on both electrodes, times functions a_j(x, y). The
field's energy is then, with :math:`\nabla` along the plane and sums over the modes,

.. math:: \int g\,|\nabla a|^2_M - 2\,(\nabla g\cdot\nabla a)\,C\,a
          + \frac{|\nabla g|^2}{g}\,|a|^2_E + \frac1g\,|a|^2_K,

with the integrals over zeta M of phi phi, C of phi zeta phi', E of zeta² phi' phi', and K of
phi' phi'. Derivatives along the plane are those of the Fourier series; conjugate gradients,
preconditioned by the flat gap, find the minimum. The charge below is the energy's derivative with
respect to the potential there.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError

MODES = 6  # polynomials in zeta, up to degree 7
TOLERANCE = 1e-4  # of the potential's change, in the energy's norm of the flat gap
MOST = 400  # steps of conjugate gradients
SHALLOW = 0.02  # strain up to which the third order has the charge to 1e-5 of the plate's

Spectra = NDArray[np.complex128]


def charge_below(strain: Floats, step: float) -> Floats:
    """Charge on the lower plane, relative to that of plates at rest, less one.

    Parameters
    ----------
    strain : (rows, columns) array
        v = w/h, below 1, on a mesh that is continued periodically: towards its borders it should
        go to 0 smoothly.
    step : float
        Of the mesh, in thicknesses.

    Returns
    -------
    (rows, columns) array

    Raises
    ------
    InputError
        If conjugate gradients do not settle: below a sharp edge that nearly reaches the pads.
    """
    gap = _Gap(1.0 - strain, step)
    change = gap.solve()
    return np.asarray(gap.inverse(gap.at_rest[0] + gap.response(change)[0]) - 1.0)


@dataclass(frozen=True, eq=False)
class _Modes:
    """Integrals over zeta; row and column 0 are of 1 - zeta, the rest of the modes."""

    mass: Floats
    stiffness: Floats
    mixed: Floats
    stretched: Floats
    eigenvalues: Floats


@lru_cache(maxsize=4)
def _modes(count: int) -> _Modes:
    """Modes that diagonalise mass (to 1) and stiffness, from integrals of Legendre polynomials."""
    from numpy.polynomial import legendre
    from scipy.linalg import eigh

    node, weight = legendre.leggauss(count + 4)
    zeta, weight = (node + 1) / 2, weight / 2
    values, slopes = [1 - zeta], [-np.ones_like(zeta)]
    for degree in range(2, count + 2):
        unit = np.eye(degree + 1)
        slopes.append(legendre.legval(node, unit[degree - 1]))
        bubble = legendre.legval(node, unit[degree] - unit[degree - 2])
        values.append(bubble / (2 * (2 * degree - 1)))
    value, slope = np.array(values), np.array(slopes)
    mass, stiffness = (value * weight) @ value.T, (slope * weight) @ slope.T
    eigenvalues, turn = eigh(stiffness[1:, 1:], mass[1:, 1:])
    value[1:], slope[1:] = turn.T @ value[1:], turn.T @ slope[1:]
    return _Modes(
        (value * weight) @ value.T,
        (slope * weight) @ slope.T,
        (value * weight * zeta) @ slope.T,
        (slope * weight * zeta**2) @ slope.T,
        eigenvalues,
    )


@dataclass(frozen=True, eq=False)
class _Gap:
    """A gap (rows, columns), in thicknesses, periodic, and the equation in it."""

    gap: Floats
    step: float

    @cached_property
    def modes(self) -> _Modes:
        return _modes(MODES)

    @cached_property
    def waves(self) -> tuple[Spectra, Spectra]:
        """Factors of the derivatives along x and y; what alternates has none."""
        from scipy import fft

        rows, columns = self.gap.shape
        kx, ky = fft.rfftfreq(columns, self.step), fft.fftfreq(rows, self.step)
        kx[columns // 2 :] *= columns % 2
        ky[rows // 2] *= rows % 2
        return np.asarray(2j * np.pi * kx), np.asarray(2j * np.pi * ky[:, None])

    @cached_property
    def slope(self) -> tuple[Floats, Floats]:
        kx, ky = self.waves
        spectrum = self.forward(self.gap)
        return self.inverse(kx * spectrum), self.inverse(ky * spectrum)

    @cached_property
    def steepness(self) -> Floats:
        along, across = self.slope
        return np.asarray((along**2 + across**2) / self.gap)

    def forward(self, values: Floats) -> Spectra:
        from scipy import fft

        return np.asarray(fft.rfft2(values))

    def inverse(self, spectra: Spectra) -> Floats:
        from scipy import fft

        return np.asarray(fft.irfft2(spectra, self.gap.shape))

    def divergence(self, along: Floats, across: Floats) -> Spectra:
        kx, ky = self.waves
        return np.asarray(kx * self.forward(along) + ky * self.forward(across))

    @cached_property
    def at_rest(self) -> Spectra:
        """Derivative of the energy with respect to all modes where there is 1 - zeta alone."""
        modes, (along, across) = self.modes, self.slope
        spread = self.divergence(along, across)
        steep, narrow = self.forward(self.steepness), self.forward(1 / self.gap)
        return np.stack(
            [
                modes.mixed[row, 0] * spread
                + modes.stretched[row, 0] * steep
                + modes.stiffness[row, 0] * narrow
                for row in range(MODES + 1)
            ]
        )

    def response(self, change: Spectra) -> Spectra:
        """What the modes add to that derivative, (MODES + 1, ...) from (MODES, ...)."""
        modes, (gx, gy), (kx, ky) = self.modes, self.slope, self.waves
        value = self.inverse(change)
        along, across = self.inverse(kx * change), self.inverse(ky * change)
        mixed = _mix(modes.mixed[:, 1:], value)
        flow_x = self.gap * _mix(modes.mass[:, 1:], along) - gx * mixed
        flow_y = self.gap * _mix(modes.mass[:, 1:], across) - gy * mixed
        source = _mix(modes.stiffness[:, 1:], value) / self.gap
        source += self.steepness * _mix(modes.stretched[:, 1:], value)
        source -= _mix(modes.mixed.T[:, 1:], gx * along + gy * across)
        return np.asarray(self.forward(source) - self.divergence(flow_x, flow_y))

    def solve(self) -> Spectra:
        """Spectra of the modes by conjugate gradients."""
        kx, ky = self.waves
        flat = 1 / (self.modes.eigenvalues[:, None, None] - kx**2 - ky**2).real
        rest = -self.at_rest[1:]
        found = np.zeros_like(rest)
        step = lifted = flat * rest
        size = start = self.product(rest, lifted)
        for _ in range(MOST):
            if size <= TOLERANCE**2 * start:
                return found
            answer = self.response(step)[1:]
            length = size / self.product(step, answer)
            found += length * step
            rest -= length * answer
            lifted = flat * rest
            before, size = size, self.product(rest, lifted)
            step = lifted + size / before * step
        raise InputError(
            f"indentation of {1 - self.gap.min():.2f} of the thickness is too steep for the field "
            "below it, expected less: lower the load, or read the series of order 3"
        )

    def product(self, one: Spectra, other: Spectra) -> float:
        """Inner product in the plane, from half of the spectrum."""
        each = np.sum(one.real * other.real + one.imag * other.imag, axis=(0, 1))
        twice = np.full(len(each), 2.0)
        twice[0] = 1.0
        if self.gap.shape[1] % 2 == 0:
            twice[-1] = 1.0
        return float(each @ twice)


def _mix(matrix: Floats, fields: Floats) -> Floats:
    return np.asarray(np.tensordot(matrix, fields, 1))
