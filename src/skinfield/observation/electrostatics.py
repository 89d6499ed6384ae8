r"""Capacitance of guarded pads under a deformed ground plane, to third order in its deflection.

With v = w/h the strain of the gap and multipliers of its Fourier transform

.. math:: S = \frac{kh}{\sinh kh}, \qquad \mathcal D = kh \coth kh,

the change of the charge on the lower plane is, relative to the plate's own charge,

.. math:: S\left[v + v\,\mathcal D v + v\,\mathcal D (v\,\mathcal D v)
          - \tfrac12 v^2 (kh)^2 v + \dots\right],

which is v + v² + v³ for a uniform gap, as 1/(1 - v) - 1 demands.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.layout import Grid
from skinfield.mechanics import Layer, Mechanics, indentation_kernel
from skinfield.mechanics.radial import RadialKernel, electrostatic, jinc

STEPS = 10  # samples of the surface per thickness
MARGIN = 4.0  # thicknesses of surface around pads and grid: S falls as exp(-pi r/h)
REACH = 9.0  # thicknesses beyond which S is below 1e-11


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


def gap_strain(
    mechanics: Mechanics, layer: Layer, grid: Grid, pressure: Floats, around: Floats
) -> GapStrain:
    """Indentation under a pressure (K,) Pa on the cells of a grid, finely sampled.

    The mesh covers the grid and the points `around` (N, 2) m of the plane, with a margin.
    """
    from scipy.signal import fftconvolve

    h = layer.thickness
    split = max(int(np.ceil(grid.pitch / (h / STEPS))), 1)
    step = grid.pitch / split
    rows, columns = (n * split for n in grid.shape)
    dense = np.zeros((rows, columns))  # cells carry one impulse at their centre
    dense[::split, ::split] = pressure.reshape(grid.shape)
    far = np.concatenate([grid.plane[[0, -1]], around])
    before = np.ceil((grid.origin - far.min(axis=0) + MARGIN * h) / step).astype(int)
    beyond = far.max(axis=0) - grid.plane[-1] + MARGIN * h + grid.pitch
    after = np.ceil(beyond / step).astype(int)
    half_columns = columns + int(max(before[0], after[0]))
    half_rows = rows + int(max(before[1], after[1]))
    kernel = indentation_kernel(mechanics, layer, grid.pitch, step, half_rows, half_columns)
    full = fftconvolve(dense, kernel, mode="full")
    top, left = half_rows - before[1], half_columns - before[0]
    window = full[top : half_rows + rows + after[1], left : half_columns + columns + after[0]]
    return GapStrain(window / h, grid.origin - before * step, step)


def capacitance_change(
    strain: GapStrain, thickness: float, taxels: Floats, pad_diameter: float, order: int = 3
) -> Floats:
    """Relative change of capacitance (L,) of pads at (L, 2) m of the plane.

    Parameters
    ----------
    strain : GapStrain
    thickness, pad_diameter : float, m
    order : 1, 2 or 3
        Of the series in the strain.
    """
    charge = charge_series(strain, thickness, order)
    reach = REACH * thickness + pad_diameter / 2
    kernel = _pad_kernel(round(pad_diameter / 2 / thickness, 12))
    rows, columns = charge.shape
    x = strain.origin[0] + np.arange(columns) * strain.step
    y = strain.origin[1] + np.arange(rows) * strain.step
    out = np.empty(len(taxels))
    for index, (px, py) in enumerate(taxels):
        near_x, near_y = np.abs(x - px) <= reach, np.abs(y - py) <= reach
        rho = np.hypot(x[near_x] - px, (y[near_y] - py)[:, None]) / thickness
        out[index] = np.sum(kernel(rho) * charge[np.ix_(near_y, near_x)])
    return out * (strain.step / thickness) ** 2


def charge_series(strain: GapStrain, thickness: float, order: int) -> Floats:
    """The series in square brackets above, on the mesh of the strain."""
    from scipy import fft

    v = strain.values
    shape = [
        fft.next_fast_len(n + int(REACH * thickness / strain.step), real=True) for n in v.shape
    ]
    ky = 2 * np.pi * fft.fftfreq(shape[0], strain.step)[:, None] * thickness
    kx = 2 * np.pi * fft.rfftfreq(shape[1], strain.step) * thickness
    kh = np.hypot(kx, ky)
    coth = np.where(kh < 1e-6, 1.0, kh / np.tanh(np.maximum(kh, 1e-6)))

    def multiply(field: Floats, multiplier: Floats) -> Floats:
        spectrum = fft.rfft2(field, shape) * multiplier
        return np.asarray(fft.irfft2(spectrum, shape)[: v.shape[0], : v.shape[1]])

    total = v.copy()
    if order >= 2:
        second = v * multiply(v, coth)
        total += second
    if order >= 3:
        total += v * multiply(second, coth) - v**2 * multiply(v, kh**2) / 2
    return total


@lru_cache(maxsize=16)
def _pad_kernel(radius: float) -> RadialKernel:
    """S averaged over a pad, as a kernel per area in squared thicknesses."""
    return RadialKernel(
        lambda alpha: alpha * electrostatic(alpha) * jinc(alpha, radius) / (2 * np.pi),
        order=0,
        cutoff=46.0,
        reach=REACH + radius,
        width=radius,
    )
