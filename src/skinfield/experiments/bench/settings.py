"""How much is measured, and on which skin."""

from dataclasses import dataclass, field

from skinfield.errors import check_choice
from skinfield.experiments.settings import PAPER_LAYER
from skinfield.layout import Patch
from skinfield.layout.generators import hexagon72
from skinfield.mechanics import Layer
from skinfield.observation import BaseStress

MICROSECONDS = (10, 20, 30, 50, 70, 100, 200, 500)
MILLISECONDS = (1, 2, 5, 10, 20, 50)
LADDER = tuple(us * 1e-6 for us in MICROSECONDS) + tuple(ms * 1e-3 for ms in MILLISECONDS)  # s
GAPS = (1e-2, 1e-4)  # certified: how far above the minimum an objective may be
FIT_DEADLINES = (0.5e-3, 2e-3)  # s: beside none
SIZES = ("smoke", "short", "full")


@dataclass(frozen=True, kw_only=True)
class BenchSize:
    """How much is measured.

    Parameters
    ----------
    name : str
    grids : tuple of int
        Nodes on a side, where Figure 9 has 10 to 40.
    nodes : int
        On a side, of the any-time curves.
    deadlines : tuple of float, s
        Of the any-time curves.
    readings : int
        Of the moving press, that count; before them come some that do not.
    rounds : int
        In which all contenders take turns.
    paper_laps : int
        Of the paper's algorithm per grid, in all rounds together.
    laps : int
        Of a prepared operator per grid and round.
    steps : int
        Readings of the solvers per grid and round.
    cell : float, m
        Of the grid of the true press.
    """

    name: str
    grids: tuple[int, ...] = (10, 20, 30, 40)
    nodes: int = 40
    deadlines: tuple[float, ...] = LADDER
    readings: int
    rounds: int
    paper_laps: int
    laps: int
    steps: int
    cell: float = 0.25e-3


SMOKE = BenchSize(
    name="smoke",
    grids=(10, 20),
    nodes=20,
    deadlines=(30e-6, 1e-3),
    readings=6,
    rounds=1,
    paper_laps=2,
    laps=200,
    steps=6,
    cell=0.5e-3,
)
SHORT = BenchSize(name="short", readings=100, rounds=5, paper_laps=10, laps=600, steps=40)
FULL = BenchSize(name="full", readings=300, rounds=15, paper_laps=60, laps=1000, steps=100)


def bench_size(name: str) -> BenchSize:
    """Smoke (seconds), short (two to three minutes) or full.

    Raises
    ------
    InputError
        For another name.
    """
    check_choice("size", name, SIZES, "how much is measured")
    return {size.name: size for size in (SMOKE, SHORT, FULL)}[name]


@dataclass(frozen=True, kw_only=True)
class BenchSettings:
    """The skin that is timed, and how much of it.

    Parameters
    ----------
    size : BenchSize
    seed : int
        Of the noise and of the order in which contenders take turns.
    patch : Patch
        The paper's hexagon of 72 taxels.
    layer : Layer
    quantity : BaseStress
        What the taxels read: that is what the paper inverts.
    """

    size: BenchSize = SHORT
    seed: int = 0
    patch: Patch = field(default_factory=hexagon72)
    layer: Layer = PAPER_LAYER
    quantity: BaseStress = field(default_factory=BaseStress)

    @property
    def noise(self) -> float:
        """Standard deviation of one reading, in the quantity's unit."""
        return self.quantity.typical_noise
