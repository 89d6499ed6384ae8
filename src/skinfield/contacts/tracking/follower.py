"""The tracks of one patch: what happens to them from one reading to the next."""

import math
from collections.abc import Iterable

import numpy as np

from skinfield.contacts.tracking.assignment import assigned
from skinfield.contacts.tracking.habits import Habits
from skinfield.contacts.tracking.joined import (
    absorbed,
    is_exchanged,
    merged_score,
    split_score,
)
from skinfield.contacts.tracking.track import Identity, Seen, Track

Told = tuple[str, tuple[Track, ...], tuple[int, ...]]  # kind, tracks (the first has the place), ids
ROUNDING = 1e-9  # s: of times that are compared


class Follower:
    """Tracks of one patch in its developed plane.

    Attributes
    ----------
    tracks : list of Track
        All, also those that are not confirmed yet.
    told : list of Told
        What happened in the last step.
    now : float, s
    next_number : int
        That the next contact gets.
    """

    def __init__(self, habits: Habits, next_number: int = 0) -> None:
        self.habits, self.now = habits, 0.0
        self.tracks: list[Track] = []
        self.told: list[Told] = []
        self.next_number = next_number

    def step(self, seen: list[Seen], step: float) -> None:
        """Go on by `step` s to a reading in which contacts are seen.

        Their order does not matter: they are sorted here.
        """
        self.now += step
        self.told = []
        if step > max(self.habits.memory, self.habits.period):  # nobody knows what happened between
            self._lose(self.tracks)
        seen = sorted(seen, key=lambda one: (-one.value[2], *one.value[:2].tolist()))
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

    def _merge(self, pairs: dict[Track, int], free: set[int], seen: list[Seen]) -> None:
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

    def _absorb(self, one: Track, other: Track, seen: Seen) -> None:
        """The stronger keeps its number, and begins anew where both are seen."""
        stays, goes = (one, other) if one.mean[2] > other.mean[2] else (other, one)
        forces = np.maximum([stays.mean[2], goes.mean[2]], 1e-9)
        rates = np.array([*(forces @ [stays.mean[3:5], goes.mean[3:5]] / forces.sum()), 0.0])
        stays.absorbed += [absorbed(goes, stays, self.now), *goes.absorbed]
        stays.restart(seen, self.now, rates)
        self.tracks.remove(goes)
        self.told.append(("merged", (stays,), (stays.known.number, goes.known.number)))

    def _split(self, pairs: dict[Track, int], free: set[int], seen: list[Seen]) -> None:
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
        seen: list[Seen],
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
        gone = [
            track
            for track in self.tracks
            if self.now > track.time
            and (not track.is_confirmed or self.now - track.time > patience)
        ]
        self._lose(gone)

    def _lose(self, gone: Iterable[Track]) -> None:
        gone = list(gone)
        self.tracks = [track for track in self.tracks if track not in gone]
        for track in gone:
            if track.identity is not None:
                self.told.append(("lost", (track,), (track.identity.number,)))

    def _confirm(self, track: Track) -> None:
        """A strong contact at once; a weak one, and a part of another, when it was seen again."""
        force, std = track.seen.value[2], math.sqrt(track.seen.noise[2, 2])
        strong = force >= self.habits.strong * std and track.parent is None
        if not strong and track.readings < self.habits.weak_readings:
            return
        parent, track.parent = track.parent, None
        if parent is None or parent not in self.tracks or parent.identity is None:
            track.identity = self._identity(track)
            self.told.append(("made", (track,), (track.identity.number,)))
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
        self.told.append(("split", (parent, track), numbers))

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
            self.told.append(("moved", (track,), (identity.number,)))
        identity.slips = moves
        if moves:
            identity.slipped = self.now
