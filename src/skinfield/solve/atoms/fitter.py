"""Contact fit of a patch: what is prepared, its memory, and the answer of one reading."""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, InputError, Ints, check_type
from skinfield.estimate.row_contacts import moved_rows
from skinfield.plot import plural
from skinfield.settings import Positive, Range, Section
from skinfield.skin import Grid
from skinfield.solve.atoms.dictionary import MARGIN, Templates, make_templates
from skinfield.solve.atoms.fit_data import FitData
from skinfield.solve.atoms.fit_kernel import MOST, NOW, SHEAR_STD, STEPS, FitModel, Priors
from skinfield.solve.atoms.mechanics_choice import MechanicsChoice, OtherMechanics
from skinfield.solve.atoms.misfit_kernel import AROUND, LOUD
from skinfield.solve.atoms.reading_memory import (
    GRADUAL,
    MEAN_NOISE,
    MISFIT,
    PRESSES,
    RESTING,
    SCALE,
    STAGE,
    Neighbours,
    ReadingRules,
)
from skinfield.solve.atoms.render import AtomRenderer
from skinfield.solve.atoms.table import atom_tables
from skinfield.solve.packed import Packed

ODD = 1e-4  # readings that contacts explain, and that are taken not to be explained
STRIPS_NOTE = (
    "ContactFit: the skin reads too unlike its model to tell how many bodies touch: each strip of "
    "its readings is one contact; calibrate"
)
STOPPED = "ContactFit stopped"  # begins a note of one reading alone
HIGHEST = 0.99  # probability that a note states at most
MANY, UNLIKE = 10, 0.02  # presses, of which a model error as large is worth a note


@dataclass(frozen=True, kw_only=True)
class FitSettings(Section):
    """What `ContactFit` goes by; its parameters are listed there."""

    most_contacts: Annotated[int, Range(1, 64, "atoms that are sought")] = 8
    false_alarm_rate: Annotated[float, Range(1e-12, 0.5, "a share of readings")] = 1e-3
    typical_radius: Annotated[float, Positive("of what touches, in metres")] = 6e-3
    model_error: Annotated[float, Range(0.0, 0.5, "part of the highest reading")] = 0.02
    starts: Annotated[int, Range(1, 64, "places from which each is sought")] = 8
    warm: bool = True
    common_mode: Annotated[float, Range(0.0, 1e6, "in standard deviations of the noise")] = 5.0
    check_mechanics: bool = True

    def check(self) -> None:
        """See `Section`."""
        check_type("check_mechanics", self.check_mechanics, bool, "whether others are compared")
        check_type("warm", self.warm, bool, "whether to start from the reading before")


@dataclass(frozen=True, eq=False)
class AtomFit:
    """What a contact fit makes of one reading; the displacement is drawn when it is asked for.

    Attributes
    ----------
    renderer : AtomRenderer
    grid : Grid
        On which the contacts stand.
    rows : (N,) array of CONTACT
        By falling force.
    atoms : (M, 8) array
        As they are drawn; see `rows_kernel.Drawing`.
    family : (M,) int array
    predicted : (L,) array, in the quantity's unit
        What the taxels would read of them, with an offset that all share.
    parameters : int
        Numbers that were fitted.
    """

    renderer: AtomRenderer
    grid: Grid
    rows: NDArray[np.void]
    atoms: Floats
    family: Ints
    predicted: Floats
    parameters: int

    def keep(self) -> "AtomFit":
        """Itself: nothing overwrites it."""
        return self

    def on(self, grid: Grid, shift: Floats) -> "AtomFit":
        """The same on a patch of equal geometry, whose plane is shifted by (2,) m."""
        return replace(self, grid=grid, rows=moved_rows(self.rows, grid, shift))

    @property
    def displacement(self) -> Floats:
        """Of the nodes in the patch's frame, (K, 3) m."""
        return self.renderer.displacement(self.atoms, self.family)


def significant(false_alarm_rate: float, taxels: int) -> float:
    """Gain in cost that noise exceeds at this rate: three parameters at as many places as taxels.

    Half the quantile of chi-squared with three degrees of freedom (Wilks 1938).
    """
    from scipy.special import chdtri

    return 0.5 * float(chdtri(3, false_alarm_rate / taxels))


CURVATURE_STD = 0.8  # of the logarithm of a ball's radius of curvature, before any reading
FLAT_RADIUS, FLAT_STD = 3e-3, 0.7  # m: middle of the prior of a flat end, and of its logarithm
RING_RADIUS, RING_STD = 4e-3, 0.5  # m, and of its logarithm
LENGTH_STD = 4e-3  # m: of each component of the half-length of a line
FIRST = (6.0, 8.0, 60.0)  # standard deviations: touches by which all is loaded, faint and clear


