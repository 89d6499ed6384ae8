"""Numbers of fitted contacts: those of the engine's contacts, for as long as they last."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.contacts.live import Habits

NEAR = 10e-3  # m from a contact of the engine, whose place is less sure
FIRST = 1_000_000  # number of the first contact that only the fit knows
HABITS = Habits(hold=0.5)
Rows = NDArray[np.void]


@dataclass(frozen=True)
class Known:
    """A contact of before.

    Attributes
    ----------
    track : int
    x, y : float, m
    speed : float, m/s
    first_ns, last_ns : int, ns
    """

    track: int
    x: float
    y: float
    speed: float
    first_ns: int
    last_ns: int


class Numbers:
    """Numbers for contacts that the engine has none for, of all patches."""

    def __init__(self) -> None:
        self._next = FIRST

    def new(self) -> int:
        """Another one: far above those of the engine, which count from 1."""
        self._next += 1
        return self._next - 1


class FitTracks:
    """Contacts of one patch, fit after fit.

    A contact that goes on keeps its number. A new one takes that of the engine's nearest contact
    that no other has; where there is none, a number of its own.

    Parameters
    ----------
    numbers : Numbers
    """

    def __init__(self, numbers: Numbers) -> None:
        self._numbers = numbers
        self._known: list[Known] = []

    def reset(self) -> None:
        """Forget the contacts of before."""
        self._known = []

    def number(self, rows: Rows, engine: Rows, stamp_ns: int) -> None:
        """Write `track`, `age` and `speed` into the rows of a fit.

        Parameters
        ----------
        rows, engine : arrays of CONTACT
            Of this patch alone.
        stamp_ns : int, ns
            Of the reading.
        """
        hold = int(HABITS.hold * 1e9)
        known = [each for each in self._known if 0 <= stamp_ns - each.last_ns <= hold]
        places = np.array([[each.x, each.y] for each in known]).reshape(-1, 2)
        since = np.array([(stamp_ns - each.last_ns) * 1e-9 for each in known])
        reach = HABITS.reach + HABITS.speed * since
        before = pairs(_places(rows), places, reach)
        taken = {known[at].track for at in before.values()}
        free = engine[~np.isin(engine["track"], list(taken))]
        fresh = [at for at in range(len(rows)) if at not in before]
        reach = np.full(len(free), NEAR)
        found = pairs(_places(rows[fresh]), _places(free), reach)
        self._known = []
        for at in range(len(rows)):
            row = rows[at]
            if at in before:
                now = _gone_on(known[before[at]], row, stamp_ns)
            elif (place := fresh.index(at)) in found:
                own = free[found[place]]
                first = stamp_ns - int(max(float(own["age"]), 0.0) * 1e9)
                now = Known(int(own["track"]), row["x"], row["y"], 0.0, first, stamp_ns)
            else:
                new = self._numbers.new()
                now = Known(new, row["x"], row["y"], 0.0, stamp_ns, stamp_ns)
            row["track"], row["speed"] = now.track, now.speed
            row["age"] = (stamp_ns - now.first_ns) * 1e-9
            self._known.append(now)


def _places(rows: Rows) -> NDArray[np.float64]:
    return np.column_stack([rows["x"], rows["y"]]).reshape(-1, 2)


def _gone_on(before: Known, row: np.void, stamp_ns: int) -> Known:
    seconds = (stamp_ns - before.last_ns) * 1e-9
    speed = before.speed
    if seconds > 0:
        now = float(np.hypot(row["x"] - before.x, row["y"] - before.y)) / seconds
        speed += (now - speed) * (1.0 - float(np.exp(-seconds / HABITS.smoothing)))
    return Known(before.track, row["x"], row["y"], speed, before.first_ns, stamp_ns)


def pairs(
    rows: NDArray[np.float64], others: NDArray[np.float64], reach: NDArray[np.float64]
) -> dict[int, int]:
    """Pairs of places (N, 2) and others (M, 2), the nearest first, each within its reach (M,)."""
    apart = np.hypot(*(rows[:, None] - others[None]).transpose(2, 0, 1))
    apart[apart > reach] = np.inf
    found: dict[int, int] = {}
    while apart.size and np.isfinite(apart.min()):
        row, other = np.unravel_index(int(np.argmin(apart)), apart.shape)
        found[int(row)] = int(other)
        apart[row], apart[:, other] = np.inf, np.inf
    return found
