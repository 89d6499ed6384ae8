"""When boards send: absolute times, so that nothing drifts, and never two readings at once."""

from collections.abc import Hashable
from dataclasses import dataclass, field

import numpy as np

NEVER = 1 << 62
LATEST = 0.9  # of a period, that jitter can make a reading late


@dataclass
class Group:
    """Boards that send together.

    Attributes
    ----------
    members : tuple
        Their numbers.
    period_ns, phase_ns : int
    due_ns : int
        When the next reading is sent, jitter included.
    """

    members: tuple[int, ...]
    period_ns: int
    phase_ns: int
    due_ns: int = NEVER
    _grid_ns: int = 0


@dataclass
class Schedule:
    """Groups of boards with their next times.

    A reading that is late by more than a period is skipped and counted: a device that cannot keep
    up loses readings, it does not send them in a heap.

    Parameters
    ----------
    spread : bool
        Each board has a phase of its own.
    jitter : float, s
        Mean of the exponential delay.
    rng : numpy Generator

    Attributes
    ----------
    skipped : int
        Readings of boards.
    """

    spread: bool
    jitter: float
    rng: np.random.Generator
    skipped: int = 0
    groups: list[Group] = field(default_factory=list)
    _key: Hashable = None

    def set(self, periods: dict[int, int], boards: int, now_ns: int) -> None:
        """Tell which of `boards` send, with which period, ns; the others are silent."""
        key = tuple(sorted(periods.items()))
        if key == self._key:
            return
        self._key = key
        each: list[tuple[tuple[int, ...], int, int]]
        if self.spread:
            each = [((b,), p, p * b // boards) for b, p in periods.items()]
        else:
            alike: dict[int, list[int]] = {}
            for board, period in periods.items():
                alike.setdefault(period, []).append(board)
            each = [(tuple(members), period, 0) for period, members in alike.items()]
        self.groups = [Group(members, period, phase) for members, period, phase in each]
        self.begin(now_ns)

    def begin(self, now_ns: int) -> None:
        """Aim all groups at their next times, as if nothing had been due before."""
        for group in self.groups:
            self._aim(group, -(-(now_ns - group.phase_ns) // group.period_ns))

    def _aim(self, group: Group, number: int) -> None:
        group._grid_ns = number * group.period_ns + group.phase_ns
        late = self.rng.exponential(self.jitter) * 1e9 if self.jitter > 0.0 else 0.0
        group.due_ns = group._grid_ns + int(min(late, LATEST * group.period_ns))

    @property
    def next_ns(self) -> int:
        """When the next group is due."""
        return min((group.due_ns for group in self.groups), default=NEVER)

    def due(self, now_ns: int) -> list[Group]:
        """Groups to send now; each is aimed at its next time."""
        found = [group for group in self.groups if group.due_ns <= now_ns]
        for group in found:
            number = (group._grid_ns - group.phase_ns) // group.period_ns + 1
            behind = (now_ns - number * group.period_ns - group.phase_ns) // group.period_ns
            if behind > 0:
                self.skipped += behind * len(group.members)
                number += behind
            self._aim(group, number)
        return found