class ContactFitter:
    """Finds contacts reading by reading: prepared once, for all grids of a patch.

    Parameters
    ----------
    settings : FitSettings
        Such as `ContactFit()`.
    model : ObservationModel
        With its physics.
    """

    def __init__(self, settings: FitSettings, model: ObservationModel) -> None:
        if model.physics is None:
            raise InputError(
                "the model does not say what it is made of, expected physics: make it with "
                "ObservationModel.of()"
            )
        physics = model.physics.flat
        self.settings, self.model = settings, model
        self.thickness = thickness = physics.layer.thickness
        tables = atom_tables(physics)
        taxels = np.ascontiguousarray(model.taxels / thickness)
        priors = Priors(
            float(np.log(settings.typical_radius)),
            CURVATURE_STD,
            float(np.log(FLAT_RADIUS / thickness)),
            FLAT_STD,
            float(np.log(RING_RADIUS / thickness)),
            RING_STD,
            LENGTH_STD / thickness,
            SHEAR_STD,
        )
        low, high = taxels.min(axis=0) - MARGIN, taxels.max(axis=0) + MARGIN
        self.noise = np.array(model.noise_std, dtype=np.float64)
        self.fit_model = FitModel(taxels, tables, priors, np.array([low, high]))
        self.bank: Templates = make_templates(self.fit_model, 1.0 / model.noise_std)
        self.threshold = significant(settings.false_alarm_rate, len(model.taxels))
        self.near = neighbours_of(taxels)
        self.rules = ReadingRules(
            self.threshold,
            settings.most_contacts,
            settings.starts,
            int(settings.warm),
            settings.model_error,
            settings.common_mode,
            thickness,
        )
        compares = settings.check_mechanics and settings.warm
        self.mechanics = OtherMechanics(self.fit_model, physics if compares else None)
        self._all = np.ones(len(taxels), np.bool_)
        from skinfield.solve.idle_kernel import reading_rests

        self._rests = reading_rests

    def data(self) -> MechanicsChoice:
        """Make scratch memory."""
        known = self.bank, self.near, self.rules, self.noise
        return MechanicsChoice(self.mechanics, *known, self.thickness)

    def touches(self) -> list[Floats]:
        """Readings (L,) of touches by which all that is compiled is run."""
        bank = self.bank
        strongest = int(np.argmax(bank.norms))
        block = int(np.searchsorted(bank.firsts, strongest, side="right")) - 1
        template = np.zeros(len(self.model.taxels))
        np.add.at(template, bank.taxels[block], bank.templates[strongest])
        return [template * (strength * self.model.noise_std) for strength in FIRST]

    def fit(
        self,
        readings: Floats,
        choice: MechanicsChoice,
        renderer: AtomRenderer,
        out: tuple[Floats, NDArray[np.void]],
        valid: NDArray[np.bool_] | None = None,
        deadline_ns: int | None = None,
    ) -> int:
        """Find the contacts of readings (L,), 0 where not `valid` (L,); how many there are.

        Writes the pressure (K,) and rows of `CONTACT` into `out`.
        """
        heard, end = self._all if valid is None else valid, deadline_ns or 0
        return choice.answer(renderer.rows.address, *out, readings, heard, end)

    def rests(
        self,
        readings: Floats,
        data: FitData,
        wide: Packed,
        valid: NDArray[np.bool_] | None = None,
    ) -> bool:
        """See `idle_kernel.rests`."""
        heard = self._all if valid is None else valid
        return bool(self._rests(data.packed.address, wide.address, readings, heard))

    def answer_of(self, data: FitData, renderer: AtomRenderer, rows: NDArray[np.void]) -> AtomFit:
        """The last answer with its rows, drawn by a renderer."""
        drawing = data.drawing
        drawn = int(drawing.drawn[0])
        return AtomFit(
            renderer=renderer,
            grid=renderer.grid,
            rows=np.ndarray(rows.shape, rows.dtype, bytearray(rows.tobytes())),  # quick
            atoms=drawing.atoms[:drawn].copy(),
            family=drawing.family[:drawn].copy(),
            predicted=data.memory.predicted[NOW] + data.offset,
            parameters=data.parameters,
        )

    def notes(self, choice: MechanicsChoice) -> tuple[str, ...]:
        """What is to be told of the last answer, in sentences."""
        data, other = choice.fit, self.mechanics.clauses[choice.acting]
        own, marks, count = data.own, data.memory.marks, data.count
        numbers, presses, offset = own.numbers, int(own.marks[PRESSES]), abs(data.offset)
        late = own.marks[STAGE] != RESTING and not own.marks[GRADUAL]  # else it may take its time
        loud = numbers[SCALE] > LOUD
        unlike = presses >= MANY and numbers[MISFIT] > UNLIKE
        shared = offset > self.settings.common_mode * numbers[MEAN_NOISE]
        in_strips = data.in_strips
        if not (late or loud or shared or unlike or other or in_strips):
            return ()
        notes = []
        if in_strips:
            notes.append(STRIPS_NOTE)
        if late:
            steps, most = marks[STEPS], marks[MOST]
            end = f"after {steps} steps" if steps >= most > 0 else "at the deadline"
            notes.append(f"{STOPPED} {end}, with {count} found")
        if loud:
            notes.append("ContactFit saw more noise than was stated, and went by what it saw")
        if shared:
            notes.append("ContactFit took what all taxels share for an offset: tare the skin")
        if other:
            sure, over = choice.probability, plural(choice.compared, "press", "presses")
            share = "above 0.99" if sure > HIGHEST else f"{sure:.2f}"
            notes.append(
                f"ContactFit: this skin reads unlike its model, as if {other} (probability {share} "
                f"over {over}), by which it is answered: see skinfield calibrate layer"
            )
        elif unlike:
            notes.append(
                f"ContactFit: this skin reads unlike its model, by {100 * data.misfit:.0f} % press "
                "after press: thickness, Poisson's ratio, cover or gains differ: see skinfield "
                "calibrate layer"
            )
        return tuple(notes)


def neighbours_of(places: Floats) -> Neighbours:
    """What model errors reach, for taxels at places (L, 2), in thicknesses."""
    from scipy.spatial import cKDTree
    from scipy.special import chdtri

    tree = cKDTree(places)
    near = tree.sparse_distance_matrix(tree, 2.0 * AROUND, output_type="coo_matrix").tocsr()
    apart = np.asarray(near.data, np.float64)
    weights = np.where(apart > 0.0, np.exp(-np.square(apart / AROUND)), 0.0)
    limits = np.asarray(chdtri(np.arange(len(places) + 1), ODD), np.float64)
    first, taxels = near.indptr.astype(np.int64), near.indices.astype(np.int64)
    return Neighbours(first, taxels, weights, limits)
