"""Cases for everyone: one and several contacts, flat, ring and bar, other elastomers."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from skinfield.errors import check_choice
from skinfield.experiments.cases.case import QUANTITIES, Case
from skinfield.layout import Patch
from skinfield.mechanics import BondedLayer, Layer
from skinfield.simulate import Bar, Cone, Cylinder, Ring, Sphere, press

SILICONE = Layer(2e-3, 100e3, 0.5)
AROUND = 14e-3  # m: from a press's middle to the sides of the square of skin that is solved
INSET = 0.6  # of the patch's half width: presses stay away from its rim


@dataclass(frozen=True)
class Kind:
    """A kind of press: what it is called, the bodies about the origin, the elastomer."""

    name: str
    bodies: tuple[Any, ...]
    layer: Layer = SILICONE
    cover: bool = False


def ball(diameter_mm: float, force: float, x_mm: float = 0.0, y_mm: float = 0.0) -> Sphere:
    """A ball at a place."""
    return Sphere(radius=diameter_mm / 2e3, force=force, position=(x_mm / 1e3, y_mm / 1e3))


def flat(diameter_mm: float, force: float, x_mm: float = 0.0, y_mm: float = 0.0) -> Cylinder:
    """A flat cylinder at a place."""
    return Cylinder(radius=diameter_mm / 2e3, force=force, position=(x_mm / 1e3, y_mm / 1e3))


ONE = (ball(12, 1.0),)
KINDS = (
    Kind("ball12_1N", ONE),
    Kind("ball6_1N", (ball(6, 1.0),)),
    Kind("flat3_0.5N", (flat(3, 0.5),)),
    Kind("flat12_3N", (flat(12, 3.0),)),
    Kind("two_balls_12mm_apart", (ball(12, 1.0, -6), ball(12, 1.0, 6))),
    Kind("bar_16x3_2N", (Bar(length=16e-3, width=3e-3, force=2.0),)),
    Kind("ring_10_2N", (Ring(inner_radius=4e-3, outer_radius=5e-3, force=2.0),)),
    Kind("ball12_thick_4mm", ONE, Layer(4e-3, 100e3, 0.5)),
    Kind("ball12_foam_nu0.3", ONE, Layer(2e-3, 100e3, 0.3)),
    Kind("ball12_0.5N", (ball(12, 0.5),)),
    Kind("ball12_3N", (ball(12, 3.0),)),
    Kind("ball20_2N", (ball(20, 2.0),)),
    Kind("ball6_0.5N", (ball(6, 0.5),)),
    Kind("ball6_1.8N", (ball(6, 1.8),)),
    Kind("flat6_1N", (flat(6, 1.0),)),
    Kind("two_balls_unequal", (ball(6, 0.5, -8), ball(12, 2.0, 8))),
    Kind("three_balls", (ball(6, 0.7, -8, -5), ball(6, 0.7, 8, -5), ball(6, 0.7, 0, 8))),
    Kind("ball_and_flat", (ball(6, 0.8, -8), flat(6, 1.0, 7))),
    Kind("cone_1N", (Cone(radius=6e-3, half_angle=np.radians(75.0), force=1.0),)),
    Kind("ball12_thin_1mm", ONE, Layer(1e-3, 100e3, 0.5)),
    Kind("ball12_nu0.45", ONE, Layer(2e-3, 100e3, 0.45)),
    Kind("ball12_covered", ONE, cover=True),
)


def standard_cases(
    patch: Patch,
    count: int = len(KINDS),
    seed: int = 0,
    quantity: str = "capacitance",
    noise_std: float | None = None,
    draws: int = 1,
    cell: float = 0.25e-3,
) -> Iterator[Case]:
    """Make cases one after another; the same arguments give the same cases.

    The kinds of `KINDS` come in turn, each at a place and an angle of its own; beyond their number
    they come again at others.

    Parameters
    ----------
    patch : Patch
        Presses stay in the middle of it, with 0.6 of its width and height.
    count : int
    seed : int
    quantity : "capacitance", "gap" or "stress"
    noise_std : float, in the quantity's unit, optional
        Default its `typical_noise`.
    draws : int
        Readings per case that differ in their noise; 0 for one exact reading.
    cell : float, m
        Of the truth.
    """
    check_choice("quantity", quantity, QUANTITIES, "what taxels read")
    low, high = patch.plane.min(axis=0), patch.plane.max(axis=0)
    solved = {}
    for index in range(count):
        kind = KINDS[index % len(KINDS)]
        if index < len(KINDS) or kind.name not in solved:
            solved[kind.name] = press(
                kind.layer,
                list(kind.bodies),
                extent=2 * AROUND,
                cell=cell,
                mechanics=BondedLayer(inextensible_cover=kind.cover),
            )
        rng = np.random.default_rng([seed, index])
        x, y = (low + high) / 2 + rng.uniform(-INSET / 2, INSET / 2, 2) * (high - low)
        case = Case.from_press(
            f"{index:03d}_{kind.name}",
            solved[kind.name],
            patch,
            quantity,
            (float(x), float(y), float(rng.uniform(0.0, 2 * np.pi))),
            noise_std,
        )
        yield case.with_noise(seed * 1_000_003 + index, draws) if draws else case
