"""What every experiment shares: the skin, the noise, the seed, and how much is computed."""

from dataclasses import dataclass, field

from skinfield.errors import check_choice
from skinfield.mechanics import Layer

SIZES = ("smoke", "short", "full")
PAPER_LAYER = Layer(thickness=2e-3, young_modulus=100e3, poisson_ratio=0.5)


@dataclass(frozen=True, kw_only=True)
class Size:
    """How much is computed.

    Parameters
    ----------
    name : str
    quiet : int
        Readings of an idle patch that set thresholds.
    presses : int
        Noisy readings per indenter, place and load.
    cell : float, m
        Of the truth's grid.
    laps : int
        Of the paper's algorithm per grid, when it is timed.
    grids : tuple of int
        Nodes on a side, where the paper has 10 to 40.
    """

    name: str
    quiet: int
    presses: int
    cell: float
    laps: int
    grids: tuple[int, ...] = (10, 20, 30, 40)


SMOKE = Size(name="smoke", quiet=4000, presses=100, cell=0.4e-3, laps=4)
SHORT = Size(name="short", quiet=100_000, presses=1000, cell=0.2e-3, laps=30)
FULL = Size(name="full", quiet=400_000, presses=4000, cell=0.125e-3, laps=100)


def size_by_name(name: str) -> Size:
    """Smoke (under a minute), short (minutes) or full.

    Raises
    ------
    InputError
        For another name.
    """
    check_choice("size", name, SIZES, "how much is computed")
    return {size.name: size for size in (SMOKE, SHORT, FULL)}[name]


@dataclass(frozen=True, kw_only=True)
class Settings:
    """The skin, its noise, and how much is computed.

    Parameters
    ----------
    size : Size
    seed : int
        Of all random numbers.
    layer : Layer
        The paper's 2 mm of incompressible silicone; it states no modulus, 100 kPa is assumed.
    stress_noise : float, Pa
        Standard deviation of one reading where a taxel reads stress. 3.8 kPa is the noise at which
        the paper's own method misses 0.2 N and finds 0.5 N over a taxel, as the paper reports.
    change_noise : float
        The same where it reads ΔC/C₀.
    false_alarms : float
        Share of idle readings in which a contact may be seen.
    rate : float, 1/s
        Readings per second, where averages are told as times.
    data : str
        Folder of recordings by others; empty where there is none.
    """

    size: Size = field(default=SHORT)
    seed: int = 0
    layer: Layer = PAPER_LAYER
    stress_noise: float = 3.8e3
    change_noise: float = 0.02
    false_alarms: float = 1e-3
    rate: float = 50.0
    data: str = ""
