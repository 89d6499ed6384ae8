"""Multi-target tracking: Kalman filters, their assignment to contacts, merging and splitting."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats
from skinfield.estimate.contact import Contact
from skinfield.estimate.ranking import falling_order
from skinfield.estimate.tracked import Gate, Motion, TrackerSettings
from skinfield.estimate.tracking_kernel import gains, predict, update


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
        """Carry on by `step` s; a force does not become a pull."""
        predict(self.mean, self.covariance, step, self._motion.pushes)
        if self.mean[2] < 0.0:
            self.mean[2] = self.mean[5] = 0.0

    def update(self, seen: Measurement, now: float) -> None:
        """Take up what is seen."""
        motion = self._motion
        update(
            self.mean,
            self.covariance,
            seen.value,
            seen.noise,
            now - self.time,
            motion.first_rates,
            motion.surprise,
        )
        speed = math.hypot(self.mean[3], self.mean[4])
        if speed > motion.top_speed:
            self.mean[3:5] *= motion.top_speed / speed
        self._saw(seen, now)

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
    limits = (gate.distance, gate.floor**2, gate.reach, FORCE_SAYS)
    gain = gains(
        np.array([track.mean for track in tracks]),
        np.array([track.covariance for track in tracks]),
        np.array([0.0 if track.is_confirmed else TENTATIVE for track in tracks]),
        np.array([one.value for one in seen]),
        np.array([one.noise for one in seen]),
        (*limits, gate.distance + FORCE_SAYS + TENTATIVE),
    )
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
    stays: Track, goes: Track, seen: Measurement, habits: TrackerSettings
) -> float | None:
    """How badly `seen` fits both tracks as one contact; None if it is not that.

    Either one of them may go on alone: then what is seen fits it better than both.
    """
    one, other = stays.load, goes.load
    if apart(one, other) > habits.near:
        return None
    floor = habits.gate.floor
    distance, score = misfit(together(one, other), seen, floor)
    alone = min(misfit(each, seen, floor)[1] for each in (one, other))
    return score if distance < LIMIT and score < alone else None


def split_score(
    whole: Track, half: Measurement, other: Measurement, habits: TrackerSettings
) -> float | None:
    """How badly two contacts fit one track; None if one of them is a contact by itself.

    Of a track that absorbed another shortly before, two contacts nearby are taken for both.
    """
    parts = half, other
    before, floor = whole.load, habits.gate.floor
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


def is_exchanged(memory: Absorbed, stays: Track, child: Track, habits: TrackerSettings) -> bool:
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


Change = tuple[
    str, tuple[Track, ...], tuple[int, ...]
]  # kind, tracks (the first has the place), ids
ROUNDING = 1e-9  # s: of times that are compared


class Follower:
    """Tracks of one patch in its developed plane.

    Attributes
    ----------
    tracks : list of Track
        All, also those that are not confirmed yet.
    changes : list of Change
        What happened in the last step.
    now : float, s
    next_number : int
        That the next contact gets.
    """

    def __init__(self, habits: TrackerSettings, next_number: int = 0) -> None:
        self.habits, self.now = habits, 0.0
        self.tracks: list[Track] = []
        self.changes: list[Change] = []
        self.next_number = next_number

    def step(self, seen: list[Measurement], step: float) -> None:
        """Go on by `step` s to a reading in which contacts are seen.

        Their order does not matter: they are sorted here.
        """
        self.now += step
        self.changes = []
        if step > max(self.habits.memory, self.habits.period):  # nobody knows what happened between
            self._lose(self.tracks.copy())
        firsts = [
            (int(one.contact.cells[0]) if len(one.contact.cells) else 0, *one.value[:2].tolist())
            for one in seen
        ]
        order = falling_order([float(one.value[2]) for one in seen], firsts)
        seen = [seen[index] for index in order]
        for track in self.tracks:
            track.predict(step)
            track.absorbed = [
                one for one in track.absorbed if self.now - one.time <= self.habits.memory
            ]
        pairs = {
            self.tracks[row]: column
            for row, column in assigned(self.tracks, seen, self.habits.gate).items()
        }
        free = set(range(len(seen))) - set(pairs.values())
        if len(pairs) < len(self.tracks):
            self._merge(pairs, free, seen)
        if free:
            self._split(pairs, free, seen)
        for track, column in pairs.items():
            track.update(seen[column], self.now)
        for column in sorted(free):
            self.tracks.append(Track(self.habits.motion, seen[column], self.now))
        self._drop_unseen()
        for track in [track for track in self.tracks if not track.is_confirmed]:
            self._confirm(track)
        for track in self.tracks:
            self._slip(track)

    def _unpaired(self, pairs: dict[Track, int]) -> list[Track]:
        return [track for track in self.tracks if track.is_confirmed and track not in pairs]

    def _open(self) -> list[Track]:
        """Confirmed tracks that did not begin anew in this step."""
        return [track for track in self.tracks if track.is_confirmed and track.time < self.now]

    def _merge(self, pairs: dict[Track, int], free: set[int], seen: list[Measurement]) -> None:
        """Tracks that are not seen, but whose force is in another's contact."""
        for goes in self._unpaired(pairs):
            best: tuple[float, Track, int] | None = None
            for stays in self._open() if goes in self._open() else []:
                if stays is goes:
                    continue
                for column in [pairs[stays]] if stays in pairs else sorted(free):
                    score = merged_score(stays, goes, seen[column], self.habits)
                    if score is not None and (best is None or score < best[0]):
                        best = score, stays, column
            if best is not None:
                _, other, column = best
                pairs.pop(other, None)
                free.discard(column)
                self._absorb(goes, other, seen[column])

    def _absorb(self, one: Track, other: Track, seen: Measurement) -> None:
        """The stronger keeps its number, and begins anew where both are seen."""
        stays, goes = (one, other) if one.mean[2] > other.mean[2] else (other, one)
        forces = np.maximum([stays.mean[2], goes.mean[2]], 1e-9)
        rates = np.array([*(forces @ [stays.mean[3:5], goes.mean[3:5]] / forces.sum()), 0.0])
        stays.absorbed += [absorbed(goes, stays, self.now), *goes.absorbed]
        stays.restart(seen, self.now, rates)
        self.tracks.remove(goes)
        self.changes.append(("merged", (stays,), (stays.known.number, goes.known.number)))

    def _split(self, pairs: dict[Track, int], free: set[int], seen: list[Measurement]) -> None:
        """Contacts without a track whose force was in another's."""
        for column in sorted(free):
            best: tuple[float, Track, int] | None = None
            for whole in self._open():
                others = [pairs[whole]] if whole in pairs else sorted(free - {column})
                for other in others if column in free else []:
                    score = split_score(whole, seen[other], seen[column], self.habits)
                    if score is not None and (best is None or score < best[0]):
                        best = score, whole, other
            if best is not None:
                self._divide(best[1], {best[2], column}, pairs, free, seen)

    def _divide(
        self,
        whole: Track,
        columns: set[int],
        pairs: dict[Track, int],
        free: set[int],
        seen: list[Measurement],
    ) -> None:
        """The nearer contact keeps the track; of two that are as near, the stronger."""
        near, far = sorted(
            columns,
            key=lambda c: (
                c != pairs.get(whole),
                round(float(np.hypot(*(seen[c].value[:2] - whole.mean[:2]))), 4),
                -seen[c].value[2],
            ),
        )
        pairs.pop(whole, None)
        free -= columns
        whole.restart(seen[near], self.now, whole.mean[3:].copy())
        child = Track(self.habits.motion, seen[far], self.now)
        child.parent = whole
        self.tracks.append(child)

    def _drop_unseen(self) -> None:
        """Tracks that coasted for too long, and unconfirmed ones at once."""
        patience = self.habits.coast + ROUNDING
        unseen = [(track, self.now - track.time) for track in self.tracks]
        self._lose([each for each, t in unseen if t > (patience if each.is_confirmed else 0.0)])

    def _lose(self, gone: Sequence[Track]) -> None:
        self.tracks = [track for track in self.tracks if track not in gone]
        for track in gone:
            if track.identity is not None:
                self.changes.append(("lost", (track,), (track.identity.number,)))

    def _confirm(self, track: Track) -> None:
        """A strong contact at once; a weak one, and a part of another, when it was seen again."""
        force, std = track.seen.value[2], math.sqrt(track.seen.noise[2, 2])
        strong = force >= self.habits.strong * std and track.parent is None
        if not strong and track.readings < self.habits.weak_readings:
            return
        parent, track.parent = track.parent, None
        if parent is None or parent not in self.tracks or parent.identity is None:
            track.identity = self._identity(track)
            self.changes.append(("made", (track,), (track.identity.number,)))
            return
        if not parent.absorbed:
            track.identity = self._identity(track)
        else:
            memory = max(parent.absorbed, key=lambda one: one.time)
            parent.absorbed.remove(memory)
            track.identity = memory.identity
            if is_exchanged(memory, parent, track, self.habits):
                track.identity, parent.identity = parent.identity, track.identity
        numbers = parent.identity.number, track.identity.number
        self.changes.append(("split", (parent, track), numbers))

    def _identity(self, track: Track) -> Identity:
        self.next_number += 1
        return Identity(self.next_number - 1, track.first, track.first)

    def _slip(self, track: Track) -> None:
        """A place moves if its speed is above the threshold beyond doubt, or has hardly slowed."""
        identity = track.identity
        if identity is None or track.time < self.now:
            return
        x, y = track.mean[3:5].tolist()
        speed = math.hypot(x, y)
        if speed <= self.habits.slip_speed:
            identity.slips = False
            return
        (a, b), (_, c) = track.covariance[3:5, 3:5].tolist()
        std = math.sqrt(a * x * x + 2.0 * b * x * y + c * y * y) / speed
        sigmas = 1.0 if identity.slips else self.habits.slip_sigmas
        moves = speed - sigmas * std > self.habits.slip_speed
        if moves and not identity.slips:
            self.changes.append(("moved", (track,), (identity.number,)))
        identity.slips = moves
        if moves:
            identity.slipped = self.now
