"""Fields of many kinds, with the errors that go with them, for whoever finds contacts in them."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from skinfield.estimate import ContactFinder, ModelError, PressureNoise, PressurePosterior
from skinfield.estimate import regions_kernel as kernel
from skinfield.skin import Grid, Patch
from skinfield.skin.generators import cylinder, hexagon72, sphere_cap

KNOWN = ModelError(force=0.2, place=1e-4)
FINDERS = (
    ContactFinder(),
    ContactFinder(relative_height=0.05, prominence=0.1, edge=0.0),
    ContactFinder(relative_height=0.5, prominence=0.6, edge=0.5),
    ContactFinder(relative_height=0.0, prominence=0.0, edge=1.0),
    ContactFinder(relative_height=0.3, prominence=1.0, edge=0.1),
)


@dataclass(frozen=True, eq=False)
class Scene:
    """What a finder is called with."""

    name: str
    finder: ContactFinder
    grid: Grid
    pressure: np.ndarray
    noise: PressureNoise
    error: PressurePosterior | None
    model_error: ModelError

    def __call__(self):
        return self.finder(self.grid, self.pressure, self.noise, self.error, self.model_error)


@lru_cache
def grids() -> dict[str, Grid]:
    flat, pipe, ball = hexagon72(), cylinder(radius=40e-3), sphere_cap(radius=30e-3)
    low, high = flat.plane.min(axis=0), flat.plane.max(axis=0)
    turned = Patch(
        flat.positions @ rotation().T + (0.1, -0.2, 0.3), normals=flat.normals @ rotation().T
    )
    return {
        "hexagon": Grid.square(flat, 40),
        "coarse": Grid.square(flat, 12),
        "window": Grid.window(flat, low + 5e-3, high - (20e-3, 12e-3), 1.1e-3),
        "turned": Grid.square(turned, 25),
        "pipe": Grid.square(pipe, 30),
        "ball": Grid.square(ball, 28),
        "row": Grid(flat, (1, 30), 1.5e-3),
        "column": Grid(flat, (30, 1), 1.5e-3),
        "node": Grid(flat, (1, 1), 1.5e-3),
    }


def rotation() -> np.ndarray:
    return np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0] * (1, 1, -1)


def bumps(grid: Grid, rng: np.random.Generator, count: int) -> np.ndarray:
    """Sum of Gaussian and parabolic bumps."""
    low, high = grid.plane.min(axis=0), grid.plane.max(axis=0)
    total = np.zeros(len(grid))
    for _ in range(count):
        away = (grid.plane - rng.uniform(low, high)) / rng.uniform(1.5, 6.0, 2) / grid.pitch
        square = (away**2).sum(axis=1)
        shape = np.exp(-square) if rng.random() < 0.5 else np.maximum(0.0, 1.0 - square / 2)
        total += rng.uniform(2e3, 2e4) * shape
    return total


def ring(grid: Grid, rng: np.random.Generator) -> np.ndarray:
    """A ring, which has a hole, or a part of one."""
    away = grid.plane - grid.plane.mean(axis=0)
    radius = rng.uniform(3, 8) * grid.pitch
    thick = np.maximum(
        0.0, 1.0 - ((np.hypot(*away.T) - radius) / rng.uniform(1, 3) / grid.pitch) ** 2
    )
    part = np.abs(np.arctan2(away[:, 1], away[:, 0])) < rng.uniform(1.5, 3.2)
    return 1e4 * thick * part


def ringing(grid: Grid, rng: np.random.Generator) -> np.ndarray:
    """As linear solvers answer: lobes of both signs around bumps."""
    picture = bumps(grid, rng, 2).reshape(grid.shape)
    around = sum(np.roll(picture, step, axis) for step in (-2, 2) for axis in (0, 1))
    return (picture - 0.3 * around).ravel()


def ties(grid: Grid, rng: np.random.Generator) -> np.ndarray:
    """A few levels only, with plateaus and equal peaks."""
    return np.round(bumps(grid, rng, 4) / 3e3) * 3e3


def noisy(grid: Grid, rng: np.random.Generator, noise: PressureNoise) -> np.ndarray:
    drawn = noise.factor @ rng.normal(size=noise.factor.shape[1])
    return bumps(grid, rng, int(rng.integers(0, 4))) + drawn


def errors_on(grid: Grid, rng: np.random.Generator) -> tuple[PressureNoise, PressurePosterior]:
    """Noise of 20 readings, and a posterior whose readings explain a part of a smooth prior."""
    rows, columns = grid.shape
    centres = rng.uniform(grid.plane.min(axis=0), grid.plane.max(axis=0) + 1e-6, (20, 2))
    apart = ((grid.plane[:, None] - centres[None]) ** 2).sum(axis=2) / (3 * grid.pitch) ** 2
    factor = np.exp(-apart) * rng.uniform(20, 200)
    factor[rng.random(len(grid)) < 0.1] = 0.0  # cells that feel nothing
    down, right = np.divmod(np.arange(len(grid)), columns)
    scaled = np.hypot(down, right) / 2.0
    prior = ((1 + scaled) * np.exp(-scaled)).reshape(rows, columns) * 1e6
    return PressureNoise(factor), PressurePosterior.of_lattice(prior, factor * 0.7)


def scenes(seed: int = 0, each: int = 8, kinds: dict[str, Grid] | None = None) -> Iterator[Scene]:
    """`each` times all kinds of fields on all grids, with a finder, noise and error by turns."""
    rng = np.random.default_rng(seed)
    for name, grid in (grids() if kinds is None else kinds).items():
        for turn in range(each):
            noise, posterior = errors_on(grid, rng)
            fields = {
                "empty": np.zeros(len(grid)),
                "suction": -bumps(grid, rng, 2),
                "bumps": bumps(grid, rng, 1 + turn % 4),
                "ring": ring(grid, rng),
                "ringing": ringing(grid, rng),
                "ties": ties(grid, rng),
                "noisy": noisy(grid, rng, noise),
                "idle": noise.factor @ rng.normal(size=noise.factor.shape[1]),
                "white": 1e3 * rng.normal(size=len(grid)),
                "full": 1e4 + 1e2 * rng.normal(size=len(grid)),
            }
            for kind, pressure in fields.items():
                yield Scene(
                    f"{name}-{kind}-{turn}",
                    FINDERS[turn % len(FINDERS)],
                    grid,
                    pressure,
                    noise,
                    (posterior, None)[turn % 3 == 2],
                    (ModelError(), KNOWN)[turn % 2],
                )


def regions(values: np.ndarray, prominence: float, height: float, edge: float) -> list[np.ndarray]:
    """Split a picture into the regions of its peaks, each as rising flat cells; by falling peak."""
    flat = np.ascontiguousarray(values, dtype=np.float64).ravel()
    work = kernel.room_for(len(flat), values.shape[1])
    limits = np.array([1.0, height, prominence, edge])
    count = kernel.find(flat, np.zeros(len(flat)), values.shape[1], limits, *work)
    assert (work[0] == -1).all()
    starts, cells = work[2][kernel.STARTS], work[2][kernel.REGIONS]
    return [cells[starts[n] : starts[n + 1]].copy() for n in range(count)]
