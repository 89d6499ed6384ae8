"""What pads at the base, or above it, see of touches."""

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_finite,
    check_range,
    check_shape,
)
from skinfield.simulate.pressing.plane import Skin
from skinfield.simulate.pressing.touch import Sources, Touch, sources

WIDEST = 0.125  # thicknesses: side of the squares that stand for a touch


def points_of(positions: ArrayLike, pad_diameter: float) -> Floats:
    """Points of the plane (L, 2) m from (L, 2) or (L, 3), beside a diameter that can be."""
    check_range("pad_diameter", pad_diameter, 0.0, 1.0, "0 is a point; give it in metres")
    positions = as_floats("positions", positions)
    columns = 3 if positions.ndim == 2 and positions.shape[1] == 3 else 2
    check_shape("positions", positions, (None, columns), "x, y (and z) of each pad, in metres")
    check_finite("positions", positions, "a pad without a place reads nothing")
    if not len(positions):
        raise InputError("positions is empty, expected at least one pad: nothing would be read")
    return positions[:, :2]


def _offsets(places: Floats, source: Sources) -> Floats:
    return (places[:, None] - source.places[None]).reshape(-1, 2)


def _sources(skin: Skin, touches: tuple[Touch, ...]) -> list[Sources]:
    every = [sources(skin, touch, WIDEST * skin.layer.thickness) for touch in touches]
    return [source for source in every if len(source.places)]


def base_stress(
    skin: Skin, touches: tuple[Touch, ...], places: Floats, pad_diameter: float
) -> Floats:
    """Mean pressure (L,) Pa on pads at the base."""
    out = np.zeros(len(places))
    for source in _sources(skin, touches):
        if source.traction[:, :2].any():
            out -= _traction(skin, source, places, pad_diameter)[:, 2]
            continue
        each = skin.mechanics.base_stress(
            skin.layer, _offsets(places, source), source.side, pad_diameter
        )
        out -= each.reshape(len(places), -1) @ source.traction[:, 2]
    return out


def base_traction(
    skin: Skin, touches: tuple[Touch, ...], places: Floats, pad_diameter: float
) -> Floats:
    """Mean traction (L, 3) Pa that the skin exerts on the base's pads, as an outward normal +z."""
    out = np.zeros((len(places), 3))
    for source in _sources(skin, touches):
        out += _traction(skin, source, places, pad_diameter)
    return out


def _traction(skin: Skin, source: Sources, places: Floats, pad_diameter: float) -> Floats:
    each = skin.mechanics.base_traction(
        skin.layer, _offsets(places, source), source.side, pad_diameter
    )
    each = each.reshape(len(places), -1, 3, 3)
    return np.asarray(np.einsum("lnij,nj->li", each, source.traction))


def gap_change(
    skin: Skin, touches: tuple[Touch, ...], places: Floats, pad_diameter: float
) -> Floats:
    """Mean indentation (L,) m above pads."""
    out = np.zeros(len(places))
    for source in _sources(skin, touches):
        each = skin.mechanics.indentation(
            skin.layer, _offsets(places, source), source.side, pad_diameter
        )
        out -= each.reshape(len(places), -1) @ source.traction[:, 2]
        if source.traction[:, :2].any():
            for place, weight in _disc_rule(pad_diameter / 2):
                each = skin.mechanics.surface_displacement(
                    skin.layer, _offsets(places + place, source), source.side
                ).reshape(len(places), -1, 3, 3)
                out -= weight * np.einsum("lnj,nj->l", each[:, :, 2, :2], source.traction[:, :2])
    return out


def _disc_rule(radius: float) -> list[tuple[Floats, float]]:
    """Points and weights that average over a disc: the seven of degree 5 (Stroud's S2 5-1)."""
    if radius == 0.0:
        return [(np.zeros(2), 1.0)]
    angle = np.arange(6) * np.pi / 3
    ring = np.column_stack([np.cos(angle), np.sin(angle)]) * radius * np.sqrt(2 / 3)
    return [(np.zeros(2), 0.25), *((place, 0.125) for place in ring)]
