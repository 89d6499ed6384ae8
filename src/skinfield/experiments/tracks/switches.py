"""Which ball each contact belongs to, and how often a ball's number changes."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.contacts import TrackedContact
from skinfield.errors import Floats
from skinfield.fields import Contact


@dataclass(frozen=True, eq=False)
class Hit:
    """A contact that belongs to a ball.

    Parameters
    ----------
    index : int
        Of the reading.
    ball, number : int
    contact : Contact
    off : (2,) array, m
        From the ball to the contact.
    force : float, N
        True.
    """

    index: int
    ball: int
    number: int
    contact: Contact
    off: Floats
    force: float


@dataclass
class Steps:
    """What is known of one way to number contacts, reading by reading."""

    hits: list[Hit] = field(default_factory=list)
    others: list[tuple[int, int, Contact]] = field(default_factory=list)
    last: dict[int, int] = field(default_factory=dict)
    missed: int = 0
    readings: int = 0

    def add(
        self,
        balls: NDArray[np.int64],
        places: Floats,
        forces: Floats,
        gate: float,
        found: Sequence[tuple[int, Contact]],
    ) -> None:
        """Take up a reading: balls (B,) at places (B, 2) m, and contacts with their numbers.

        A ball keeps the number that it had while that contact is nearer than `gate` m; the others
        go with at most one contact each, as many as there are, and then the nearest.
        """
        index, self.readings = self.readings, self.readings + 1
        taken: set[int] = set()
        if len(balls) and found:
            seen = np.array([contact.position[:2] for _, contact in found])
            away = np.linalg.norm(places[:, None] - seen[None], axis=2)
            for row, column in self._pairs(balls, away, [number for number, _ in found], gate):
                number, contact = found[column]
                off, force, ball = seen[column] - places[row], float(forces[row]), int(balls[row])
                self.hits.append(Hit(index, ball, number, contact, off, force))
                self.last[ball] = number
                taken.add(column)
        self.missed += len(balls) - len(taken)
        for at, (number, contact) in enumerate(found):
            if at not in taken:
                self.others.append((index, number, contact))

    def _pairs(
        self, balls: NDArray[np.int64], away: Floats, numbers: Sequence[int], gate: float
    ) -> list[tuple[int, int]]:
        from scipy.optimize import linear_sum_assignment

        beyond = gate * (min(away.shape) + 2)
        cost = np.where(away <= gate, away, beyond)
        for row, ball in enumerate(balls.tolist()):
            last = self.last.get(ball)
            if last in numbers and away[row, numbers.index(last)] <= gate:
                cost[row, numbers.index(last)] = -beyond  # whatever else is nearer
        rows, columns = linear_sum_assignment(cost)
        pairs = zip(rows.tolist(), columns.tolist(), strict=True)
        return [(row, column) for row, column in pairs if away[row, column] <= gate]

    def as_lines(self) -> dict[str, list[list[float]]]:
        """For each number its readings: index, x and y in mm, force in N."""
        lines: dict[str, list[list[float]]] = defaultdict(list)
        every = [(hit.index, hit.number, hit.contact) for hit in self.hits]
        for index, number, contact in sorted([*every, *self.others], key=lambda one: one[0]):
            x, y = (1e3 * contact.position[:2]).round(3).tolist()
            lines[str(number)].append([index, x, y, round(contact.normal_force, 4)])
        return dict(lines)


@dataclass(frozen=True)
class Switches:
    """Counts of one run, after CLEAR MOT (Bernardin and Stiefelhagen 2008).

    Parameters
    ----------
    switches : int
        Readings in which a ball has another number than when it was seen last.
    whole : int
        Balls that have one number from the first to the last.
    missed, false : int
        Balls without a contact, and contacts without a ball, summed over the readings.
    coasting : int
        Contacts without a ball that are foretold and not seen; they are not among the false.
    """

    switches: int
    whole: int
    missed: int
    false: int
    coasting: int

    @classmethod
    def of(cls, steps: Steps) -> "Switches":
        """Count them."""
        numbers: dict[int, list[int]] = defaultdict(list)
        for hit in steps.hits:
            numbers[hit.ball].append(hit.number)
        changes = {ball: sum(a != b for a, b in pairwise(each)) for ball, each in numbers.items()}
        whole = sum(count == 0 for count in changes.values())
        others = [contact for *_, contact in steps.others]
        coasting = sum(isinstance(one, TrackedContact) and one.is_coasting for one in others)
        switches = sum(changes.values())
        return cls(switches, whole, steps.missed, len(others) - coasting, coasting)


def added(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Rows of several runs as one: numbers are summed, lists joined, events summed by kind."""
    total: dict[str, Any] = {}
    for key, first in rows[0].items():
        if isinstance(first, str):
            total[key] = first
        elif isinstance(first, list):
            total[key] = [value for row in rows for value in row[key]]
        elif isinstance(first, dict):
            total[key] = {kind: sum(row[key][kind] for row in rows) for kind in first}
        else:
            total[key] = sum(row[key] for row in rows)
    return total
