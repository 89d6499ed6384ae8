"""Multi-target tracking: Kalman filters, their assignment to contacts, merging and splitting."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats
from skinfield.estimate.contact import Contact
from skinfield.estimate.tracked import Gate, Motion


@dataclass(frozen=True, eq=False)
class Load:
    """Place and force (3,), m in the developed plane and N, with their covariance (3, 3)."""

    value: Floats
    noise: Floats


@dataclass(frozen=True, eq=False)
class Measurement(Load):
    """A contact of one reading."""

    contact: Contact


@dataclass
class Identity:
    """What goes with a contact when tracks are exchanged: number, and times in s."""

    number: int
    made: float
    slipped: float
    slips: bool = False


@dataclass(frozen=True, eq=False)
class Absorbed:
    """A contact that merged into another: both as they were at that time.

    Attributes
    ----------
    identity : Identity
    time : float, s
    apart : (6,) array
        State of the absorbed one less that of the one that stayed.
    forces : (2,) array, N
        Of the absorbed one, and of the one that stayed.
    variance : float, m² and m²/s²
        Of the distance, and of its rate, on each axis.
    """

    identity: Identity
    time: float
    apart: Floats
    forces: Floats
    variance: tuple[float, float]


class Track:
    """One contact through time.

    Attributes
    ----------
    mean, covariance : (6,) and (6, 6) arrays
        x and y m in the developed plane, normal force N, and their rates per s.
    identity : Identity or None
        None until it is confirmed.
    seen : Measurement
        What was seen of it last.
    time : float, s
        When that was.
    readings : int
        In which it was seen.
    first : float, s
        When it was seen first.
    absorbed : list of Absorbed
    parent : Track or None
        From which it split, until it is confirmed.
    """

    def __init__(self, motion: Motion, seen: Measurement, now: float) -> None:
        self._motion = motion
        self.mean, self.covariance = np.zeros(6), np.zeros((6, 6))
        self.identity: Identity | None = None
        self.absorbed: list[Absorbed] = []
        self.parent: Track | None = None
        self.readings, self.first = 0, now
        self.restart(seen, now, np.zeros(3))

    @property
    def is_confirmed(self) -> bool:
        """Whether it is told."""
        return self.identity is not None

    @property
    def known(self) -> Identity:
        """Identity of a track that is confirmed."""
        if self.identity is None:
            raise AssertionError("only confirmed tracks are told, merge and split")
        return self.identity

    @property
    def load(self) -> Load:
        """What is foretold of it."""
        return Load(self.mean[:3], self.covariance[:3, :3])

    def restart(self, seen: Measurement, now: float, rates: Floats) -> None:
        """Begin anew at what is seen, with rates (3,) of which little is known."""
        self.mean[:3], self.mean[3:] = seen.value, rates
        self.covariance[:] = 0.0
        self.covariance[:3, :3] = seen.noise
        self.covariance[range(3, 6), range(3, 6)] = self._motion.first_rates
        self._saw(seen, now)

    def predict(self, step: float) -> None:
        """Carry on by `step` s; a force does not become a pull.

        The rates are driven by white noise.
        """
        onwards = np.eye(6) + step * np.eye(6, k=3)
        self.mean = onwards @ self.mean
        self.covariance = onwards @ self.covariance @ onwards.T
        self._push(self._motion.pushes, step**3 / 3, step**2 / 2, step)
        if self.mean[2] < 0.0:
            self.mean[2] = self.mean[5] = 0.0

    def update(self, seen: Measurement, now: float) -> None:
        """Take up what is seen.

        Where that is a surprise, the rates may have changed at once when the track was seen last.
        """
        motion, since, off = self._motion, now - self.time, seen.value - self.mean[:3]
        precision = np.linalg.inv(self.covariance[:3, :3] + seen.noise)
        if off @ precision @ off > motion.surprise:
            self._push(motion.first_rates, since**2, since, 1.0)
            precision = np.linalg.inv(self.covariance[:3, :3] + seen.noise)
        gain = self.covariance[:, :3] @ precision
        self.mean += gain @ off
        left = self.covariance - gain @ self.covariance[:3]
        self.covariance = 0.5 * (left + left.T)
        speed = math.hypot(self.mean[3], self.mean[4])
        if speed > motion.top_speed:
            self.mean[3:5] *= motion.top_speed / speed
        self._saw(seen, now)

    def _push(self, variances: Floats, place: float, both: float, rate: float) -> None:
        """Add multiples of variances (3,) to those of place and force, and of their rates."""
        each = np.arange(3)
        for row, column, factor in ((0, 0, place), (0, 3, both), (3, 0, both), (3, 3, rate)):
            self.covariance[each + row, each + column] += factor * variances

    def _saw(self, seen: Measurement, now: float) -> None:
        self.seen, self.time = seen, now
        self.readings += 1


TENTATIVE = 3.0  # added to the cost of a track that is not confirmed yet
FORCE_SAYS = 9.0  # most that a force which does not fit adds to the cost


def assigned(tracks: Sequence[Track], seen: Sequence[Measurement], gate: Gate) -> dict[int, int]:
    """Contact of each track that has one, by their places in the sequences.

    The sum of what the pairs are worth is the highest there is (Kuhn 1955). A pair costs the
    squared Mahalanobis distance of the place and, up to a limit, that of the force, and the
    logarithm of the place's variance: of two contacts as near, the surer one goes on.
    """
    if not tracks or not seen:
        return {}
    value, noise = (np.array([getattr(one, name) for one in seen]) for name in ("value", "noise"))
    off = value - np.array([track.mean[:3] for track in tracks])[:, None]
    spread = noise + np.array([track.covariance[:3, :3] for track in tracks])[:, None]
    handicap = np.array([[0.0 if track.is_confirmed else TENTATIVE] for track in tracks])
    x, y, floor = off[..., 0], off[..., 1], gate.floor**2
    a, b, c = spread[..., 0, 0] + floor, spread[..., 0, 1], spread[..., 1, 1] + floor
    area = a * c - b * b
    distance = (c * x * x - 2 * b * x * y + a * y * y) / area
    force = np.minimum(off[..., 2] ** 2 / spread[..., 2, 2], FORCE_SAYS)
    gain = gate.distance + FORCE_SAYS + TENTATIVE - distance - force - handicap
    gain -= np.log(area / floor**2)
    gain[(distance > gate.distance) | (np.hypot(x, y) > gate.reach) | (gain < 0.0)] = 0.0
    if gain.size == 1:
        return {0: 0} if gain[0, 0] > 0.0 else {}
    from scipy.optimize import linear_sum_assignment

    rows, columns = linear_sum_assignment(gain, maximize=True)
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    return {row: column for row, column in pairs if gain[row, column] > 0.0}


FORCE_FLOOR = 0.15  # part of a force: what solvers do not state of it
LIMIT = 21.1  # squared distance of three numbers that is exceeded with a chance of 1e-4
NARROW = 3e-3  # m: bodies whose ways come nearer than this cannot pass each other


def together(one: Load, other: Load) -> Load:
    """Sum of two loads, at their centre; the covariance to first order."""
    # a force below its own uncertainty says nothing of where the centre is
    forces = np.array([max(float(each.value[2]), each.noise[2, 2] ** 0.5) for each in (one, other)])
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
    both[:3, :3], both[3:, 3:] = one.noise, other.noise
    return Load(value, moves @ both @ moves.T)


def misfit(one: Load, other: Load, floor: float) -> tuple[float, float]:
    """Squared distance of two loads, and twice the negative logarithm of its density.

    `floor` m is added to the standard deviation of the place, and a share of the force to its own.
    """
    spread = one.noise + other.noise
    force = FORCE_FLOOR * max(one.value[2], other.value[2])
    spread = spread + np.diag([floor**2, floor**2, force**2])
    off = one.value - other.value
    distance = float(off @ np.linalg.solve(spread, off))
    return distance, distance + float(np.linalg.slogdet(spread)[1])


def apart(one: Load, other: Load) -> float:
    """Distance of two loads, m."""
    return float(np.hypot(*(one.value[:2] - other.value[:2])))


def merged_score(
    stays: Track, goes: Track, seen: Measurement, near: float, floor: float
) -> float | None:
    """How badly `seen` fits both tracks as one contact; None if it is not that.

    Tracks merge within `near` m; for `floor` see `misfit`. Either one of them may go on alone: then
    what is seen fits it better than both.
    """
    one, other = stays.load, goes.load
    if apart(one, other) > near:
        return None
    distance, score = misfit(together(one, other), seen, floor)
    alone = min(misfit(each, seen, floor)[1] for each in (one, other))
    return score if distance < LIMIT and score < alone else None


def split_score(
    whole: Track, half: Measurement, other: Measurement, near: float, floor: float
) -> float | None:
    """How badly two contacts fit one track; None if one of them is a contact by itself.

    Of a track that absorbed another shortly before, two contacts nearby are taken for both.
    """
    parts = half, other
    before = whole.load
    distance, score = misfit(before, together(*parts), floor)
    if max(apart(before, part) for part in parts) > near:
        return None
    if whole.absorbed:
        return score
    if apart(*parts) > near:
        return None
    alone = min(misfit(before, part, floor)[1] for part in parts)
    return score if distance < LIMIT and score < alone else None


def absorbed(goes: Track, stays: Track, now: float) -> Absorbed:
    """What is remembered of a track that merges into another."""
    both = goes.covariance + stays.covariance
    forces = np.array([goes.mean[2], stays.mean[2]])
    variance = float(np.trace(both[:2, :2])) / 2, float(np.trace(both[3:5, 3:5])) / 2
    return Absorbed(goes.known, now, goes.mean - stays.mean, forces, variance)


def is_exchanged(
    memory: Absorbed, stays: Track, child: Track, pushes: Floats, floor: float
) -> bool:
    """Whether after a split the child is the one that had stayed, and the other one came back.

    The distance of both is carried on from when they merged, driven by `pushes` (3,). Solid bodies
    do not pass through each other: those whose ways would have met turned back, and kept their
    sides.
    """
    span = child.time - memory.time
    distance, rate = memory.apart[:2], memory.apart[3:5]
    speed = float(np.hypot(*rate))
    clear = abs(distance[0] * rate[1] - distance[1] * rate[0]) > NARROW * speed
    expected = distance + span * rate if clear else distance
    variance = memory.variance[0] + span**2 * memory.variance[1] + 2 * pushes[0] * span**3 / 3
    found = child.mean[:2] - stays.mean[:2]
    favour = 2.0 * float(found @ expected) / (variance + floor**2)
    gone, stayed = memory.forces
    unsure = (FORCE_FLOOR * (gone + stayed)) ** 2 + pushes[2] * span**3 / 3
    unsure += child.covariance[2, 2] + stays.covariance[2, 2]
    favour += float((child.mean[2] - stays.mean[2]) * (gone - stayed) / unsure)
    return bool(favour < 0.0)
