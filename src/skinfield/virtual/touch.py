"""Presses over time."""

from dataclasses import dataclass, field
from itertools import pairwise

from skinfield.errors import InputError, check_positive
from skinfield.virtual.tool import Tool


@dataclass(frozen=True)
class Point:
    """Where and how hard a track presses at a moment.

    Parameters
    ----------
    time : float, s
        Since the scene began.
    x, y : float, m
        In the patch's plane.
    force : float, N
        0: lifted off.
    """

    time: float
    x: float
    y: float
    force: float


@dataclass(frozen=True)
class Track:
    """One body on one patch: straight lines between points in time.

    Parameters
    ----------
    patch : int
    tool : Tool
    points : tuple of Point
        In the order of time; before the first and behind the last nothing presses.
    """

    patch: int
    tool: Tool
    points: tuple[Point, ...]

    def __post_init__(self) -> None:
        if len(self.points) < 2:
            raise InputError(f"points has {len(self.points)}, expected two or more")
        for before, after in pairwise(self.points):
            if not before.time <= after.time:
                raise InputError(f"time {after.time} follows {before.time}, expected none earlier")

    @property
    def highest(self) -> float:
        """Largest force, N."""
        return max(point.force for point in self.points)

    def at(self, time: float) -> tuple[float, float, float] | None:
        """Place, m, and force, N, at a time; None where nothing presses."""
        points = self.points
        if not points[0].time <= time <= points[-1].time:
            return None
        for before, after in pairwise(points):
            if time <= after.time:
                span = after.time - before.time
                part = (time - before.time) / span if span > 0.0 else 1.0
                force = before.force + part * (after.force - before.force)
                if force <= 0.0:
                    return None
                x = before.x + part * (after.x - before.x)
                return x, before.y + part * (after.y - before.y), force
        return None


@dataclass(frozen=True)
class Scene:
    """Tracks, once or over and over.

    Parameters
    ----------
    name : str
    tracks : tuple of Track
    period : float, s
        After which it begins again; infinite: it is played once.
    """

    name: str
    tracks: tuple[Track, ...] = ()
    period: float = field(default=float("inf"))

    def __post_init__(self) -> None:
        if self.period != float("inf"):
            check_positive("period", self.period, "of the scene, in seconds")

    @property
    def tools(self) -> dict[tuple[int, Tool], float]:
        """Largest force, N, of each tool on each patch."""
        found: dict[tuple[int, Tool], float] = {}
        for track in self.tracks:
            key = (track.patch, track.tool)
            found[key] = max(found.get(key, 0.0), track.highest)
        return found


@dataclass
class Touch:
    """One press as it is now.

    Attributes
    ----------
    id : str
    patch : int
    tool : Tool
    x, y : float, m
    force : float, N
    """

    id: str
    patch: int
    tool: Tool
    x: float
    y: float
    force: float
