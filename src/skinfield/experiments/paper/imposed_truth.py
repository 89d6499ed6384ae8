"""The skin of Figure 3: 0.2 mm imposed on three taxels, in three ways of making its readings."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.paper.presses import PAIR, paper_patch
from skinfield.experiments.settings import Settings
from skinfield.layout import Grid, Patch
from skinfield.mechanics import HalfSpace, Layer
from skinfield.observation import Deformation
from skinfield.pipeline import Reconstructor
from skinfield.simulate import Cylinder, press

DEPTH = 0.2e-3  # m
EXTENT = 46e-3  # m: side of the square that holds all discs
INNER_TRIO = (0.0, 10.7e-3)  # m: near the middle of the three adjacent taxels
APART = 15e-3  # m: of the separate taxels from the middle
ADJACENT, SEPARATE = "three adjacent taxels", "three separate taxels"
CELL = 0.5e-3  # m; the contact is solved on finer squares
PARTS = 5  # to a side of a cell, when its force is shared among others
LAYER, HALF_SPACE, OWN_GRID = "layer", "half-space", "own grid"


@dataclass(frozen=True, eq=False)
class Truth:
    """What is imposed, and what the taxels read of it without noise.

    Attributes
    ----------
    world : str
        "layer": discs on the bonded layer, pads read their mean stress. "half-space": the paper's
        mechanics in both directions, stress at the pads' centres, but a grid of its own.
    case : str
    places : (3, 2) array, m
        Of the discs, which are as wide as pads.
    grid : Grid
        Fine cells.
    pressure, indentation : (K,) arrays, Pa and m
    readings : (L,) array, Pa
    """

    world: str
    case: str
    places: Floats
    grid: Grid
    pressure: Floats
    indentation: Floats
    readings: Floats

    @property
    def force(self) -> float:
        """Total, N."""
        return float(self.pressure.sum() * self.grid.cell_area)

    def on(self, grid: Grid) -> tuple[Floats, Floats]:
        """Mean pressure over the cells (K,) Pa of another grid, and indentation at its nodes.

        The discs must lie inside the other grid.
        """
        from scipy.ndimage import map_coordinates

        pressed = self.pressure != 0
        steps = (np.arange(PARTS) - (PARTS - 1) / 2) / PARTS * self.grid.pitch
        within = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        points = self.grid.plane[pressed][:, None] + within
        nodes = np.round((points - grid.origin) / grid.pitch).astype(int)
        index = nodes[..., 1] * grid.shape[1] + nodes[..., 0]
        part = np.repeat(self.pressure[pressed] * self.grid.cell_area / PARTS**2, PARTS**2)
        forces = np.bincount(index.ravel(), part, len(grid))
        where = ((grid.plane - self.grid.origin) / self.grid.pitch).T[::-1]
        picture = self.indentation.reshape(self.grid.shape)
        return forces / grid.cell_area, map_coordinates(picture, where, order=1)


def discs_of(patch: Patch) -> dict[str, Floats]:
    """Centres (3, 2) m of the taxels that are pressed."""
    plane = patch.plane
    distance = np.linalg.norm(plane[:, None] - plane[None], axis=2)
    near = (distance < PAIR) & (distance > 0)
    trios = [
        (a, b, c)
        for a in range(len(plane))
        for b in np.flatnonzero(near[a]).tolist()
        for c in np.flatnonzero(near[a] & near[b]).tolist()
        if a < b < c
    ]
    spots = np.array([plane[list(trio)].mean(axis=0) for trio in trios])
    first = trios[int(np.linalg.norm(spots - INNER_TRIO, axis=1).argmin())]
    bearings = np.radians([90.0, 210.0, 330.0])
    ideal = APART * np.column_stack([np.cos(bearings), np.sin(bearings)])
    chosen = np.linalg.norm(plane[None] - ideal[:, None], axis=2).argmin(axis=1)
    return {ADJACENT: plane[list(first)], SEPARATE: plane[chosen]}


def truth_of(world: str, case: str, settings: Settings) -> Truth:
    """Press flat discs as wide as pads 0.2 mm deep, all at once, and read the patch."""
    patch, layer = paper_patch(), settings.layer
    places = discs_of(patch)[case]
    discs = [
        Cylinder(radius=patch.pad_diameter / 2, position=(x, y), depth=DEPTH)
        for x, y in places.tolist()
    ]
    mechanics = HalfSpace(point_forces=False) if world == HALF_SPACE else None
    solved = press(layer, discs, EXTENT, CELL, mechanics)
    pad = 0.0 if world == HALF_SPACE else patch.pad_diameter
    grid = Grid(patch, solved.grid.shape, solved.grid.pitch, solved.grid.origin)
    inwards = -solved.displacement[:, 2]
    readings = solved.base_stress(patch.plane, pad)
    return Truth(world, case, places, grid, solved.pressure, inwards, readings)


def truth_on_own_grid(reconstruct: Reconstructor, case: str, layer: Layer) -> Truth:
    """Forces on the very nodes that are reconstructed: the paper's formulas in both directions.

    The nodes under the discs are pushed in by 0.2 mm, by (19) and (26), and the taxels read (9).
    """
    grid, patch = reconstruct.grid, reconstruct.patch
    places = discs_of(patch)[case]
    away = np.linalg.norm(grid.plane[:, None] - places[None], axis=2)
    pushed = np.flatnonzero((away <= patch.pad_diameter / 2).any(axis=1))
    deform = Deformation(grid, layer, reconstruct.mechanics)
    single = np.zeros((len(pushed), len(grid)))
    single[np.arange(len(pushed)), pushed] = 1.0
    response = -deform(single)[:, :, 2]  # (pushed, K) m per Pa
    pressure = np.zeros(len(grid))
    pressure[pushed] = np.linalg.solve(response[:, pushed].T, np.full(len(pushed), DEPTH))
    inwards = -deform(pressure)[:, 2]
    readings = reconstruct.model.matrix @ pressure
    return Truth(OWN_GRID, case, places, grid, pressure, inwards, readings)
