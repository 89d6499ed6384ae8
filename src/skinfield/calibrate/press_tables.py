"""Tables of presses for any thickness and Poisson's ratio, interpolated between nodes.

In thicknesses, readings depend on the pad's size and on Poisson's ratio alone, and smoothly: three
nodes in each are enough. A table is made when it is first needed, and kept on disk.
"""

import hashlib
from collections import OrderedDict
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from skinfield.compiled import cache_folder
from skinfield.elastic import BondedLayer, Layer, Physics, Quantity
from skinfield.errors import Floats
from skinfield.solve.atoms.table import BALL, Tables, tabulate

LOG_STEP = 0.25  # of ln thickness, from node to node
RATIOS = (0.1, 0.2, 0.3, 0.37, 0.42, 0.46, 0.485, 0.5)
LATEST = 8  # tables that are kept: slopes need those on four sides
BOUNDS = (0.2, 3.0)  # thicknesses: radii of contact


class PressTables:
    """What balls do to a layer of any thickness and Poisson's ratio.

    Parameters
    ----------
    layer : Layer
        Of the nominal thickness, about which the nodes stand.
    quantity : Quantity
    pad_diameter : float, m
    cover : bool
        Whether it lies under an inextensible cover.
    """

    def __init__(
        self, layer: Layer, quantity: Quantity, pad_diameter: float, cover: bool = False
    ) -> None:
        self._physics = Physics(layer, BondedLayer(cover), quantity, pad_diameter)
        self._known: dict[tuple[int, int], Tables] = {}
        self._at: OrderedDict[tuple[float, float, tuple[int, int]], Tables] = OrderedDict()
        self._middle = 0, 0

    def centre_on(self, log_thickness: float, ratio: float) -> bool:
        """Take the nodes around ln(thickness/m) and Poisson's ratio; whether these are others."""
        before = self._middle
        nearest = int(np.argmin(np.abs(np.array(RATIOS[1:-1]) - ratio))) + 1
        self._middle = round(self._place(log_thickness)), nearest
        return self._middle != before

    def _place(self, log_thickness: float) -> float:
        return float(log_thickness - np.log(self._physics.layer.thickness)) / LOG_STEP

    def at(self, log_thickness: float, ratio: float) -> Tables:
        """Table for ln(thickness/m) and Poisson's ratio, quadratic between the nodes taken."""
        key = float(log_thickness), float(ratio), self._middle
        if key not in self._at:
            self._at[key] = self._between(*key[:2])
            if len(self._at) > LATEST:
                self._at.popitem(last=False)
        return self._at[key]

    def _between(self, log_thickness: float, ratio: float) -> Tables:
        middle, nearest = self._middle
        steps = np.arange(middle - 1, middle + 2)
        ratios = range(nearest - 1, nearest + 2)
        along = lagrange(steps.astype(float), self._place(log_thickness))
        across = lagrange(np.array(RATIOS)[list(ratios)], ratio)
        each = [self._node(int(step), index) for step in steps for index in ratios]
        shares = np.outer(along, across).ravel()
        reach = min(table.coefficients.shape[3] for table in each)
        return each[0]._replace(
            pad_radius=self._physics.pad_diameter / 2 / float(np.exp(log_thickness)),
            coefficients=weighted(shares, [table.coefficients[:, :, :, :reach] for table in each]),
            strain=weighted(shares, [table.strain for table in each]),
            curvature=weighted(shares, [table.curvature for table in each]),
        )

    def _node(self, step: int, index: int) -> Tables:
        key = step, index
        if key not in self._known:
            base = self._physics.layer
            layer = replace(
                base,
                thickness=base.thickness * float(np.exp(LOG_STEP * step)),
                poisson_ratio=RATIOS[index],
            )
            self._known[key] = kept_table(replace(self._physics, layer=layer))
        return self._known[key]


def weighted(shares: Floats, arrays: list[Floats]) -> Floats:
    """Sum of arrays, each times its share."""
    total = np.zeros(arrays[0].shape)
    for share, array in zip(shares, arrays, strict=True):
        total += share * array
    return total


def lagrange(nodes: Floats, place: float) -> Floats:
    """Weights of values at nodes (N,), for the polynomial through them at a place."""
    others = ~np.eye(len(nodes), dtype=bool)
    return np.array(
        [
            np.prod((place - nodes[row]) / (node - nodes[row]))
            for node, row in zip(nodes, others, strict=True)
        ]
    )


def kept_table(physics: Physics) -> Tables:
    """Table of balls, from disk where it was made before."""
    folder = cache_folder(Path(__file__))
    file = folder / f"{hashlib.sha256(repr(physics).encode()).hexdigest()[:16]}.npz"
    with suppress(OSError, ValueError, KeyError, EOFError), np.load(file) as known:
        arrays = [known[name] for name in Tables._fields]
        return Tables.of(arrays)
    made = tabulate(physics, (BALL,), BOUNDS)
    with suppress(OSError):
        part = file.with_suffix(f".{id(made)}.npz")
        np.savez(part, **made._asdict())
        part.replace(file)  # at once: other processes see all of it, or none
    return made
