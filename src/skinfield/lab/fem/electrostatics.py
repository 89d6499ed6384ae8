"""Laplace's equation between the pads and the deformed ground plane above them.

Pad and guard lie in one plane at one potential, so below a round indentation the field is round,
wherever the pad is: what a pad off the axis carries is an integral over the same charge density.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, InputError, as_floats, check_finite, check_positive
from skinfield.lab.fem.mesh import Trace, graded, scikit_fem, towards

BEYOND = 6.0  # thicknesses; there the field is that of the plates


def pad_capacitance(
    thickness: float,
    indentation: Callable[[Floats], Floats],
    distance: ArrayLike,
    pad_diameter: float,
    *,
    reach: float | None = None,
    edges: Sequence[float] = (),
    finest: float = 0.02,
) -> Floats:
    """Relative change of capacitance of guarded pads below a round indentation.

    Parameters
    ----------
    thickness : float, m
        Of the gap where nothing presses.
    indentation : callable
        Depths (N,) m at radii (N,) m, as `AxisymmetricSolution.indentation`.
    distance : (N,) array, m
        Of the pads' centres from the axis.
    pad_diameter : float, m
    reach : float, m
        Radius within which the surface bends; default 12 thicknesses.
    edges : sequence of float, m
        Radii at which it bends sharply.
    finest : float
        Length of the elements there, in thicknesses.

    Returns
    -------
    (N,) array
        ΔC/C₀, positive where the gap is narrower.

    Raises
    ------
    InputError
        If the indentation reaches the pads, or scikit-fem is missing.
    """
    check_positive("thickness", thickness, "of the gap, in metres")
    check_positive("pad_diameter", pad_diameter, "of the electrode, in metres")
    at = np.atleast_1d(as_floats("distance", distance))
    check_finite("distance", at, "of the pads from the axis, in metres")
    far = 12.0 if reach is None else reach / thickness
    outer = max(far, float(np.abs(at).max() + pad_diameter) / thickness) + BEYOND
    bends = sorted(edge / thickness for edge in edges if 0 < edge / thickness < far)
    near = towards(bends or [0.0], finest if bends else 0.07, 0.3, 0.07)
    radii = graded([0.0, *bends, outer], lambda r: near(r) + 0.1 * np.maximum(r - 4.0, 0.0))
    depths = graded([0.0, 1.0], towards([0.0], finest * 2, 0.4, 0.15))
    charge = _charge(radii, 1.0 - depths[::-1], lambda r: indentation(r * thickness) / thickness)
    return disc_mean(lambda r: charge(r / thickness), np.abs(at), pad_diameter)


def _charge(
    radii: Floats, heights: Floats, indentation: Callable[[Floats], Floats]
) -> Callable[[Floats], Floats]:
    """Charge density on the base, relative to that of the plates, less one."""
    from scipy.sparse.linalg import splu

    fem = scikit_fem()
    basis = fem.Basis(fem.MeshQuad.init_tensor(radii, heights), fem.ElementQuad2(), intorder=6)
    r, z = basis.doflocs
    gap = 1.0 - np.asarray(indentation(r), dtype=float)
    if not gap.min() > 0:
        raise InputError(
            f"indentation reaches {1 - gap.min():.2f} of the thickness, expected below 1: the "
            "ground plane would touch the pads"
        )

    @fem.BilinearForm
    def laplace(u, v, w):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
        gap, slope = w["gap"], w.x[1] * w["gap"].grad[0] / w["gap"]
        along = (u.grad[0] - slope * u.grad[1]) * (v.grad[0] - slope * v.grad[1])
        return (along + u.grad[1] * v.grad[1] / gap**2) * gap * 2 * np.pi * w.x[0]

    stiffness = laplace.assemble(basis, gap=gap).tocsc()
    potential = 1.0 - z  # that of the plates, and right on both electrodes
    inside = np.flatnonzero((z > 0) & (z < heights[-1]))
    rest = -(stiffness @ potential)[inside]
    potential[inside] += splu(stiffness[inside][:, inside]).solve(rest)
    base = np.flatnonzero(z == 0)
    base = base[np.argsort(r[base])]
    trace = Trace(r[base])
    density = trace.density((stiffness @ potential)[base]) - 1.0
    return lambda radius: trace.at(density, radius)


def disc_mean(function: Callable[[Floats], Floats], distance: Floats, diameter: float) -> Floats:
    """Mean of a function of the radius over discs whose centres are at distances (N,) m."""
    points, weights = np.polynomial.legendre.leggauss(24)
    radius = diameter / 4 * (points + 1)
    angle = (np.arange(48) + 0.5) * np.pi / 48
    weight = (weights * radius)[:, None] * np.ones(48)
    along = distance[:, None, None] + radius[:, None] * np.cos(angle)
    across = radius[:, None] * np.sin(angle)
    values = function(np.hypot(along, across))
    return np.asarray((values * weight).sum(axis=(1, 2)) / weight.sum())
