"""Whose intervals are tried, on what presses, and how many."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skinfield.errors import check_choice
from skinfield.experiments.paper.presses import paper_patch
from skinfield.experiments.settings import PAPER_LAYER, SIZES
from skinfield.inverse import ContactFit, GaussianField, Inverse, PseudoInverse, Solver, Tikhonov
from skinfield.layout import Patch
from skinfield.mechanics import Layer
from skinfield.pipeline.rehearsal import BODIES
from skinfield.simulate import Bar, Cone, Cylinder, Sphere

LEVELS = (0.5, 0.68, 0.9, 0.95)
OTHERS: tuple[Any, ...] = (  # none of those that intervals are learnt from
    Sphere(radius=4e-3),
    Sphere(radius=6.5e-3),
    Sphere(radius=10e-3),
    Cylinder(radius=3e-3, edge_radius=0.3e-3),
    Cone(radius=7e-3, half_angle=float(np.radians(70.0))),
    Bar(length=7e-3, width=4e-3, edge_radius=1e-3),
)
NEARLY_NONE = 0.05  # typical noises


@dataclass(frozen=True)
class Entry:
    """A solver under the name that it has in the table.

    Parameters
    ----------
    name : str
    solver : Solver
    linear : bool
        Whether its contacts state a model error that is left out where intervals are learnt; else
        they state the same either way, and are found once.
    """

    name: str
    solver: Solver
    linear: bool = True


SOLVERS = (
    Entry("PseudoInverse, resampled (paper)", PseudoInverse(resample=True)),
    Entry("Inverse, resampled (paper)", Inverse()),
    Entry("Tikhonov", Tikhonov()),
    Entry("GaussianField", GaussianField()),
    Entry("ContactFit", ContactFit(), linear=False),
)


@dataclass(frozen=True, kw_only=True)
class CoveragePlan:
    """One table.

    Parameters
    ----------
    solvers : tuple of Entry
    quantities : tuple of str
        Of "stress" and "capacitance".
    noises : tuple of float
        Of the quantity's typical noise.
    presses : int
        From which intervals are learnt.
    trials : int
        Presses by other bodies and with other seeds, on which they are tried.
    known, others : tuple of indenters
        Bodies of the former and of the latter.
    nodes : int
        On a side of the estimate's grid.
    layer : Layer
    seed : int
    """

    solvers: tuple[Entry, ...] = SOLVERS
    quantities: tuple[str, ...] = ("stress", "capacitance")
    noises: tuple[float, ...] = (NEARLY_NONE, 1.0, 2.5)
    presses: int = 300
    trials: int = 250
    known: tuple[Any, ...] = BODIES
    others: tuple[Any, ...] = OTHERS
    nodes: int = 30
    layer: Layer = PAPER_LAYER
    seed: int = 0

    @property
    def patch(self) -> Patch:
        """The hexagon of 72 taxels."""
        return paper_patch()


def coverage_plan(size: str, seed: int = 0) -> CoveragePlan:
    """The table of a size: "smoke", "short" or "full".

    Raises
    ------
    InputError
        For another size.
    """
    check_choice("size", size, SIZES, "how much is computed")
    if size == "smoke":
        return CoveragePlan(
            solvers=SOLVERS[3:4],
            quantities=("stress",),
            noises=(1.0,),
            presses=100,
            trials=30,
            known=BODIES[1:2],
            others=OTHERS[1:2],
            nodes=20,
            seed=seed,
        )
    if size == "short":
        return CoveragePlan(presses=150, trials=150, seed=seed)
    return CoveragePlan(presses=1000, trials=1500, seed=seed)
