"""Tensile tests of an elastomer: its curve, its modulus at zero strain, tables on disk."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, InputError, as_floats, check_finite, check_positive

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator
import math
from pathlib import Path

from skinfield.errors import FileError


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


_STRAIN = "Engineering Strain"
_STRESS = "Engineering Stress (MPa)"


@dataclass(frozen=True, eq=False)
class TensileTest:
    """One pull of one specimen.

    Attributes
    ----------
    strain : (N,) array
        Engineering, positive in tension.
    stress : (N,) array, Pa
        Engineering, positive in tension.
    material : str
    parameters : dict
        Everything that the head of the file says, as text.
    """

    strain: Floats
    stress: Floats
    material: str
    parameters: dict[str, str]


def load_tensile_test(path: Path | str) -> TensileTest:
    """Read a table with semicolons: a head of ``parameter;value``, then titled columns.

    Columns are found by their titles, ``Engineering Strain`` and ``Engineering Stress (MPa)``.

    Raises
    ------
    FileError
        If the file cannot be read, lacks a column, or has a row that is not numbers; with its line.
    """
    path = Path(path)
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise FileError(f"{path} is not text in UTF-8: {error}") from error
    rows = [[cell.strip() for cell in line.split(";")] for line in lines]
    titles = next((i for i, row in enumerate(rows) if _STRAIN in row and _STRESS in row), None)
    if titles is None:
        raise FileError(
            f"{path} has no line with the titles {_STRAIN!r} and {_STRESS!r} between semicolons: "
            "this is not a tensile test of the materials database"
        )
    columns = rows[titles].index(_STRAIN), rows[titles].index(_STRESS)
    values = [
        [_number(path, number, row, column) for column in columns]
        for number, row in enumerate(rows[titles + 1 :], start=titles + 2)
        if any(row)
    ]
    if len(values) < 2:
        raise FileError(f"{path} has {len(values)} rows below its titles, expected at least 2")
    table = np.array(values)
    head = {row[0]: row[1] for row in rows[:titles] if len(row) > 1 and row[0]}
    return TensileTest(
        strain=table[:, 0],
        stress=table[:, 1] * 1e6,
        material=head.get("Material", path.stem),
        parameters=head,
    )


def _number(path: Path, line: int, row: list[str], column: int) -> float:
    text = row[column] if column < len(row) else ""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise FileError(
            f"{path}:{line} has {text[:40]!r} in column {column + 1}, expected a finite number: "
            "is the file cut short?"
        )
    return value
