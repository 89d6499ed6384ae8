"""The settings of a skin's electronics, and the array of taxels that is made to them."""

from dataclasses import dataclass, field

import numpy as np

from skinfield.errors import InputError, check_range
from skinfield.layout import Patch
from skinfield.simulate.electronics.array import TaxelArray
from skinfield.simulate.electronics.board import Board, ICubBoard
from skinfield.simulate.electronics.defects import Defects
from skinfield.simulate.electronics.delivery import Delivery
from skinfield.simulate.electronics.noise import Noise
from skinfield.simulate.electronics.thermal import ThermalDrift
from skinfield.simulate.electronics.thermal_pads import ThermalPads
from skinfield.simulate.electronics.wiring import CrossTalk, wiring


@dataclass(frozen=True, kw_only=True)
class Electronics:
    """From the change of capacitance to counts in time. Everything but the board is off at first.

    Parameters
    ----------
    board : Board
        What counts mean.
    quantised : bool
        Steps and clamps of the board; False leaves levels as they are.
    gain_spread : float
        Standard deviation of the logarithm of a taxel's gain over the nominal one.
    converter_gain_spread : float
        The same, of a factor that the taxels of one converter share.
    baseline_spread : float, counts
        Standard deviation of the baselines around the board's rest.
    cross_talk : CrossTalk
    drift : ThermalDrift
    thermal_pads : ThermalPads, optional
        Of an `ICubBoard`, for patches of ten-pad triangles.
    noise : Noise
    defects : Defects
    delivery : Delivery
    """

    board: Board = field(default_factory=ICubBoard)
    quantised: bool = True
    gain_spread: float = 0.0
    converter_gain_spread: float = 0.0
    baseline_spread: float = 0.0
    cross_talk: CrossTalk = field(default_factory=CrossTalk)
    drift: ThermalDrift = field(default_factory=ThermalDrift)
    thermal_pads: ThermalPads | None = None
    noise: Noise = field(default_factory=Noise)
    defects: Defects = field(default_factory=Defects)
    delivery: Delivery = field(default_factory=Delivery)

    def __post_init__(self) -> None:
        for name in ("gain_spread", "converter_gain_spread"):
            check_range(name, getattr(self, name), 0.0, 3.0, "of a logarithm; 0.1 is about 10 %")
        check_range("baseline_spread", self.baseline_spread, 0.0, 1e9, "in counts; 0 is off")
        if self.thermal_pads is not None and not isinstance(self.board, ICubBoard):
            raise InputError(
                f"thermal_pads is given with {self.board!r}, expected an ICubBoard: the correction "
                "is that of its firmware"
            )

    def manufacture(self, patch: Patch, rng: np.random.Generator) -> TaxelArray:
        """Draw the taxels of a patch.

        Each property has its own stream of random numbers, so that one that is switched off, or
        set otherwise, leaves the others as they were.

        Raises
        ------
        InputError
            If the patch has not the taxels that the matrix of the cross-talk, or the thermal pads,
            ask for.
        """
        wired, taxels = wiring(patch), len(patch)
        self.cross_talk.check_patch(patch)
        pads = self.thermal_pads
        if pads is not None:
            pads.check_wiring(wired)
        gains, bases, drifts, noises, defects, stops, warmth = rng.spawn(7)
        shared = gains.standard_normal(wired.converters)[wired.converter]
        own = gains.standard_normal(taxels)
        spread = self.converter_gain_spread * shared + self.gain_spread * own
        return TaxelArray(
            electronics=self,
            patch=patch,
            gain=self.board.gain * np.exp(spread),
            baseline=self.board.rest + self.baseline_spread * bases.standard_normal(taxels),
            drift=self.drift.draw(wired, drifts),
            pad_error=np.zeros(wired.converters) if pads is None else pads.draw(wired, warmth),
            white_noise=self.noise.draw(taxels, noises),
            defect=self.defects.draw(taxels, defects),
            stops_after=self.defects.stuck_within * stops.random(taxels),
        )
