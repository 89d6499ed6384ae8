"""What is pressed when: the programme of a recording, and the loads that it makes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, Ints
from skinfield.mechanics import Viscoelastic
from skinfield.simulate.rig.ladder import Ladder
from skinfield.simulate.rig.places import Pose
from skinfield.simulate.rig.profile import Profile
from skinfield.simulate.rig.scenario import Loads

STEP = 2e-3  # s, of the series
FORGOTTEN = 25.0  # retardation times after which a press is over: exp(-25) is 1e-11


@dataclass(frozen=True, eq=False)
class Programme:
    """Presses of a recording: every load at every pose.

    Attributes
    ----------
    poses : tuple of Pose
        Distinct ones.
    pose, load : (P,) int arrays
        Of each press.
    profile : Profile
    """

    poses: tuple[Pose, ...]
    pose: Ints
    load: Ints
    profile: Profile

    @property
    def start(self) -> Floats:
        """When each press comes down, (P,) s."""
        return self.profile.starts(len(self.pose))

    @property
    def time(self) -> Floats:
        """Of the series, (S,) s."""
        duration = self.profile.duration(len(self.pose))
        steps = int(np.floor(duration / STEP + 1e-9))
        return np.asarray(STEP * np.arange(steps + 1), dtype=np.float64)

    def under_way(self, time: Floats) -> Ints:
        """Row of the press at times (S,), -1 before the first and after the last."""
        row = np.floor((time - self.profile.rest) / self.profile.period + 1e-9).astype(np.int64)
        return np.where((row < 0) | (row >= len(self.pose)), -1, row)


def programme(poses: Sequence[Pose], loads: Loads, profile: Profile) -> Programme:
    """Every load at every pose, in order."""
    distinct = tuple(dict.fromkeys(poses))
    rows = np.array([distinct.index(pose) for pose in poses])
    count = len(loads)
    return Programme(
        distinct,
        np.repeat(rows, count).astype(np.int64),
        np.tile(np.arange(count), len(poses)).astype(np.int64),
        profile,
    )


@dataclass(frozen=True, eq=False)
class Pressed:
    """Loads at one pose while it matters: samples `window` of the series.

    `force` is that into the skin, `effective` that of the elastic solution, (W,) N.
    """

    pose: int
    window: slice
    force: Floats
    effective: Floats


def pressed(
    plan: Programme, loads: Loads, ladder: Ladder, elastomer: Viscoelastic
) -> Iterator[Pressed]:
    """Loads at each pose; what is left of a press fades under the next one at the same place."""
    time, profile = plan.time, plan.profile
    fades = FORGOTTEN * max((late for _, late in elastomer.retardation), default=0.0)
    amount = np.array(loads.forces or loads.depths)
    for pose in range(len(plan.poses)):
        starts, heights = plan.start[plan.pose == pose], amount[plan.load[plan.pose == pose]]
        first = int(np.searchsorted(time, starts[0]))
        last = int(np.searchsorted(time, starts[-1] + profile.period + fades, side="right"))
        own = time[first:last]
        commanded = np.zeros(len(own))
        for start, height in zip(starts, heights, strict=True):
            part = slice(*np.searchsorted(own, [start, start + profile.period]))
            commanded[part] += height * profile.load(own[part] - start)
        if loads.forces:
            force = commanded
        else:  # the skin is left behind where it would have to pull
            force = np.maximum(elastomer.relaxing_force(own, ladder.force_at(commanded)), 0.0)
            force[commanded <= 0.0] = 0.0
        effective = np.maximum(elastomer.effective_force(own, force), 0.0)
        yield Pressed(pose, slice(first, last), force, effective)
