"""What came of an engine elsewhere, and how long it took."""

from dataclasses import dataclass
from typing import Any

from skinfield.bridges.zenoh.messages import EstimateHead

DRIFT = 1e-4  # between two computers' clocks


@dataclass
class Counts:
    """What came of an engine, and what did not.

    Attributes
    ----------
    received : int
        Estimates.
    octets : int, bytes
        In them.
    refused : int
        Messages that made no sense.
    other : int
        Estimates of another description than is known: one is asked for then.
    """

    received: int = 0
    octets: int = 0
    refused: int = 0
    other: int = 0


@dataclass(frozen=True, eq=False)
class Arrived:
    """An estimate as it came: nothing of it is looked at before somebody wants it."""

    head: EstimateHead
    payload: Any
    received_ns: int
    monotonic: float
    excess: float  # s that it took longer than the fastest lately


class Delay:
    """How much longer a message took than the fastest: clocks that differ drop out."""

    def __init__(self) -> None:
        self._least: tuple[float, float] | None = None  # s of delay, and when that was seen

    def excess(self, delay: float, now: float) -> float:
        """How much longer a message took, s.

        Parameters
        ----------
        delay : float, s
            From sent to received, each by its own clock.
        now : float, s
            Of the monotonic clock here.
        """
        least = self._least
        if least is None or delay <= least[0] + DRIFT * (now - least[1]):
            self._least = delay, now
            return 0.0
        return delay - least[0]
