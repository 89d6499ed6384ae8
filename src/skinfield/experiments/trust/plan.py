"""What is tried on unseen presses: solvers, quantities, noises, and how much of it."""

from collections.abc import Callable
from dataclasses import dataclass

import skinfield.inverse as inverse
from skinfield.errors import InputError, check_choice, check_positive
from skinfield.experiments.cases.standard import SILICONE
from skinfield.experiments.cases.unseen import CELL
from skinfield.experiments.scoring.matching import GATE
from skinfield.experiments.scoring.validation import Entrant
from skinfield.experiments.settings import SIZES
from skinfield.inverse import GaussianField, PseudoInverse, Solver
from skinfield.layout import Patch
from skinfield.layout.generators import by_name
from skinfield.mechanics import HalfSpace, Layer, Mechanics

# Of readings without noise a solver is still told one, the truth's own error: about 1e-3 of the
# stress below a light press, and of the capacitance that the field in the gap is known to.
FLOORS = {"stress": 10.0, "capacitance": 1e-4, "gap": 1e-4}
NOISES = {  # standard deviations of one reading, Pa and ΔC/C₀; 0 is exact
    "stress": (0.0, 380.0, 1e3, 3.8e3),
    "capacitance": (0.0, 0.002, 0.005, 0.02),
}
PAPER, GAUSSIAN, CONTACT = "paper", "gaussian", "contact"


@dataclass(frozen=True)
class Level:
    """A noise of one quantity, in its unit; 0 for exact readings."""

    quantity: str
    noise: float

    def __post_init__(self) -> None:
        check_choice("quantity", self.quantity, FLOORS, "what taxels read")
        if not 0.0 <= self.noise < float("inf"):
            raise InputError(f"noise is {self.noise!r}, expected 0 for exact readings, or more")

    @property
    def told(self) -> float:
        """What a solver is told: never less than the floor of `FLOORS`."""
        return max(self.noise, FLOORS[self.quantity])

    def __str__(self) -> str:
        return f"{self.quantity} {self.noise:g}"


@dataclass(frozen=True)
class Method:
    """A solver with what it assumes, under the name that it has in tables.

    Parameters
    ----------
    name : str
    solver : Solver
    mechanics : Mechanics, optional
        Default what the skin is.
    nodes : int
        On a side of its grid.
    """

    name: str
    solver: Solver
    mechanics: Mechanics | None = None
    nodes: int = 40

    def entrant(self, gate: float = GATE) -> Entrant:
        """Ready for any case; contacts farther apart than `gate` in m do not belong together."""
        return Entrant(solver=self.solver, mechanics=self.mechanics, nodes=self.nodes, gate=gate)


def methods(nodes: int = 40) -> tuple[Method, ...]:
    """The paper's on its 20 x 20 nodes, the Gaussian field, and the fit of contacts on `nodes`."""
    found = [
        Method(PAPER, PseudoInverse(resample=True), HalfSpace(), 20),
        Method(GAUSSIAN, GaussianField(), nodes=nodes),
    ]
    make: Callable[[], Solver] | None = getattr(inverse, "ContactFit", None)
    return (*found, Method(CONTACT, make(), nodes=nodes)) if make is not None else tuple(found)


@dataclass(frozen=True, kw_only=True)
class TrustPlan:
    """A campaign of unseen presses.

    Parameters
    ----------
    methods : tuple of Method
    levels : tuple of Level
    gate : float, m
        Farther apart, a contact found is not the true one.
    layout : str
        Of a generator, see `skinfield.layout.generators`.
    layer : Layer
    presses : int
    share : int
        Presses in one part of the work.
    idle : int
        Readings of the skin at rest per level.
    distances : tuple of float, m
        Between two balls of 6 mm with 1 N each.
    pairs : tuple of Level
        At which the two are to be told apart.
    trials : int
        Per distance.
    bound_grid : (radii, depths)
        Of the balls that the bound is interpolated between; none where it is (0, 0).
    cell : float, m
        Of the truth's grid.
    seed : int
    resamples : int
        Of the bootstrap.
    """

    methods: tuple[Method, ...]
    levels: tuple[Level, ...]
    gate: float = GATE
    layout: str = "icub_hexagon"
    layer: Layer = SILICONE
    presses: int = 200
    share: int = 10
    idle: int = 5000
    distances: tuple[float, ...] = ()
    pairs: tuple[Level, ...] = ()
    trials: int = 60
    bound_grid: tuple[int, int] = (6, 7)
    cell: float = CELL
    seed: int = 0
    resamples: int = 999

    def __post_init__(self) -> None:
        for name in ("presses", "share", "trials", "idle"):
            check_positive(name, getattr(self, name), "how many")
        check_positive("gate", self.gate, "distance of contacts that are the same, in metres")
        if not self.methods or not self.levels:
            raise InputError("methods or levels are empty, expected at least one of each")

    @property
    def patch(self) -> Patch:
        """The skin's layout."""
        return by_name(self.layout)

    @property
    def quantities(self) -> tuple[str, ...]:
        """What taxels read, each once."""
        return tuple(dict.fromkeys(level.quantity for level in self.levels))


LEVELS = tuple(Level(quantity, noise) for quantity, each in NOISES.items() for noise in each)
PAIRS = (Level("stress", 400.0), Level("stress", 40.0), Level("capacitance", 0.002))
DISTANCES = tuple(1e-3 * distance for distance in range(5, 17))


def trust_plan(size: str, seed: int = 0) -> TrustPlan:
    """The campaign of a size: "smoke", "short" or "full".

    Raises
    ------
    InputError
        For another size.
    """
    check_choice("size", size, SIZES, "how much is computed")
    if size == "smoke":
        return TrustPlan(
            methods=methods(nodes=20),
            levels=(Level("stress", 380.0),),
            presses=3,
            idle=200,
            distances=(7e-3, 14e-3),
            pairs=(Level("stress", 380.0),),
            trials=10,
            bound_grid=(3, 3),
            cell=0.5e-3,
            seed=seed,
            resamples=199,
        )
    if size == "short":
        return TrustPlan(
            methods=methods(),
            levels=LEVELS,
            presses=40,
            idle=2000,
            distances=DISTANCES[1::2],
            pairs=PAIRS,
            bound_grid=(6, 7),
            seed=seed,
        )
    return TrustPlan(
        methods=methods(), levels=LEVELS, distances=DISTANCES, pairs=PAIRS, trials=200, seed=seed
    )
