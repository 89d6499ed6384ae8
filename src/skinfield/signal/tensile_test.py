"""Tensile tests of an elastomer: its modulus at zero strain, and tables on disk."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import FileError, Floats, InputError, as_floats, check_positive


@dataclass(frozen=True)
class ModulusFit:
    """Young's modulus at zero strain, fitted to the start of a test.

    Attributes
    ----------
    modulus, std : float, Pa
        With its standard error from the scatter of the points.
    offset : float, Pa
        Stress of the fit at zero strain: slack or zero error of the machine.
    points : int
    """

    modulus: float
    std: float
    offset: float
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
    from scipy.stats import linregress

    strain, stress = as_floats("strain", strain), as_floats("stress", stress)
    used = (np.abs(strain) <= up_to) & (strain > -1.0) & np.isfinite(stress)
    if len(np.unique(strain[used])) < 4:
        raise InputError(
            f"{int(used.sum())} points have a strain up to {up_to!r}, expected at least 4 strains: "
            "raise up_to, or give a finer test"
        )
    x, y = strain[used], stress[used]
    fit = linregress(((1.0 + x) - (1.0 + x) ** -2) / 3.0, y)
    slope = float(fit.slope)
    check_positive("the fitted modulus", slope, "stress must rise with strain, in tension")
    return ModulusFit(slope, float(fit.stderr), float(fit.intercept), len(x))


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
