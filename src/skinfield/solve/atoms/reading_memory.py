"""Memory of a patch's contact fit from reading to reading, and all that compiled functions take."""

from typing import NamedTuple

import numpy as np

from skinfield.compiled import inner
from skinfield.errors import Floats, Ints
from skinfield.solve.atoms.alternatives_kernel import SearchMemory
from skinfield.solve.atoms.atom_readings import PARAMETERS
from skinfield.solve.atoms.dictionary import FirstTemplates, Templates
from skinfield.solve.atoms.fit_kernel import FitMemory, FitModel, Priors
from skinfield.solve.atoms.posterior_kernel import PosteriorMemory
from skinfield.solve.atoms.rows_kernel import Drawing
from skinfield.solve.atoms.split_kernel import PairMemory
from skinfield.solve.atoms.strips_kernel import Strips
from skinfield.solve.atoms.table import Tables
from skinfield.solve.packed import PackedType, unpacking

ERRORS: Floats = 1e-3 * np.exp2(np.arange(9.0))  # of the model: parts of what is read
DRAWING = 12_000.0  # ns, at first: it takes about so long to draw an answer

# Stages of the comparison: atoms of a changed reading; more, by a better model; fewer; two in the
# place of one; none left.
SEEKING, REFINING, DROPPING, SPLITTING, RESTING = range(5)
# Places of `ReadingMemory.numbers`: times the stated noise; energy of the readings when they were
# compared; the model error in the middle and in the mean square, and that by which taxels are
# weighed; place of the press; evidence of the answer; offset; the highest score that was sought in
# vain; what drawing takes, ns; of the other set its scale, two model errors and evidence; the model
# error that is searched by; the noise when it last changed; the least worth of atoms when compared;
# energy of the reading before; the model error when sets of atoms were compared; the noise when
# numbers of atoms were compared; deviations of place, thicknesses, and of the force's logarithm, as
# the mechanics are not sure; these of a press that begins; where the first atom last was; the model
# error in the mean square when no comparison waited for time; and the step in which the board
# reads, in stated deviations, negative as long as it is a guess.
(
    SCALE,
    COMPARED,
    MISFIT,
    SPREAD,
    WEIGHED,
    PLACE_X,
    PLACE_Y,
    TOTAL,
    OFFSET,
    IN_VAIN,
    DRAWN,
    OTHER_SCALE,
    OTHER_MISFIT,
    OTHER_SPREAD,
    OTHER_TOTAL,
    SEARCHED_BY,
    MEAN_NOISE,
    LEAST_WORTH,
    BEFORE,
    COMPARED_SPREAD,
    SPLIT_NOISE,
    UNSURE_PLACE,
    UNSURE_FORCE,
    OPEN_PLACE,
    OPEN_FORCE,
    LAST_X,
    LAST_Y,
    RESTED_SPREAD,
    READ_STEP,
) = range(29)
# Places of `ReadingMemory.marks`: presses before; stage; the round of a search; the atom that is
# left out; whether a comparison was interrupted (2: its search begins anew), and whether what is
# open was; whether the answer explains the readings; how many atoms the other set has; whether
# readings are strong; how many atoms there were where only more of them are sought, or -1; whether
# a comparison may take its time, as the answer explains all; which of `DUTIES` comes
# first; whether none explained the readings when all sets of atoms had been compared; how many
# atoms the reading before had, of which fewer must be clearly better, or 0; how many steps all
# this may take in one reading, where no answer waits for it, or 0 for any; and whether a contact is
# about where the first one was in the reading before.
(
    PRESSES,
    STAGE,
    TURN,
    INDEX,
    HALFWAY,
    OPEN_HALFWAY,
    EXPLAINED,
    OTHERS,
    IS_STRONG,
    ONLY,
    GRADUAL,
    DUTY,
    HOPELESS,
    FORMER_COUNT,
    STEPS_AT_ONCE,
    GOES_ON,
) = range(16)
# What each reading ends with; by turns, while the time does not suffice for all.
ERROR_FIRST, COMPARISON_FIRST, OPEN_FIRST, DUTIES = range(4)
# Rows of `ReadingMemory.errors`: by this reading, the press before, all before it, and room.
HERE, LAST, LEARNT, ROOM = range(4)


class Neighbours(NamedTuple):
    """Taxels beside each, as a sparse matrix: those of taxel i from `first[i]` on.

    Attributes
    ----------
    first : (L + 1,) int array
    taxels : (N,) int array
    weights : (N,) array
    limits : (L + 1,) array
        Squares of as many normal numbers as the place that all but one in 1e4 stay below.
    """

    first: Ints
    taxels: Ints
    weights: Floats
    limits: Floats


