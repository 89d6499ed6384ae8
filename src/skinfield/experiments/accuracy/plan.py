"""What the accuracy table compares, at what noise, and how much of it is computed."""

from dataclasses import dataclass
from functools import lru_cache

from skinfield.errors import InputError, check_choice
from skinfield.experiments.paper.presses import BALL, LOADS, PLACES, TIPS, Tip, paper_patch
from skinfield.experiments.settings import PAPER_LAYER, SIZES
from skinfield.inverse import GaussianField, Inverse, PseudoInverse, Solver, Tikhonov
from skinfield.mechanics import BondedLayer, HalfSpace, Layer, Mechanics
from skinfield.pipeline.conditioned import ICUB_GAIN

ANYWHERE = "anywhere"
QUANTITIES = ("stress", "gap", "capacitance")


@dataclass(frozen=True)
class Contender:
    """A solver under the name that it has in the table."""

    name: str
    solver: Solver


@dataclass(frozen=True)
class Model:
    """A model of the elastomer that solvers assume."""

    name: str
    mechanics: Mechanics


SOLVERS = (
    Contender("inverse (paper)", Inverse()),
    Contender("pseudo-inverse", PseudoInverse()),
    Contender("Tikhonov", Tikhonov()),
    Contender("Gaussian field", GaussianField()),
)
MODELS = (Model("half-space", HalfSpace()), Model("layer", BondedLayer()))


@dataclass(frozen=True, kw_only=True)
class AccuracyPlan:
    """One table: every combination of what is listed.

    Parameters
    ----------
    solvers : tuple of Contender
    models : tuple of Model
        What the solvers take the elastomer to be; the truth is always the bonded layer.
    quantities : tuple of str
        Of "stress", "gap" and "capacitance".
    tips : tuple of Tip
        The paper's four. It gives centimetres without saying of what; diameters are assumed.
    loads : tuple of float, N
    places : tuple of str
        Of "over a taxel", "between two", "between three" and "anywhere", at random among all such
        places that are 20 mm at most from the patch's middle.
    noise_counts : tuple of float
        Standard deviation of one reading in counts of the iCub's byte, at its default gain of 171
        counts per unit of ΔC/C₀.
    poses : int
        Presses per indenter, load and place, each with a noise of its own.
    nodes : int
        On a side of the estimate's grid.
    cell : float, m
        Of the truth's.
    layer : Layer
    seed : int
    resamples : int
        Of the bootstrap.
    """

    solvers: tuple[Contender, ...] = SOLVERS
    models: tuple[Model, ...] = MODELS
    quantities: tuple[str, ...] = QUANTITIES
    tips: tuple[Tip, ...] = TIPS
    loads: tuple[float, ...] = LOADS
    places: tuple[str, ...] = (*PLACES, ANYWHERE)
    noise_counts: tuple[float, ...] = (0.1, 1.0, 3.5)
    poses: int = 24
    nodes: int = 20
    cell: float = 0.25e-3
    layer: Layer = PAPER_LAYER
    seed: int = 0
    resamples: int = 499

    def __post_init__(self) -> None:
        for place in self.places:
            check_choice("places", place, (*PLACES, ANYWHERE), "where it is pressed")
        for quantity in self.quantities:
            check_choice("quantities", quantity, QUANTITIES, "what taxels read")
        if self.poses < 2:
            raise InputError(f"poses is {self.poses}, expected 2 or more: one has no interval")
        if not self.noise_counts or not all(0 < counts < 1e6 for counts in self.noise_counts):
            raise InputError(f"noise_counts is {self.noise_counts}, expected counts above 0")


SMOKE = AccuracyPlan(
    solvers=(SOLVERS[0], SOLVERS[3]),
    quantities=("stress", "capacitance"),
    tips=(BALL,),
    loads=(0.5, 3.0),
    places=(ANYWHERE,),
    noise_counts=(1.0,),
    poses=10,
    cell=0.4e-3,
    resamples=199,
)
SHORT = AccuracyPlan()
FULL = AccuracyPlan(poses=200, noise_counts=(0.1, 0.35, 1.0, 3.5), nodes=30, resamples=999)


def accuracy_plan(size: str) -> AccuracyPlan:
    """The table of a size: "smoke", "short" or "full".

    Raises
    ------
    InputError
        For another size.
    """
    check_choice("size", size, SIZES, "how much is computed")
    return {"smoke": SMOKE, "short": SHORT, "full": FULL}[size]


@lru_cache(maxsize=16)
def noise_per_count(layer: Layer, cell: float) -> dict[str, float]:
    """Noise of each quantity, in its unit, that is worth one count of the iCub's byte.

    For the capacitance 1/171 in ΔC/C₀; for stress and gap, what is the same part of the reading of
    a taxel right below the half-sphere of 1.2 cm at 1 N.
    """
    solved = BALL.pressed(layer, 1.0, cell)
    if solved is None:
        raise InputError(f"{BALL.name} sinks through {layer}, expected a stiffer or thicker layer")
    pad = paper_patch().pad_diameter
    below = {
        quantity: float(solved.readings([[0.0, 0.0]], pad, quantity)[0]) for quantity in QUANTITIES
    }
    per_count = 1.0 / abs(ICUB_GAIN)
    return {name: per_count * value / below["capacitance"] for name, value in below.items()}
