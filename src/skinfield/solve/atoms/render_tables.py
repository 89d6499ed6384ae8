r"""Tables over the radius of round contacts: what they look like on the surface.

With t² = 1 - r²/a², the pressure of 1 N is

.. math:: p = \frac{1}{\pi a^2} \sum_{j=0}^{J-1} c_j\, t^{2j \pm 1},

plus for a ball, minus for a flat end; J = 1 are Hertz and Boussinesq, and more terms the exact
solution on a layer.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from skinfield.elastic import Layer, Mechanics
from skinfield.errors import Floats
from skinfield.solve.atoms.table import BALL, FLAT, log_radii, splines, unit_pressure

LOG_STEP = 0.2  # of ln(a/h)
SMALLEST, LARGEST = 0.15, 8.0  # radii in thicknesses that are rendered as they are
LOGS = log_radii(SMALLEST, LARGEST, LOG_STEP)  # nodes of ln(a/h)
TERMS = 8  # of the pressure


class PressureTable(NamedTuple):
    """Cubic B-splines over ln(a/h), the nodes `LOG_STEP` apart.

    Attributes
    ----------
    pressure : (2, radii, TERMS) array
        The coefficients c of balls and of flat ends.
    first_log : float
        ln(a/h) of the first node.
    thickness : float, m
    """

    pressure: Floats
    first_log: float
    thickness: float


@lru_cache(maxsize=8)
def pressure_table(layer: Layer, mechanics: Mechanics) -> PressureTable:
    """Tabulate, once for each layer."""
    radii = layer.thickness * np.exp(LOGS)
    terms = [
        [_pressure_terms(layer, mechanics, family, a) for a in radii] for family in (BALL, FLAT)
    ]
    return PressureTable(splines(np.array(terms), (1,)), float(LOGS[0]), layer.thickness)


def _pressure_terms(layer: Layer, mechanics: Mechanics, family: int, a: float) -> Floats:
    """Coefficients c (TERMS,) that add up to 1 N."""
    t = 0.5 - 0.5 * np.cos((np.arange(4 * TERMS) + 0.5) * np.pi / (4 * TERMS))
    weight = t if family == FLAT else np.ones_like(t)  # bounded: the edge of a flat end is not
    each = unit_pressure(layer, mechanics, family, a, a * np.sqrt(1.0 - t**2)) * (np.pi * a**2)
    power = 2.0 * np.arange(TERMS) + (1.0 if family == BALL else -1.0)  # of t
    terms = np.linalg.lstsq(t[:, None] ** power * weight[:, None], each * weight, rcond=None)[0]
    return np.asarray(terms / (terms @ (2.0 / (power + 2.0))))
