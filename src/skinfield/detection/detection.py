"""What a detector says of one window of readings."""

from collections.abc import Iterator
from dataclasses import dataclass

from skinfield.errors import Floats


@dataclass(frozen=True, eq=False, kw_only=True)
class Detection:
    """Whether anything touches, and if so, where and how hard.

    ``statistic, detected = detection`` takes it apart.

    Attributes
    ----------
    statistic : float
        What is compared with `threshold`.
    threshold : float
        Idle readings exceed it at the stated rate of false alarms, or more seldom.
    detected : bool
        Whether they do.
    probability : float
        Of a touch, given the readings and the detector's `touch_rate`.
    position : (3,) array, m
        The most probable of the places that were tried, on the surface, in the patch's frame.
    position_std : float, m
        Root mean square distance of the touch from `position`, if there is one: along the surface,
        over all places and the spacing between them. A quarter of the taxels' distance is in it
        (as a squared deviation) for what no template is like.
    force, force_std : float, N
        Of the touch, if there is one: mean and standard deviation over all places and sizes; half
        of the force is in it (as a squared deviation) for what no template is like.
    readings : int
        For how many readings the touch has most probably lasted, of the lengths that were tried.
    left_out : int
        Values of single taxels that were NaN.
    """

    statistic: float
    threshold: float
    detected: bool
    probability: float
    position: Floats
    position_std: float
    force: float
    force_std: float
    readings: int
    left_out: int

    def __iter__(self) -> Iterator[float | bool]:
        yield self.statistic
        yield self.detected
