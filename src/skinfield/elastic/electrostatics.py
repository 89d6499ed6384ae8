r"""Capacitance of guarded pads under a deformed ground plane.

With v = w/h the strain of the gap and multipliers of its Fourier transform

.. math:: S = \frac{kh}{\sinh kh}, \qquad \mathcal D = kh \coth kh,

the change of the charge on the lower plane is, relative to the plate's own charge,

.. math:: S\left[v + v\,\mathcal D v + v\,\mathcal D (v\,\mathcal D v)
          - \tfrac12 v^2 (kh)^2 v + \dots\right],

which is v + v² + v³ for a uniform gap, as 1/(1 - v) - 1 demands. Where the surface comes down by
more than some hundredths of the gap, `charge_below` has the charge without a series: it solves
Laplace's equation in the gap between the pads' plane and a surface of any shape above it.

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
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from skinfield.elastic.hankel import electrostatic, jinc
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


class _Modes(NamedTuple):
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
    def waves(self) -> tuple[Spectra, Spectra]:
        """Factors of the derivatives along x and y; what alternates has none."""
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
        return np.asarray(fft.rfft2(values))

    def inverse(self, spectra: Spectra) -> Floats:
        return np.asarray(fft.irfft2(spectra, self.gap.shape))

    def divergence(self, along: Floats, across: Floats) -> Spectra:
        kx, ky = self.waves
        return np.asarray(kx * self.forward(along) + ky * self.forward(across))

    @cached_property
    def at_rest(self) -> Spectra:
        """Derivative of the energy with respect to all modes where there is 1 - zeta alone."""
        modes, (along, across) = _modes(MODES), self.slope
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
        modes, (gx, gy), (kx, ky) = _modes(MODES), self.slope, self.waves
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
        flat = 1 / (_modes(MODES).eigenvalues[:, None, None] - kx**2 - ky**2).real
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


STEPS = 10  # samples of the surface per thickness: for shorter waves S is below 1e-11
MARGIN = 4.0  # thicknesses of surface around pads and grid: S falls as exp(-pi r/h)
GUARD = 3.0  # thicknesses between a mesh and its periodic images
AROUND = 2.0  # thicknesses around what is too deep for the series
TAPER = 1.0  # thicknesses at the border of that, over which the surface goes back to its rest


@dataclass(frozen=True, eq=False)
class GapStrain:
    """Indentation over thickness on a fine regular mesh of the plane.

    Attributes
    ----------
    values : (rows, columns) array
        Positive where the gap is narrower.
    origin : (2,) array, m
        The first sample, in the plane.
    step : float, m
        Between samples.
    """

    values: Floats
    origin: Floats
    step: float

    def __post_init__(self) -> None:
        deepest = float(self.values.max())
        if deepest >= 1.0:
            raise InputError(
                f"indentation reaches {deepest:.2f} of the thickness, expected below 1: the skin "
                "would touch its base; lower the load or raise the modulus"
            )


def capacitance_change(
    strain: GapStrain, thickness: float, taxels: Floats, pad_diameter: float, order: int | None = 3
) -> Floats:
    """Relative change of capacitance (L,) of pads at (L, 2) m of the plane.

    Parameters
    ----------
    strain : GapStrain
        Its mesh should cover the pads with some `MARGIN` thicknesses more.
    thickness, pad_diameter : float, m
    order : 1, 2, 3 or None
        Of the series in the strain; None for the field in the deformed gap itself.

    Raises
    ------
    InputError
        If a pad reaches beyond the mesh.
    """
    from scipy import ndimage

    place = (taxels - strain.origin) / strain.step
    reach = pad_diameter / 2 / strain.step
    last = np.array(strain.values.shape)[::-1] - 1
    beyond = ((place < reach - 1e-6) | (place > last - reach + 1e-6)).any(axis=1)
    if beyond.any():
        at = tuple(np.round(taxels[np.argmax(beyond)] * 1e3, 3).tolist())
        raise InputError(f"pad at {at} mm lies beyond the mesh of the strain, expected within")
    if order not in (1, 2, 3, None):
        raise InputError(
            f"order is {order!r}, expected 1, 2 or 3 terms of the series, or None for the field"
        )
    spectrum, waves = _charge(strain, thickness, order)
    spectrum *= jinc(waves.kh, pad_diameter / 2 / thickness)
    means = fft.irfft2(spectrum, waves.shape)[tuple(slice(n) for n in strain.values.shape)]
    return np.asarray(ndimage.map_coordinates(means, place.T[::-1], order=5, mode="nearest"))


@dataclass(frozen=True, eq=False)
class _Waves:
    """Wave numbers times thickness of a mesh that is continued by a flat gap."""

    shape: tuple[int, int]
    kh: Floats

    @classmethod
    def of(cls, strain: GapStrain, thickness: float) -> "_Waves":
        guard = int(np.ceil(GUARD * thickness / strain.step))
        rows, columns = (fft.next_fast_len(n + guard, real=True) for n in strain.values.shape)
        step = strain.step / thickness
        ky, kx = fft.fftfreq(rows, step)[:, None], fft.rfftfreq(columns, step)
        return cls((rows, columns), 2 * np.pi * np.hypot(kx, ky))


def _series(v: Floats, order: int, waves: _Waves) -> Floats:
    kh = waves.kh
    coth = np.where(kh < 1e-6, 1.0, kh / np.tanh(np.maximum(kh, 1e-6)))

    def multiply(field: Floats, multiplier: Floats) -> Floats:
        spectrum = fft.rfft2(field, waves.shape) * multiplier
        return np.asarray(fft.irfft2(spectrum, waves.shape)[: v.shape[0], : v.shape[1]])

    total = v.copy()
    if order >= 2:
        second = v * multiply(v, coth)
        total += second
    if order >= 3:
        total += v * multiply(second, coth) - v**2 * multiply(v, kh**2) / 2
    return total


def _charge(
    strain: GapStrain, thickness: float, order: int | None
) -> tuple[NDArray[np.complex128], _Waves]:
    """Spectrum of the charge's density on the lower plane, relative to the plate's, less one."""
    waves = _Waves.of(strain, thickness)
    series = _series(strain.values, 3 if order is None else order, waves)
    spectrum = np.asarray(fft.rfft2(series, waves.shape) * electrostatic(waves.kh))
    box = _deep(strain, thickness) if order is None else None
    if box is None:
        return spectrum, waves
    missing = np.zeros(strain.values.shape)
    missing[box] = _beyond_series(strain, thickness, box)
    return spectrum + np.asarray(fft.rfft2(missing, waves.shape)), waves


def _deep(strain: GapStrain, thickness: float) -> tuple[slice, slice] | None:
    """Part of the mesh around where the series falls short."""
    deep = np.abs(strain.values) > SHALLOW
    if not deep.any():
        return None
    more = int(np.ceil(AROUND * thickness / strain.step))
    rows, columns = (np.flatnonzero(deep.any(axis=axis)) for axis in (1, 0))
    return (
        slice(max(int(rows[0]) - more, 0), int(rows[-1]) + more + 1),
        slice(max(int(columns[0]) - more, 0), int(columns[-1]) + more + 1),
    )


def _beyond_series(strain: GapStrain, thickness: float, box: tuple[slice, slice]) -> Floats:
    """What the charge is more than its third order, on a part of the mesh."""
    width = TAPER * thickness / strain.step
    values = strain.values[box]
    part = GapStrain(values * _window(values.shape, width), strain.origin, strain.step)
    spectrum, waves = _charge(part, thickness, 3)
    third = fft.irfft2(spectrum, waves.shape)
    gap = np.zeros(waves.shape)
    gap[: values.shape[0], : values.shape[1]] = part.values
    missing = charge_below(gap, strain.step / thickness) - third
    return np.asarray(missing[: values.shape[0], : values.shape[1]])


def _window(shape: tuple[int, ...], width: float) -> Floats:
    """1 inside, and smoothly down to 0 over so many samples at the border."""

    def along(count: int) -> Floats:
        index = np.arange(count)
        inside = np.clip(np.minimum(index, count - 1 - index) / width, 0.0, 1.0)
        return np.asarray(inside**3 * (10 - 15 * inside + 6 * inside**2))

    return along(shape[0])[:, None] * along(shape[1])
