"""Characterisation curves of an elastomer: stress from strain and strain from stress."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, InputError, as_floats, check_finite, check_positive

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator


class StressCurve(Protocol):
    """Stress, Pa, against strain of one elastomer, both positive in compression.

    The strain is that of a specimen free to bulge. A thin layer bonded to a robot is not free:
    where the gap strain varies over a few thicknesses, the observation model relates gap and
    stress, and a curve read point by point does not.
    """

    def stress_from_strain(self, strain: ArrayLike) -> Floats:
        """Engineering stress, Pa."""
        ...

    def strain_from_stress(self, stress: ArrayLike) -> Floats:
        """Engineering strain."""
        ...


@dataclass(frozen=True)
class LinearCurve:
    """Hooke's law: stress = modulus · strain.

    Parameters
    ----------
    modulus : float, Pa
    """

    modulus: float

    def __post_init__(self) -> None:
        check_positive("modulus", self.modulus, "Young's modulus in Pa, 50 kPa is 50e3")

    def stress_from_strain(self, strain: ArrayLike) -> Floats:
        """Engineering stress, Pa; NaN stays NaN."""
        return self.modulus * as_floats("strain", strain)

    def strain_from_stress(self, stress: ArrayLike) -> Floats:
        """Engineering strain; NaN stays NaN."""
        return as_floats("stress", stress) / self.modulus


@dataclass(frozen=True, eq=False)
class TableCurve:
    """A measured curve, interpolated monotonically (PCHIP); never extrapolated.

    Parameters
    ----------
    strain : (N,) array
        Strictly increasing, positive in compression.
    stress : (N,) array, Pa
        Strictly increasing, positive in compression.
    """

    strain: Floats
    stress: Floats

    def __post_init__(self) -> None:
        for name in ("strain", "stress"):
            column = np.array(as_floats(name, getattr(self, name)))
            if column.ndim != 1 or len(column) < 2:
                raise InputError(f"{name} has shape {column.shape}, expected (points,), 2 at least")
            check_finite(name, column, "a curve has a number at every point")
            falls = np.flatnonzero(np.diff(column) <= 0)
            if len(falls):
                at = int(falls[0]) + 1
                raise InputError(
                    f"{name}[{at}] is {column[at]:g} after {column[at - 1]:g}, expected strictly "
                    "increasing values: smooth measured data first, as curve_from_tension does"
                )
            column.setflags(write=False)
            object.__setattr__(self, name, column)
        if len(self.strain) != len(self.stress):
            raise InputError(
                f"stress has {len(self.stress)} values, expected {len(self.strain)} as strain has"
            )

    def stress_from_strain(self, strain: ArrayLike) -> Floats:
        """Engineering stress, Pa; NaN stays NaN.

        Raises
        ------
        InputError
            If a strain lies beyond the table.
        """
        strain = _within("strain", strain, self.strain)
        # rounding must not lift an end of the curve out of its own range
        return np.clip(self._interpolator()(strain), self.stress[0], self.stress[-1])

    def strain_from_stress(self, stress: ArrayLike) -> Floats:
        """Engineering strain: the exact inverse of the interpolation, by bisection.

        Raises
        ------
        InputError
            If a stress lies beyond the table.
        """
        stress = _within("stress", stress, self.stress)
        forward = self._interpolator()
        piece = np.clip(np.searchsorted(self.stress, stress) - 1, 0, len(self.stress) - 2)
        low, high = self.strain[piece], self.strain[piece + 1]
        for _ in range(54):  # bits of a double
            middle = (low + high) / 2.0
            below = forward(middle) < stress
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        return np.asarray(np.where(np.isnan(stress), np.nan, (low + high) / 2.0))

    def _interpolator(self) -> "PchipInterpolator":
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.strain, self.stress)


def _within(name: str, values: ArrayLike, table: Floats) -> Floats:
    array = as_floats(name, values)
    bad = np.argwhere((array < table[0]) | (array > table[-1]))
    if len(bad):
        where = tuple(int(i) for i in bad[0])
        raise InputError(
            f"{name}{list(where) if where else ''} is {array[where]:g}, expected "
            f"{table[0]:g} to {table[-1]:g} as the curve was measured "
            f"({len(bad)} of {array.size} are beyond): a curve is not extrapolated"
        )
    return array
