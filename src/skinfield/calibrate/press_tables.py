"""Tables of balls on a layer of any thickness and Poisson's ratio, between Chebyshev nodes.

In thicknesses, readings depend on the pad's size and on Poisson's ratio alone. They are analytic in
both, so polynomials through Chebyshev nodes converge fast (Trefethen 2019, Approximation Theory and
Approximation Practice, chapter 8); near 0.5, where a thin layer turns from compressible to
incompressible within a few hundredths, those of the logarithm of 1 - 2ν and a bit.
"""

from dataclasses import replace

import numpy as np

from skinfield.elastic import BondedLayer, Layer, Physics, Quantity
from skinfield.errors import Floats
from skinfield.solve.atoms.table import BALL, Tables, tabulate

RADII = (0.2, 4.0)  # of contacts, in thicknesses
RATIOS = (0.2, 0.5)  # Poisson's
RATIO_NODES = 6
WIDE, NARROW = (0.6, 5), (0.15, 3)  # of ln thickness: half the range, and nodes
BIT = 0.1


class PressTables:
    """Tables of balls about one thickness.

    Parameters
    ----------
    layer : Layer
        Of the thickness in the middle.
    quantity : Quantity
    pad_diameter : float, m
    cover : bool
        Whether an inextensible cover lies on it.
    half_range : float
        Of ln thickness, that the tables are good for.
    nodes : int
        In it.
    """

    def __init__(
        self,
        layer: Layer,
        quantity: Quantity,
        pad_diameter: float,
        cover: bool,
        half_range: float = WIDE[0],
        nodes: int = WIDE[1],
    ) -> None:
        self.layer, self.cover, self.pad_radius = layer, cover, pad_diameter / 2.0
        middle = float(np.log(layer.thickness))
        self.range = middle - half_range, middle + half_range
        self._logs = chebyshev(*self.range, nodes)
        self._bends = chebyshev(_bend(RATIOS[1]), _bend(RATIOS[0]), RATIO_NODES)
        mechanics = BondedLayer(cover)
        each = []
        for log in self._logs:
            for ratio in 0.5 * (1.0 + BIT - np.exp(self._bends)):
                skin = replace(layer, thickness=float(np.exp(log)), poisson_ratio=float(ratio))
                physics = Physics(skin, mechanics, quantity, pad_diameter)
                each.append(tabulate(physics, (BALL,), RADII))
        reach = min(table.coefficients.shape[3] for table in each)
        self._first = each[0]
        self._values = np.array([table.coefficients[..., :reach] for table in each])
        self._strains = np.array([table.strain for table in each])

    def at(self, log_thickness: float, ratio: float) -> Tables:
        """Table for ln(thickness/m) and Poisson's ratio."""
        along = lagrange(self._logs, log_thickness)
        share = np.outer(along, lagrange(self._bends, _bend(ratio))).ravel()
        return self._first._replace(
            coefficients=np.tensordot(share, self._values, 1),
            strain=np.tensordot(share, self._strains, 1),
            pad_radius=self.pad_radius / float(np.exp(log_thickness)),
        )


def _bend(ratio: float) -> float:
    return float(np.log(1.0 + BIT - 2.0 * ratio))


def chebyshev(low: float, high: float, count: int) -> Floats:
    """Chebyshev nodes (N,) of an interval."""
    place = np.cos(np.pi * (np.arange(count) + 0.5) / count)
    return np.asarray((low + high) / 2.0 + (high - low) / 2.0 * place)


def lagrange(nodes: Floats, place: float) -> Floats:
    """Weights of values at nodes (N,), for the polynomial through them at a place."""
    others = ~np.eye(len(nodes), dtype=bool)
    return np.array(
        [
            np.prod((place - nodes[row]) / (node - nodes[row]))
            for node, row in zip(nodes, others, strict=True)
        ]
    )
