"""Whether two contacts became one, or one became two: force and its first moments are conserved."""

from dataclasses import dataclass

import numpy as np

from skinfield.contacts.tracking.habits import Habits
from skinfield.contacts.tracking.track import Absorbed, Seen, Track
from skinfield.errors import Floats

FORCE_FLOOR = 0.15  # part of a force: what solvers do not state of it
LIMIT = 21.1  # squared distance of three numbers that is exceeded with a chance of 1e-4
NARROW = 3e-3  # m: bodies whose ways come nearer than this cannot pass each other


@dataclass(frozen=True, eq=False)
class Load:
    """Place and force (3,), m and N, with their covariance (3, 3)."""

    value: Floats
    covariance: Floats


def load_of(one: Track | Seen) -> Load:
    """What is foretold of a track, or what is seen."""
    if isinstance(one, Track):
        return Load(one.mean[:3], one.covariance[:3, :3])
    return Load(one.value, one.noise)


def together(one: Load, other: Load) -> Load:
    """Sum of two loads, at their centre; the covariance to first order."""
    # a force below its own uncertainty says nothing of where the centre is
    forces = np.array(
        [max(float(each.value[2]), each.covariance[2, 2] ** 0.5) for each in (one, other)]
    )
    total = float(forces.sum())
    share = forces / total
    apart = one.value[:2] - other.value[:2]
    value = np.array(
        [*(share[0] * one.value[:2] + share[1] * other.value[:2]), one.value[2] + other.value[2]]
    )
    moves = np.zeros((3, 6))
    for index, (mine, theirs, sign) in enumerate(((0, 1, 1.0), (1, 0, -1.0))):
        first = 3 * index
        moves[0, first] = moves[1, first + 1] = share[mine]
        moves[:2, first + 2] = sign * apart * share[theirs] / total
        moves[2, first + 2] = 1.0
    both = np.zeros((6, 6))
    both[:3, :3], both[3:, 3:] = one.covariance, other.covariance
    return Load(value, moves @ both @ moves.T)


def misfit(one: Load, other: Load, floor: float) -> tuple[float, float]:
    """Squared distance of two loads, and twice the negative logarithm of its density.

    `floor` m is added to the standard deviation of the place, and a share of the force to its own.
    """
    spread = one.covariance + other.covariance
    force = FORCE_FLOOR * max(one.value[2], other.value[2])
    spread = spread + np.diag([floor**2, floor**2, force**2])
    off = one.value - other.value
    distance = float(off @ np.linalg.solve(spread, off))
    return distance, distance + float(np.linalg.slogdet(spread)[1])


def apart(one: Load, other: Load) -> float:
    """Distance of two loads, m."""
    return float(np.hypot(*(one.value[:2] - other.value[:2])))


def merged_score(stays: Track, goes: Track, seen: Seen, habits: Habits) -> float | None:
    """How badly `seen` fits both tracks as one contact; None if it is not that.

    Either one of them may go on alone: then what is seen fits it better than both.
    """
    one, other, found = load_of(stays), load_of(goes), load_of(seen)
    if apart(one, other) > habits.near:
        return None
    floor = habits.gate.floor
    distance, score = misfit(together(one, other), found, floor)
    alone = min(misfit(each, found, floor)[1] for each in (one, other))
    return score if distance < LIMIT and score < alone else None


def split_score(whole: Track, half: Seen, other: Seen, habits: Habits) -> float | None:
    """How badly two contacts fit one track; None if one of them is a contact by itself.

    Of a track that absorbed another shortly before, two contacts nearby are taken for both.
    """
    parts = load_of(half), load_of(other)
    before, floor = load_of(whole), habits.gate.floor
    distance, score = misfit(before, together(*parts), floor)
    if max(apart(before, part) for part in parts) > habits.near:
        return None
    if whole.absorbed:
        return score
    if apart(*parts) > habits.near:
        return None
    alone = min(misfit(before, part, floor)[1] for part in parts)
    return score if distance < LIMIT and score < alone else None


def absorbed(goes: Track, stays: Track, now: float) -> Absorbed:
    """What is remembered of a track that merges into another."""
    both = goes.covariance + stays.covariance
    forces = np.array([goes.mean[2], stays.mean[2]])
    variance = float(np.trace(both[:2, :2])) / 2, float(np.trace(both[3:5, 3:5])) / 2
    return Absorbed(goes.known, now, goes.mean - stays.mean, forces, variance)


def is_exchanged(memory: Absorbed, stays: Track, child: Track, habits: Habits) -> bool:
    """Whether after a split the child is the one that had stayed, and the other one came back.

    The distance of both is carried on from when they merged. Solid bodies do not pass through each
    other: those whose ways would have met turned back, and kept their sides.
    """
    span = child.time - memory.time
    distance, rate = memory.apart[:2], memory.apart[3:5]
    speed = float(np.hypot(*rate))
    clear = abs(distance[0] * rate[1] - distance[1] * rate[0]) > NARROW * speed
    expected = distance + span * rate if clear else distance
    pushes = habits.motion.pushes
    variance = memory.variance[0] + span**2 * memory.variance[1] + 2 * pushes[0] * span**3 / 3
    found = child.mean[:2] - stays.mean[:2]
    favour = 2.0 * float(found @ expected) / (variance + habits.gate.floor**2)
    gone, stayed = memory.forces
    unsure = (FORCE_FLOOR * (gone + stayed)) ** 2 + pushes[2] * span**3 / 3
    unsure += child.covariance[2, 2] + stays.covariance[2, 2]
    favour += float((child.mean[2] - stays.mean[2]) * (gone - stayed) / unsure)
    return bool(favour < 0.0)
