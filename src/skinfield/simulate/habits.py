"""Habits of skins: what one that was made and is worn does beside what is stated of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Annotated

import numpy as np

from skinfield.elastic import Layer, StandardLinearSolid
from skinfield.errors import Floats, check_choice
from skinfield.settings import Range, Section
from skinfield.simulate.electronics.array import Defects, Electronics, Hysteresis
from skinfield.simulate.electronics.board import CySkinBoard
from skinfield.simulate.indenters.finger import Finger
from skinfield.skin import Patch

SPREAD = Range(0.0, 0.5, "a part of the stated value; 0 is as stated")
COMPRESSIBLE = 0.5  # Poisson's ratio beyond which nothing is: what lies there is folded back
CLIPPED = 170.0
"""Counts of CySkin's noise before its boards clip it at rest; 85, as recordings say, is after."""


@dataclass(frozen=True, kw_only=True)
class Tolerances(Section):
    """By how much a skin differs from what is stated of it.

    Parameters
    ----------
    thickness_error, modulus_error, poisson_error : float
        Each true value lies anywhere within so large a part of the stated one to both sides.
    place_error : float, m
        Standard deviation of a taxel's place along each axis of the patch's plane.
    """

    thickness_error: Annotated[float, SPREAD] = 0.0
    modulus_error: Annotated[float, SPREAD] = 0.0
    poisson_error: Annotated[float, SPREAD] = 0.0
    place_error: Annotated[float, Range(0.0, 0.01, "in metres; 0 is as stated")] = 0.0

    def layer(self, stated: Layer, rng: np.random.Generator) -> Layer:
        """True layer of a stated one."""
        off = rng.uniform(-1.0, 1.0, 3)
        poisson = stated.poisson_ratio * (1.0 + self.poisson_error * float(off[2]))
        return replace(
            stated,
            thickness=stated.thickness * (1.0 + self.thickness_error * float(off[0])),
            young_modulus=stated.young_modulus * (1.0 + self.modulus_error * float(off[1])),
            poisson_ratio=min(poisson, 2.0 * COMPRESSIBLE - poisson),
        )

    def plane(self, stated: Patch, rng: np.random.Generator) -> Floats:
        """True places (L, 2) m of a patch's taxels in its plane."""
        return stated.plane + self.place_error * rng.standard_normal((len(stated), 2))


@dataclass(frozen=True, kw_only=True)
class Habits:
    """What comes on top of a skin as it is stated. The default is nothing.

    Parameters
    ----------
    tolerances : Tolerances
    elastomer : StandardLinearSolid, optional
        How it creeps; None leaves that to whoever simulates.
    gain_spread, converter_gain_spread, noise_spread, noise_limit, jumps, hysteresis : float
        See `Electronics`, `Noise` and `Hysteresis`.
    tared : bool
        See `Electronics`.
    defects : Defects
    lost_messages : float
        See `Delivery`.
    warming : float, K/s
        Of the surroundings, which counts follow.
    fingers : tuple of Finger
        What presses where nothing else is asked for.
    """

    tolerances: Tolerances = field(default_factory=Tolerances)
    elastomer: StandardLinearSolid | None = None
    gain_spread: float = 0.0
    converter_gain_spread: float = 0.0
    noise_spread: float = 0.0
    noise_limit: float = 0.0
    jumps: float = 0.0
    tared: bool = False
    hysteresis: float = 0.0
    defects: Defects = field(default_factory=Defects)
    lost_messages: float = 0.0
    warming: float = 0.0
    fingers: tuple[Finger, ...] = ()

    def electronics(self, usual: Electronics) -> Electronics:
        """Electronics of a board with these habits; each is the larger of its own and the habit's.

        Noise that a board clips at rest is what it is before.
        """
        noise = usual.noise
        white = noise.white
        if self.noise_spread and isinstance(usual.board, CySkinBoard):
            white = max(white, CLIPPED)
        return replace(
            usual,
            gain_spread=max(usual.gain_spread, self.gain_spread),
            converter_gain_spread=max(usual.converter_gain_spread, self.converter_gain_spread),
            tared=usual.tared or self.tared,
            hysteresis=Hysteresis(width=max(usual.hysteresis.width, self.hysteresis)),
            noise=replace(
                noise,
                white=white,
                spread=max(noise.spread, self.noise_spread),
                limit=self.noise_limit or noise.limit,
                jumps=max(noise.jumps, self.jumps),
            ),
            defects=usual.defects if self.defects == Defects() else self.defects,
            delivery=replace(
                usual.delivery, lost_messages=max(usual.delivery.lost_messages, self.lost_messages)
            ),
        )


NONE, REAL = "none", "real"
HABITS: Mapping[str, Habits] = MappingProxyType(
    {
        NONE: Habits(),
        REAL: Habits(
            tolerances=Tolerances(
                thickness_error=0.2, modulus_error=0.2, poisson_error=0.2, place_error=0.3e-3
            ),
            elastomer=StandardLinearSolid(relaxed_fraction=0.93, time_constant=1.0),
            gain_spread=0.12,
            converter_gain_spread=0.09,  # 15 % together
            noise_spread=1.1,
            noise_limit=2.5,
            jumps=0.01,
            tared=True,
            hysteresis=0.03,
            defects=Defects(dead=0.01, stuck=0.01),
            lost_messages=1e-3,
            warming=0.1 / 60.0,  # some counts a minute of CySkin's
            fingers=(
                Finger(width=9e-3),
                Finger(width=8e-3, length=20e-3),
                Finger(width=8e-3, length=20e-3, second=0.4, apart=26e-3),
            ),
        ),
    }
)
"""By name: none, and those of recorded skins, see `docs/explanation/electronics.md`."""


def habits_by_name(name: str) -> Habits:
    """Habits of a name in `HABITS`.

    Raises
    ------
    InputError
        For another name; the message lists those that there are.
    """
    check_choice("habits", name, HABITS, "of skins")
    return HABITS[name]
