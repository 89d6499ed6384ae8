"""Electronics as they are known, and as they are not."""

from skinfield.simulate.electronics.board import CySkinBoard, ICubBoard, LinearBoard
from skinfield.simulate.electronics.delivery import Delivery
from skinfield.simulate.electronics.electronics import Electronics
from skinfield.simulate.electronics.noise import Noise
from skinfield.simulate.electronics.thermal import ThermalDrift
from skinfield.simulate.electronics.wiring import CrossTalk


def icub_electronics() -> Electronics:
    """Electronics of a board like the iCub's: bytes, 20 readings a second.

    Sources of the figures are in `docs/electronics.md`.
    """
    return Electronics(
        board=ICubBoard(),
        gain_spread=0.05,
        converter_gain_spread=0.1,
        baseline_spread=1.0,
        cross_talk=CrossTalk(neighbours=0.01),
        drift=ThermalDrift(
            per_kelvin=0.3, converter_spread=0.1, taxel_spread=0.1, time_constant=120.0
        ),
        noise=Noise(white=3.1, spread=0.5, flicker=0.3, walk=0.02),
        delivery=Delivery(
            rate=20.0,
            conversion_time=0.7e-3,
            free_running=True,
            delay=10e-3,
            jitter=0.03e-3,
            lost_readings=1e-3,
        ),
    )


def cyskin_electronics() -> Electronics:
    """Electronics of a board like CySkin's: 16-bit words clipped at 0, 20 readings a second.

    Sources of the figures are in `docs/electronics.md`.
    """
    return Electronics(
        board=CySkinBoard(),
        gain_spread=0.05,
        converter_gain_spread=0.1,
        cross_talk=CrossTalk(neighbours=0.01),
        drift=ThermalDrift(
            per_kelvin=-50.0, converter_spread=17.0, taxel_spread=17.0, time_constant=120.0
        ),
        noise=Noise(white=85.0, spread=0.3, flicker=10.0, walk=2.0),
        delivery=Delivery(
            rate=20.0, conversion_time=0.7e-3, free_running=True, delay=10e-3, jitter=1e-3
        ),
    )


def ideal_electronics(rate: float = 20.0) -> Electronics:
    """No electronics: readings are ΔC/C₀ itself, `rate` times a second."""
    return Electronics(board=LinearBoard(), quantised=False, delivery=Delivery(rate=rate))
