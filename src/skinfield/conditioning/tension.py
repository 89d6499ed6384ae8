"""What a tensile test says about an elastomer: its curve, and its modulus at zero strain."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from skinfield.conditioning.curves import TableCurve
from skinfield.errors import InputError, as_floats, check_finite, check_positive


def curve_from_tension(
    strain: ArrayLike, stress: ArrayLike, *, compression_to: float = 0.1
) -> TableCurve:
    """Curve from a tensile test, mirrored into small compression.

    Parameters
    ----------
    strain : (N,) array
        Engineering strain, positive in tension.
    stress : (N,) array, Pa
        Engineering stress, positive in tension.
    compression_to : float
        Compressive strain up to which stress(-ε) = -stress(ε) is taken to hold.

    Notes
    -----
    Antisymmetry is a small-strain statement. An incompressible neo-Hookean rubber,
    σ = E/3 (λ - λ⁻²), is stiffer in compression than in tension by 2ε: at 10 % strain the mirrored
    curve gives 82 % of the true compressive stress. Noise that makes a measured curve fall is
    taken out by isotonic regression; the curve starts at the unstrained, unstressed point.

    Raises
    ------
    InputError
        If fewer than 2 points rise above zero, or the test does not reach `compression_to`.
    """
    from scipy.optimize import isotonic_regression

    strain, stress = as_floats("strain", strain), as_floats("stress", stress)
    if strain.ndim != 1 or strain.shape != stress.shape:
        raise InputError(
            f"strain has shape {strain.shape} and stress {stress.shape}, "
            "expected the same (points,)"
        )
    check_finite("strain", strain, "a test has a number at every point")
    check_finite("stress", stress, "a test has a number at every point")
    order = np.argsort(strain, kind="stable")
    order = order[(strain[order] > 0) & (stress[order] > 0)]
    if len(order) < 2:
        raise InputError(
            f"stress rises above zero at {len(order)} points, expected at least 2: "
            "tension is positive here"
        )
    rising = np.asarray(isotonic_regression(stress[order]).x)
    level, block = np.unique(rising, return_inverse=True)
    mean_strain = np.bincount(block, weights=strain[order]) / np.bincount(block)
    check_positive("compression_to", compression_to, "a small strain, 0.1 at most is sound")
    if compression_to > mean_strain[-1]:
        raise InputError(
            f"compression_to is {compression_to!r}, expected at most {mean_strain[-1]:g}, where "
            "the test ends"
        )
    tension = TableCurve(np.append(0.0, mean_strain), np.append(0.0, level))
    mirrored = mean_strain[mean_strain < compression_to]
    pressed = np.append(mirrored, compression_to)
    return TableCurve(
        strain=np.concatenate([-mean_strain[::-1], [0.0], pressed]),
        stress=np.concatenate([-level[::-1], [0.0], tension.stress_from_strain(pressed)]),
    )


@dataclass(frozen=True)
class ModulusFit:
    """Young's modulus at zero strain, fitted to the start of a test.

    Attributes
    ----------
    modulus, std : float, Pa
        With its standard error from the scatter of the points.
    offset : float, Pa
        Stress of the fit at zero strain: slack or zero error of the machine.
    strain_range : tuple of float
        Of the points used.
    residual : float, Pa
        Root mean square of what the fit leaves.
    points : int
    """

    modulus: float
    std: float
    offset: float
    strain_range: tuple[float, float]
    residual: float
    points: int


def initial_modulus(strain: ArrayLike, stress: ArrayLike, *, up_to: float = 0.5) -> ModulusFit:
    """Fit σ = offset + E/3 (λ - λ⁻²), λ = 1 + ε, to points of strain up to `up_to`.

    The incompressible neo-Hookean law has the slope E at zero strain, and lets points of moderate
    strain speak for it where a straight line would need strains below 5 %.

    Parameters
    ----------
    strain : (N,) array
        Engineering strain, positive in tension.
    stress : (N,) array, Pa
        Engineering stress, positive in tension.
    up_to : float

    Raises
    ------
    InputError
        If fewer than 4 points lie in the range, or the fitted modulus is not above zero.
    """
    strain, stress = as_floats("strain", strain), as_floats("stress", stress)
    used = (np.abs(strain) <= up_to) & (strain > -1.0) & np.isfinite(stress)
    if used.sum() < 4:
        raise InputError(
            f"{int(used.sum())} points have a strain up to {up_to!r}, expected at least 4: "
            "raise up_to, or give a finer test"
        )
    x, y = strain[used], stress[used]
    shape = ((1.0 + x) - (1.0 + x) ** -2) / 3.0
    centred = shape - shape.mean()
    power = float(centred @ centred)
    slope = float(centred @ y) / power if power > 0 else 0.0
    check_positive("the fitted modulus", slope, "stress must rise with strain, in tension")
    left = y - y.mean() - slope * centred
    scatter = float(left @ left) / (len(x) - 2)
    return ModulusFit(
        modulus=slope,
        std=float(np.sqrt(scatter / power)),
        offset=float(y.mean() - slope * shape.mean()),
        strain_range=(float(x.min()), float(x.max())),
        residual=float(np.sqrt(np.mean(left**2))),
        points=len(x),
    )
