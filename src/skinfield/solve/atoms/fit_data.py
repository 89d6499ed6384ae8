"""Memory of a contact fit under one mechanics of the layer, and what it last found."""

import numpy as np

from skinfield.errors import Floats
from skinfield.solve.atoms.alternatives_kernel import SearchMemory
from skinfield.solve.atoms.dictionary import Templates
from skinfield.solve.atoms.fit_kernel import MOST, NOW, STEPS, FitMemory, FitModel
from skinfield.solve.atoms.posterior_kernel import PosteriorMemory
from skinfield.solve.atoms.reading_kernel import infer_evidence
from skinfield.solve.atoms.reading_memory import (
    EXPLAINED,
    FIT,
    GRADUAL,
    MISFIT,
    OFFSET,
    RESTING,
    STAGE,
    TOTAL,
    Fit,
    Neighbours,
    ReadingMemory,
    ReadingRules,
    forget,
)
from skinfield.solve.atoms.rows_kernel import Drawing
from skinfield.solve.atoms.split_kernel import PairMemory
from skinfield.solve.atoms.strips_kernel import Strips
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
        self.search = SearchMemory.of(bank, most, rules.starts, len(noise))
        known, room = (model, bank, near, rules), (self.memory, self.search, self.posterior)
        pairs = PairMemory.of(len(noise), most)
        self.strips = strips = Strips.of(model.taxels, rules.thickness)
        self.packed = Packed(Fit(*known, *room, self.own, self.drawing, pairs, strips), FIT)
        self._error = rules.model_error

    @property
    def count(self) -> int:
        """Atoms of the answer."""
        return int(self.memory.counts[NOW])

    @property
    def parameters(self) -> int:
        """Numbers that were fitted."""
        atoms = self.memory.atoms[NOW, : self.count]
        more = np.count_nonzero(atoms[:, 4:6].any(axis=1)) + np.count_nonzero(
            atoms[:, 6:].any(axis=1)
        )
        return 4 * self.count + 2 * int(more)

    @property
    def misfit(self) -> float:
        """What the model is wrong by, part of what taxels read: the middle of what it may be."""
        return float(self.own.numbers[MISFIT])

    @property
    def total(self) -> float:
        """Logarithm of the marginal likelihood of the atoms, whatever the model error.

        Over the density of the stated noise at 0.
        """
        return float(self.own.numbers[TOTAL]) if self.compared else self.infer()

    def infer(self) -> float:
        """Infer the model error of the last reading, and `total`, by the atoms that there are."""
        infer_evidence(self.packed.address)
        return float(self.own.numbers[TOTAL])

    @property
    def offset(self) -> float:
        """That all taxels are taken to share, in the quantity's unit."""
        return float(self.own.numbers[OFFSET])

    @property
    def explained(self) -> bool:
        """Whether noise and model error account for what is left over."""
        return bool(self.own.marks[EXPLAINED])

    @property
    def compared(self) -> bool:
        """Whether all sets of atoms were compared, or as many as there may be steps for."""
        steps, most = self.memory.marks[STEPS], self.memory.marks[MOST]
        return bool(self.own.marks[STAGE] == RESTING or steps >= most > 0)

    @property
    def settled(self) -> bool:
        """Whether more time for the same reading would come to nothing, or to little."""
        return self.compared or bool(self.own.marks[GRADUAL])

    @property
    def in_strips(self) -> bool:
        """Whether the model is far off, and fingers' strips say which atoms are one contact."""
        return bool(self.strips.counts[0] > 0)

    @property
    def touched(self) -> int:
        """Taxels that strips were drawn between."""
        return int(self.strips.counts[1])

    def use(self, model: FitModel) -> None:
        """Go by another model of the same taxels, from now on."""
        self.packed.put("model", model)

    def reset(self) -> None:
        """Forget the reading before."""
        self.memory.counts[:], self.posterior.known[:] = 0, 0
        forget.py_func(self.own, self._error)  # type: ignore[attr-defined]
