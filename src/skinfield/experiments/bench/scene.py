"""Two fingers that move over the skin: readings, and the truth of each."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.bench.settings import BenchSettings
from skinfield.simulate import Sphere, press

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
class Scene:
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
    settings: BenchSettings, show: Callable[[int, int], None] = lambda done, of: None
) -> Scene:
    """Press a ball for each finger and reading, on a grid of its own, and read the taxels.

    Parameters
    ----------
    settings : BenchSettings
    show : function of (done, of)
        Called before each press.
    """
    patch, total = settings.patch, LEAD + settings.size.readings
    places, forces = paths(total)
    exact = np.empty((total, len(patch)))
    for index in range(total):
        show(index, total)
        balls = [
            Sphere(radius=RADIUS, force=float(force), position=(float(x), float(y)))
            for force, (x, y) in zip(forces[index], places[index], strict=True)
        ]
        solved = press(settings.layer, balls, EXTENT, settings.size.cell)
        exact[index] = solved.readings(patch.plane, patch.pad_diameter, "stress")
    rng = np.random.default_rng(settings.seed)
    noisy = exact + rng.normal(scale=settings.noise, size=exact.shape)
    return Scene(noisy, exact, places, forces)
