"""What a tracker goes by."""

from dataclasses import dataclass, field

from skinfield.contacts.tracking.motion import Motion
from skinfield.errors import check_count, check_positive, check_range, check_type


@dataclass(frozen=True, kw_only=True)
class Gate:
    """How far from what is foretold a contact may be.

    Parameters
    ----------
    distance : float
        Squared Mahalanobis distance of the place: 18.4 is exceeded with a chance of 1e-4.
    floor : float, m
        Standard deviation of the place, on each axis, that is added: what solvers do not state.
    reach : float, m
        Farthest distance, whatever the covariance.
    """

    distance: float = 18.4
    floor: float = 1e-3
    reach: float = 8e-3

    def __post_init__(self) -> None:
        check_positive("distance", self.distance, "squared Mahalanobis distance")
        check_positive("floor", self.floor, "standard deviation of the place, in metres")
        check_positive("reach", self.reach, "from what is foretold, in metres")


@dataclass(frozen=True, kw_only=True)
class Habits:
    """Settings of a `Tracker`, which says what they are."""

    period: float = 0.02
    motion: Motion = field(default_factory=Motion)
    gate: Gate = field(default_factory=Gate)
    coast: float = 0.1
    strong: float = 5.0
    weak_readings: int = 2
    near: float = 12e-3
    memory: float = 1.0
    slip_speed: float = 5e-3
    slip_sigmas: float = 3.0

    def __post_init__(self) -> None:
        check_positive("period", self.period, "seconds between readings without stamps")
        check_range("coast", self.coast, 0.0, 1e6, "seconds for which a contact may be unseen")
        check_range("strong", self.strong, 0.0, 1e6, "standard deviations of the force")
        check_positive("near", self.near, "farthest distance of contacts that merge, in metres")
        check_positive("memory", self.memory, "seconds for which merged contacts are known")
        check_positive("slip_speed", self.slip_speed, "from which on a contact slips, in m/s")
        check_range("slip_sigmas", self.slip_sigmas, 0.0, 1e6, "standard deviations of the speed")
        check_count("weak_readings", self.weak_readings, 1, 1000, "in a row, before a weak contact")
        check_type("motion", self.motion, Motion, "how contacts move")
        check_type("gate", self.gate, Gate, "how far from what is foretold a contact may be")