class ReadingRules(NamedTuple):
    """What the fit of a reading goes by; see `ContactFit`.

    `threshold` is the gain in cost that a contact must bring, `thickness` the layer's, m.
    """

    threshold: float
    most: int
    starts: int
    warm: int
    model_error: float
    common_mode: float
    thickness: float


class ReadingMemory(NamedTuple):
    """What lasts from reading to reading beside the atoms.

    Attributes
    ----------
    numbers : (29,) array
    marks : (16,) int array
    errors : (4, 9) array
        Logarithms of the likelihood of each of `ERRORS`.
    noise, heard : (L,) arrays
        Stated deviations, and those without the taxels that are left out, which have infinite ones.
    squares : (2, L) array
        Of what taxels around the atoms read, and of what is read beside them.
    atoms : (M, 8) array
        Of another set, whose families are `family` (M,): the answer, while others are compared.
    """

    numbers: Floats
    marks: Ints
    errors: Floats
    noise: Floats
    heard: Floats
    squares: Floats
    atoms: Floats
    family: Ints

    @classmethod
    def of(cls, noise: Floats, most: int, model_error: float) -> "ReadingMemory":
        """Room for so many atoms."""
        numbers = np.zeros(READ_STEP + 1)
        numbers[DRAWN], numbers[MEAN_NOISE] = DRAWING, noise.mean()
        made = cls(
            numbers,
            np.zeros(16, np.int64),
            np.zeros((4, len(ERRORS))),
            noise.copy(),
            noise.copy(),
            np.zeros((2, len(noise))),
            np.zeros((most, PARAMETERS)),
            np.zeros(most, np.int64),
        )
        forget.py_func(made, model_error)  # type: ignore[attr-defined]
        return made


class Fit(NamedTuple):
    """All that a reading's fit needs, prepared and remembered."""

    model: FitModel
    bank: Templates
    near: Neighbours
    rules: ReadingRules
    memory: FitMemory
    search: SearchMemory
    post: PosteriorMemory
    own: ReadingMemory
    drawing: Drawing
    pairs: PairMemory
    strips: Strips


@inner(_nrt=False)
def forget(own: ReadingMemory, error: float) -> None:
    """Have the next reading be the first one, of a model with some error."""
    own.numbers[MISFIT] = own.numbers[SPREAD] = own.numbers[RESTED_SPREAD] = error
    own.numbers[SCALE], own.numbers[COMPARED] = 1.0, 0.0
    own.numbers[BEFORE] = own.numbers[READ_STEP] = 0.0
    own.numbers[PLACE_X] = own.numbers[PLACE_Y] = np.inf
    own.numbers[LAST_X] = own.numbers[LAST_Y] = np.inf
    own.numbers[UNSURE_PLACE] = own.numbers[UNSURE_FORCE] = 0.0
    for k in range(len(own.marks)):
        own.marks[k] = 0
    own.marks[STAGE], own.marks[EXPLAINED] = RESTING, 1
    for row in range(3):
        for k in range(own.errors.shape[1]):
            own.errors[row, k] = 0.0


def smallest_fit() -> Fit:
    """Of no size: what kinds of arrays it has."""
    tables = Tables(
        np.zeros((3, 1, 1, 1)),
        np.zeros((3, 1)),
        np.zeros(1),
        np.zeros((3, 1, 1)),
        *np.zeros(5).tolist(),
    )
    model = FitModel(np.zeros((1, 2)), tables, Priors(*np.zeros(8).tolist()), np.zeros((2, 2)))
    whole, single = np.zeros(1, np.int64), np.zeros((1, 1), np.float32)
    number = whole.astype(np.int32)
    first = FirstTemplates(single, number, number, number, whole)
    bank = Templates(
        whole[None], whole, first, single, np.zeros(1), np.zeros((1, PARAMETERS)), np.zeros(1)
    )
    return Fit(
        model,
        bank,
        Neighbours(whole, whole, np.zeros(1), np.zeros(1)),
        ReadingRules(0.0, 1, 1, 1, 0.0, 0.0, 1.0),
        FitMemory.of(model, 1),
        SearchMemory.of(bank, 1, 1, 1),
        PosteriorMemory.of(1),
        ReadingMemory.of(np.ones(1), 1, 0.0),
        Drawing.of(1),
        PairMemory.of(1, 1),
        Strips.of(np.zeros((1, 2)), 1.0),
    )


FIT = PackedType(smallest_fit())
unpack_fit = unpacking(FIT)
