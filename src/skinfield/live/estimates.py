"""Estimates of patches from what a slot holds of them."""

from functools import lru_cache
from typing import Any

import numpy as np

from skinfield.contacts import ContactFinder
from skinfield.engine import Engine
from skinfield.engine.state import Answer
from skinfield.errors import Floats
from skinfield.fields import Estimate
from skinfield.layout import Grid
from skinfield.live.recipe import Recipe
from skinfield.live.slots import Slot
from skinfield.pipeline.ladder_estimate import Rest, linear_beliefs, searched_beliefs

FEASIBLE = int(Answer.FEASIBLE)


class Models:
    """What follows from a pressure (deformation, uncertainty), prepared when it is first needed.

    Parameters
    ----------
    recipe : Recipe
    noise_std : (L,) array
        In the quantity's unit.
    """

    def __init__(self, recipe: Recipe, noise_std: Floats) -> None:
        self.recipe, self.noise_std = recipe, noise_std
        self.finder = ContactFinder()
        self._engine: Engine | None = None
        self._grid = lru_cache(4096)(self._new_grid)
        sizes = [len(patch) for patch in recipe.skin]
        self.starts = np.concatenate([[0], np.cumsum(sizes)]).tolist()

    @property
    def engine(self) -> Engine:
        """An engine like the one that answers; takes seconds to prepare."""
        if self._engine is None:
            self._engine = self.recipe.engine(self.noise_std)
        return self._engine

    @property
    def prepared(self) -> bool:
        """Whether deformation and uncertainty cost no preparation any more."""
        return self._engine is not None

    def moved(self, patch: int, nodes: int, pressure: Floats) -> Floats:
        """Displacement of a patch's nodes under a pressure (K,) Pa, (K, 3) m."""
        grid = self.grid(patch, nodes)
        return np.asarray(self._rung(patch, nodes).deformation.on(grid)(pressure))

    def grid(self, patch: int, nodes: int) -> Grid:
        """Grid of a patch with so many nodes a side."""
        return self._grid(patch, nodes)

    def _new_grid(self, patch: int, nodes: int) -> Grid:
        return Grid.square(self.recipe.skin[patch], nodes)

    def estimate(self, slot: Slot, patch: int, latency: float, late: bool) -> Estimate:
        """Estimate of a patch: pressure at once, the rest when it is asked for."""
        row, recipe = slot.patches[patch], self.recipe
        nodes = int(row["rung"]) or recipe.rungs[0]
        grid, answer = self.grid(patch, nodes), int(row["answer"])
        pressure = np.zeros(len(grid))
        if answer >= int(Answer.LINEAR):
            pressure[:] = slot.pressure[patch, : len(grid)]
        taxels = slice(self.starts[patch], self.starts[patch + 1])
        values = slot.values[taxels].astype(np.float64)
        linear = np.array(recipe.quantity.linearise(values, np.empty_like(values)))
        return Rest(
            grid=grid,
            pressure=pressure,
            readings=linear,
            valid=slot.valid[taxels].astype(np.bool_),
            predicted=lambda: self._predicted(patch, nodes, answer, pressure, linear),
            moved=lambda: self._rung(patch, nodes).deformation.on(grid)(pressure),
            beliefs=lambda: self._beliefs(patch, nodes, answer),
            finder=self.finder,
        ).estimate(
            latency=latency,
            stamp_ns=int(row["stamp_ns"]),
            gap=float(row["gap"]),
            iterations=int(row["iterations"]),
            deadline_met=not late,
        )

    def _group(self, patch: int) -> Any:
        engine = self.engine
        name = self.recipe.skin[patch].name
        return next(
            group for group in engine.groups if name in [p.name for p in group.kind.patches]
        )

    def _rung(self, patch: int, nodes: int) -> Any:
        return self._group(patch).rungs.steps[self.recipe.rungs.index(nodes)]

    def _beliefs(self, patch: int, nodes: int, answer: int) -> Any:
        step = self._rung(patch, nodes)
        searched = answer == FEASIBLE and step.operator is not None
        return searched_beliefs(step) if searched else linear_beliefs(step)

    def _predicted(
        self, patch: int, nodes: int, answer: int, pressure: Floats, linear: Floats
    ) -> Floats:
        step = self._rung(patch, nodes)
        if step.model is None:
            return np.asarray(self._group(patch).rungs.explained @ linear)
        return np.asarray(step.model.matrix @ pressure)
