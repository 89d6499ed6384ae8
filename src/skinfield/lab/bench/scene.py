"""Benchmark scene: how much is measured, on which skin, and two fingers that move over it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skinfield.elastic import BaseStress
from skinfield.errors import Floats
from skinfield.lab.paper import LAYER, paper_patch
from skinfield.simulate import Sphere, press

MICROSECONDS = (10, 20, 30, 50, 70, 100, 200, 500)
MILLISECONDS = (1, 2, 5, 10, 20, 50)
LADDER = tuple(us * 1e-6 for us in MICROSECONDS) + tuple(ms * 1e-3 for ms in MILLISECONDS)  # s
GAPS = (1e-2, 1e-4)  # certified: how far above the minimum an objective may be
FIT_DEADLINES = (0.5e-3, 2e-3)  # s: beside none


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
    name="smoke", grids=(10, 20), nodes=20, deadlines=(30e-6, 1e-3), readings=6, rounds=1,
    paper_laps=2, laps=200, steps=6, cell=1e-3,
)  # fmt: skip
SHORT = BenchSize(name="short", readings=100, rounds=5, paper_laps=10, laps=600, steps=40)
FULL = BenchSize(name="full", readings=300, rounds=15, paper_laps=60, laps=1000, steps=100)
SIZES = {size.name: size for size in (SMOKE, SHORT, FULL)}  # seconds, minutes, half an hour


NOISE = BaseStress().typical_noise  # Pa: taxels read what the paper inverts
LEAD = 8  # readings before those that count, so that a warm chain is warm
RATE = 50.0  # readings per second, as of the iCub's skin
RADIUS = 6e-3  # m, of the fingers' tips
EXTENT = 50e-3  # m: side of the square in which they touch
MIDDLES = np.array([[-10.5e-3, 0.0], [10.5e-3, 0.0]])  # m: the balls never meet
SWAY = np.array([4e-3, 9e-3])  # m, across and along
# 1/s, of x, y and force of each: no two alike, so that no pose comes twice
PACES = np.array([[0.41, 0.67, 0.9], [0.53, 0.59, 1.3]])
PHASES = np.array([[0.0, 0.4, 0.0], [1.3, 1.1, 2.0]])
FORCES = (0.3, 2.0)  # N, the least and the most of each


@dataclass(frozen=True, eq=False)
class BenchScene:
    """T readings of two fingers, after LEAD further ones.

    Attributes
    ----------
    readings : (LEAD + T, L) array, in the quantity's unit
        With noise.
    exact : (LEAD + T, L) array
        Without.
    places : (LEAD + T, 2, 2) array, m
        Of the fingers on the patch's plane.
    forces : (LEAD + T, 2) array, N
    """

    readings: Floats
    exact: Floats
    places: Floats
    forces: Floats

    def __len__(self) -> int:
        return len(self.readings) - LEAD

    def part(self, turn: int, steps: int) -> Floats:
        """Readings (LEAD + steps, L) for a round: one after another, and from the start again."""
        first = max(turn, 0) * steps % max(len(self) - steps + 1, 1)
        return self.readings[first : first + LEAD + steps]


def paths(count: int) -> tuple[Floats, Floats]:
    """Places (count, 2, 2) m and forces (count, 2) N of two fingers, reading by reading."""
    turn = 2 * np.pi * np.arange(count)[:, None, None] / RATE * PACES + PHASES
    swing = np.sin(turn)
    low, high = FORCES
    force = 0.5 * (low + high) + 0.5 * (high - low) * swing[:, :, 2]
    return MIDDLES + SWAY * swing[:, :, :2], force


def make_scene(
    size: BenchSize, seed: int = 0, show: Callable[[int, int], None] = lambda done, of: None
) -> BenchScene:
    """Press a ball for each finger and reading, on a grid of its own, and read the paper's patch.

    Parameters
    ----------
    size : BenchSize
    seed : int
        Of the noise.
    show : function of (done, of)
        Called before each press.
    """
    patch, total = paper_patch(), LEAD + size.readings
    places, forces = paths(total)
    exact = np.empty((total, len(patch)))
    for index in range(total):
        show(index, total)
        balls = [
            Sphere(radius=RADIUS, force=float(force), position=(float(x), float(y)))
            for force, (x, y) in zip(forces[index], places[index], strict=True)
        ]
        solved = press(LAYER, balls, EXTENT, size.cell)
        exact[index] = solved.readings(patch.plane, patch.pad_diameter, "stress")
    noisy = exact + np.random.default_rng(seed).normal(scale=NOISE, size=exact.shape)
    return BenchScene(noisy, exact, places, forces)
