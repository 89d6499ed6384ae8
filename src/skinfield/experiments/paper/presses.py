"""The paper's presses: its indenters, solved once each and then moved over the patch.

The layer has no border, so a press that is moved gives the readings of taxels that are moved the
other way; and an indenter that turns about its axis gives readings that depend on the taxel's
distance alone.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.layout import Patch
from skinfield.layout.generators import hexagon72
from skinfield.mechanics import Layer
from skinfield.simulate import Cylinder, Press, Sphere, press

LOADS = (0.2, 0.5, 1.8, 3.0)  # N
PLACES = ("over a taxel", "between two", "between three")
INNER = 20e-3  # m from the patch's middle: no press reaches over its rim
PAIR = 6e-3  # m: taxels that are neighbours
# m; as far as a taxel is from an inner press, closer where readings change within a millimetre
FAR = np.concatenate([np.linspace(0.0, 12e-3, 121), np.linspace(12.5e-3, 60e-3, 39)])


@dataclass(frozen=True)
class Tip:
    """One of the paper's four indenters.

    Parameters
    ----------
    name : str
    body : Sphere or Cylinder
        At the origin; its load is set for each press.
    extent : float, m
        Side of the square in which it may touch.
    """

    name: str
    body: Sphere | Cylinder
    extent: float

    def pressed(self, layer: Layer, force: float, cell: float) -> Press | None:
        """Truth under a force in N; None where linear elasticity lets it sink through the layer."""
        return _pressed(self, layer, force, cell)


TIPS = (
    Tip("half-sphere 0.6 cm", Sphere(radius=3e-3), 8e-3),
    Tip("half-sphere 1.2 cm", Sphere(radius=6e-3), 12e-3),
    Tip("cylinder 0.3 cm", Cylinder(radius=1.5e-3), 6e-3),
    Tip("cylinder 1.2 cm", Cylinder(radius=6e-3), 14e-3),
)
BALL = TIPS[1]  # of Figures 6 to 8


@lru_cache(maxsize=64)
def _pressed(tip: Tip, layer: Layer, force: float, cell: float) -> Press | None:
    try:
        return press(layer, [replace(tip.body, force=force)], tip.extent, cell)
    except InputError as error:
        if "sinks" not in str(error):
            raise
        return None


@lru_cache(maxsize=128)
def _profile(
    tip: Tip, layer: Layer, force: float, cell: float, pad: float, quantity: str
) -> Floats | None:
    """Readings of taxels at the distances FAR from the tip."""
    solved = _pressed(tip, layer, force, cell)
    line = np.column_stack([FAR, np.zeros_like(FAR)])
    return None if solved is None else solved.readings(line, pad, quantity)


def readings(
    tip: Tip, patch: Patch, layer: Layer, force: float, cell: float, places: Floats, quantity: str
) -> Floats | None:
    """Readings (P, L) without noise of a patch that is pressed at places (P, 2) m.

    Parameters
    ----------
    quantity : str
        "stress" or "capacitance"; None comes back where the tip sinks through the layer.
    """
    profile = _profile(tip, layer, force, cell, patch.pad_diameter, quantity)
    if profile is None:
        return None
    distance = np.linalg.norm(patch.plane[None] - places[:, None], axis=2)
    return np.asarray(np.interp(distance, FAR, profile))


def moved(solved: Press, plane: Floats, place: Floats) -> tuple[Floats, Floats]:
    """Pressure (K,) Pa and indentation (K,) m of a press moved to `place`, at points (K, 2) m.

    Points beyond the press's own grid have none: it is where the tip may touch.
    """
    from scipy.ndimage import map_coordinates

    grid = solved.grid
    where = ((plane - place - grid.origin) / grid.pitch).T[::-1]
    fields = (solved.pressure, -solved.displacement[:, 2])
    pressure, inwards = (
        map_coordinates(field.reshape(grid.shape), where, order=1, cval=0.0) for field in fields
    )
    return np.asarray(pressure), np.asarray(inwards)


@lru_cache(maxsize=1)
def paper_patch() -> Patch:
    """The hexagon of six modules with 72 taxels."""
    return hexagon72()


@lru_cache(maxsize=4)
def sites(patch: Patch) -> dict[str, Floats]:
    """Places (P, 2) m for each of `PLACES`, away from the patch's rim."""
    from scipy.spatial import Delaunay

    plane = patch.plane
    corners = plane[Delaunay(plane).simplices]  # (T, 3, 2)
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    close = corners[(sides < PAIR).all(axis=1)]
    middles = ((corners + np.roll(corners, 1, axis=1)) / 2)[sides < PAIR]
    found = (plane, np.unique(middles.round(9), axis=0), close.mean(axis=1))
    return {
        name: places[np.linalg.norm(places, axis=1) < INNER]
        for name, places in zip(PLACES, found, strict=True)
    }
