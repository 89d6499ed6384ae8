"""Where the truth of a contact may lie: intervals at any level."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, InputError, check_range

ANGLES = 32  # at which an ellipse is seen in a quarter turn
HALVINGS = 60


@dataclass(frozen=True, eq=False)
class Spread:
    """Truths that presses like this one had, as seen from what is said of it.

    Attributes
    ----------
    forces : (N,) array, N
        Rising.
    places : (N,) array, m
        Distances from the contact's position, rising.
    areas : (N,) array, m²
        Rising.
    """

    forces: Floats
    places: Floats
    areas: Floats

    def force_interval(self, level: float) -> tuple[float, float]:
        """Interval (N, N) that holds the truth with probability `level`: as much beyond each end.

        Raises
        ------
        InputError
            If so few presses say nothing of so high a level.
        """
        return between(self.forces, level)

    def area_interval(self, level: float) -> tuple[float, float]:
        """As `force_interval`, m²."""
        return between(self.areas, level)

    def place_radius(self, level: float) -> float:
        """Radius, m, of the circle around the position that holds the truth with this chance."""
        return below(self.places, level)


def between(truths: Floats, level: float) -> tuple[float, float]:
    """Ends of the middle `level` of what a further truth may be, after N rising ones."""
    rank = (len(truths) + 1) * (1.0 - _checked(level)) / 2
    if rank < 1.0:
        raise InputError(
            f"level is {level!r}, expected at most {(len(truths) - 1) / (len(truths) + 1):.3g}: "
            f"only {len(truths)} presses were like this contact; calibrate with more"
        )
    at = np.array([rank, len(truths) + 1 - rank]) - 1.0
    low, high = np.interp(at, np.arange(len(truths)), truths)
    return float(low), float(high)


def below(truths: Floats, level: float) -> float:
    """What a further truth stays below with probability `level`, after N rising ones.

    The rank is that of a further number among N + 1 (Vovk, Gammerman and Shafer, Algorithmic
    Learning in a Random World, 2005); between two ranks the value is interpolated.
    """
    rank = (len(truths) + 1) * _checked(level)
    if rank > len(truths):
        raise InputError(
            f"level is {level!r}, expected at most {len(truths) / (len(truths) + 1):.3g}: only "
            f"{len(truths)} presses were like this contact; calibrate with more"
        )
    return float(np.interp(rank - 1.0, np.arange(len(truths)), truths))


def normal_interval(value: float, std: float, level: float) -> tuple[float, float]:
    """Middle `level` of a normal distribution."""
    from scipy.special import ndtri

    half = float(ndtri((1.0 + _checked(level)) / 2)) * std
    return value - half, value + half


def normal_radius(covariance: Floats, level: float) -> float:
    """Radius of the circle that holds a share `level` of a normal distribution in the plane.

    With e = r (a cos t, b sin t), r²/2 exponential and t uniform, a circle of radius R holds the
    mean over t of 1 - exp(-R² / 2 (a² cos² t + b² sin² t)).
    """
    _checked(level)
    small, large = np.maximum(np.linalg.eigvalsh(covariance), 0.0)
    turn = (np.arange(ANGLES) + 0.5) * np.pi / 2 / ANGLES
    seen = large * np.cos(turn) ** 2 + small * np.sin(turn) ** 2
    if not large > 0.0:
        return 0.0
    high = float(np.sqrt(-2.0 * large * np.log1p(-level)))  # of a round one that is as wide
    low = 0.0
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        if np.mean(-np.expm1(-(middle**2) / (2 * seen))) < level:
            low = middle
        else:
            high = middle
    return high


def _checked(level: float) -> float:
    check_range("level", level, 1e-3, 1 - 1e-6, "the chance that the truth lies inside")
    return level
