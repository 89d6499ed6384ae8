"""Memory of a contact fit under one mechanics of the layer, and what it last found."""

import numpy as np

from skinfield.errors import Floats
from skinfield.solve.atoms.alternatives_kernel import SearchMemory
from skinfield.solve.atoms.dictionary import Templates
from skinfield.solve.atoms.fit_kernel import NOW, FitMemory, FitModel
from skinfield.solve.atoms.posterior_kernel import PosteriorMemory
from skinfield.solve.atoms.reading_memory import (
    EXPLAINED,
    FIT,
    MISFIT,
    OFFSET,
    TOTAL,
    Fit,
    Neighbours,
    ReadingMemory,
    ReadingRules,
    forget,
)
from skinfield.solve.atoms.rows_kernel import Drawing
from skinfield.solve.packed import Packed


class FitData:
    """Scratch memory of a contact fit, and what it remembers of the reading before.

    Parameters
    ----------
    model : FitModel
    bank : Templates
    near : Neighbours
    rules : ReadingRules
    noise : (L,) array, in the quantity's unit
        Deviation of one reading.

    Attributes
    ----------
    noise : (L,) array
        Deviation of what is solved next.
    drawing : Drawing
        The last answer, drawn.
    packed : Packed
        All of it.
    """

    def __init__(
        self,
        model: FitModel,
        bank: Templates,
        near: Neighbours,
        rules: ReadingRules,
        noise: Floats,
    ) -> None:
        most, self.drawing = rules.most, Drawing.of(rules.most)
        self.memory = FitMemory.of(model, most)
        self.posterior = PosteriorMemory.of(most)
        self.own = ReadingMemory.of(noise, most, rules.model_error)
        self.noise = self.own.noise
        self.search = SearchMemory.of(bank, most, rules.starts)
        known, room = (model, bank, near, rules), (self.memory, self.search, self.posterior)
        self.packed = Packed(Fit(*known, *room, self.own, self.drawing), FIT)
        self._error = rules.model_error

    @property
    def count(self) -> int:
        """Atoms of the answer."""
        return int(self.memory.counts[NOW])

    @property
    def misfit(self) -> float:
        """What the model is wrong by, part of what taxels read: the middle of what it may be."""
        return float(self.own.numbers[MISFIT])

    @property
    def total(self) -> float:
        """Logarithm of the marginal likelihood of the atoms, whatever the model error.

        Over the density of the stated noise at 0.
        """
        return float(self.own.numbers[TOTAL])

    @property
    def offset(self) -> float:
        """That all taxels are taken to share, in the quantity's unit."""
        return float(self.own.numbers[OFFSET])

    @property
    def explained(self) -> bool:
        """Whether noise and model error account for what is left over."""
        return bool(self.own.marks[EXPLAINED])

    def squares(self, left: Floats) -> float:
        """Of what is left over of readings (L,), over their noise."""
        return float(np.square(left / self.own.heard).sum())

    def use(self, model: FitModel) -> None:
        """Go by another model of the same taxels."""
        self.packed = Packed(self.packed.value._replace(model=model), FIT)

    def reset(self) -> None:
        """Forget the reading before."""
        self.memory.counts[:], self.posterior.known[:] = 0, 0
        forget.py_func(self.own, self._error)  # type: ignore[attr-defined]
