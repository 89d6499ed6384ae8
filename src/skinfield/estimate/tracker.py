"""Contacts over time: stable numbers, filtered place and force, and what happened."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skinfield.errors import InputError, check_count, check_positive, check_range, check_type
from skinfield.estimate.developed_plane import Chart, contacts_of, measurements_of
from skinfield.estimate.estimate import Estimate
from skinfield.estimate.ranking import falling_order
from skinfield.estimate.tracked import ContactEvent, EventKind, Gate, Motion, TrackedContact
from skinfield.estimate.tracks import (
    Identity,
    Measurement,
    Track,
    absorbed,
    assigned,
    is_exchanged,
    merged_score,
    split_score,
)

Change = tuple[EventKind, Track, tuple[int, ...]]  # kind, track that has the place, ids
ROUNDING = 1e-9  # s: of times that are compared


@dataclass(eq=False, kw_only=True)
class Tracker:
    """Follows the contacts of one patch; call it with each estimate in turn.

    Each contact is followed by a Kalman filter of place, force and their rates. Contacts go on
    with the tracks that fit best as a whole. A track that is not seen coasts for a while before it
    is lost. Where force and its first moments are conserved, two contacts that become one merge,
    and one that becomes two splits; after that, an absorbed contact comes back under its number.

    Parameters
    ----------
    period : float, s
        Between readings, where estimates have no `stamp_ns`.
    motion : Motion, optional
        How contacts move and forces change.
    gate : Gate, optional
        How far from what is foretold a contact may be.
    coast : float, s
        For which a contact may be unseen before it is lost.
    strong : float
        A contact whose force is above so many of its standard deviations is told at once,
    weak_readings : int
        any other when so many readings in a row have seen it, and so is one that splits from
        another. 1 tells all at once.
    near : float, m
        Contacts farther from each other neither merge nor split.
    memory : float, s
        For which an absorbed contact is remembered. All tracks are lost if there is no reading
        for longer than this.
    slip_speed : float, m/s
        A contact moves if its place does so faster than this,
    slip_sigmas : float
        by so many standard deviations of the speed.

    Attributes
    ----------
    events : tuple of ContactEvent
        Of the last call, in the order of time.
    """

    period: float = 0.02
    motion: Motion = field(default_factory=Motion)
    gate: Gate = field(default_factory=Gate)
    coast: float = 0.1
    strong: float = 5.0
    weak_readings: int = 2
    near: float = 12e-3
    memory: float = 1.0
    slip_speed: float = 5e-3
    slip_sigmas: float = 3.0

    def __post_init__(self) -> None:
        check_positive("period", self.period, "seconds between readings without stamps")
        check_range("coast", self.coast, 0.0, 1e6, "seconds for which a contact may be unseen")
        check_range("strong", self.strong, 0.0, 1e6, "standard deviations of the force")
        check_positive("near", self.near, "farthest distance of contacts that merge, in metres")
        check_positive("memory", self.memory, "seconds for which merged contacts are known")
        check_positive("slip_speed", self.slip_speed, "from which on a contact slips, in m/s")
        check_range("slip_sigmas", self.slip_sigmas, 0.0, 1e6, "standard deviations of the speed")
        check_count("weak_readings", self.weak_readings, 1, 1000, "in a row, before a weak contact")
        check_type("motion", self.motion, Motion, "how contacts move")
        check_type("gate", self.gate, Gate, "how far from what is foretold a contact may be")
        self._chart: Chart | None = None
        self._next_number = 0
        self.events: tuple[ContactEvent, ...] = ()
        self.reset()

    def __call__(self, estimate: Estimate) -> tuple[Any, ...]:
        """Contacts of an estimate as they go on from those before.

        Parameters
        ----------
        estimate : Estimate
            Later than those before, and of the same patch.

        Returns
        -------
        tuple of TrackedContact
            Of confirmed tracks, by falling force; those that coast are among them. For an estimate
            of T readings, T such tuples.

        Raises
        ------
        InputError
            For what is no estimate, an estimate of another patch, one that is not later than the
            one before, or a contact whose covariance is not one.
        """
        check_type("estimate", estimate, Estimate, "what a Reconstructor returns for readings")
        if not estimate.is_batch:
            found, self.events = self._follow(estimate)
            return found
        both = [self._follow(each) for each in estimate]
        self.events = tuple(event for _, events in both for event in events)
        return tuple(found for found, _ in both)

    def reset(self) -> None:
        """Forget all contacts; numbers go on, so that none is given twice."""
        self._tracks: list[Track] = []  # in the plane; also those that are not confirmed yet
        self._changes: list[Change] = []  # of the last step
        self._now, self._stamp, self._started = 0.0, 0, False
        self.events = ()

    def _follow(
        self, estimate: Estimate
    ) -> tuple[tuple[TrackedContact, ...], tuple[ContactEvent, ...]]:
        chart, stamp = self._chart_of(estimate), int(estimate.stamp_ns)
        seen = measurements_of(estimate.contacts, chart)
        self._step(seen, self._step_to(stamp))
        self._stamp, self._started = stamp, True
        tracks = [track for track in self._tracks if track.is_confirmed]
        everyone = list(dict.fromkeys([*tracks, *(track for _, track, _ in self._changes)]))
        contacts = dict(zip(everyone, contacts_of(everyone, chart, self._now), strict=True))
        events = tuple(
            ContactEvent(
                kind=kind,
                stamp_ns=stamp,
                time=self._now,
                ids=ids,
                position=contacts[track].position,
            )
            for kind, track, ids in self._changes
        )
        forces = [float(track.mean[2]) for track in tracks]
        order = falling_order(forces, [track.known.number for track in tracks])
        return tuple(contacts[tracks[index]] for index in order), events

    def _step_to(self, stamp: int) -> float:
        """Seconds since the reading before."""
        if not self._started:
            return 0.0
        if not stamp or not self._stamp:
            return self.period
        if stamp <= self._stamp:
            raise InputError(
                f"stamp_ns is {stamp}, expected after {self._stamp}, that of the reading before: "
                "hand in readings in the order of time, or call reset() for another recording"
            )
        return (stamp - self._stamp) * 1e-9

    def _chart_of(self, estimate: Estimate) -> Chart:
        patch = estimate.grid.patch
        if self._chart is None:
            self._chart = Chart(estimate.grid)
        elif self._chart.patch is not patch and not np.array_equal(
            self._chart.patch.positions, patch.positions
        ):
            raise InputError(
                f"the estimate is of patch {patch.name!r}, expected {self._chart.patch.name!r} as "
                "before: take a tracker for each patch"
            )
        return self._chart

    def _step(self, seen: list[Measurement], step: float) -> None:
        """Go on by `step` s to a reading in which contacts are seen.

        Their order does not matter: they are sorted here.
        """
        self._now += step
        self._changes = []
        if step > max(self.memory, self.period):  # nobody knows what happened between
            self._lose(self._tracks.copy())
        firsts = [
            (int(one.contact.cells[0]) if len(one.contact.cells) else 0, *one.value[:2].tolist())
            for one in seen
        ]
        order = falling_order([float(one.value[2]) for one in seen], firsts)
        seen = [seen[index] for index in order]
        for track in self._tracks:
            track.predict(step)
            track.absorbed = [one for one in track.absorbed if self._now - one.time <= self.memory]
        pairs = {
            self._tracks[row]: column
            for row, column in assigned(self._tracks, seen, self.gate).items()
        }
        free = set(range(len(seen))) - set(pairs.values())
        if len(pairs) < len(self._tracks):
            self._merge(pairs, free, seen)
        if free:
            self._split(pairs, free, seen)
        for track, column in pairs.items():
            track.update(seen[column], self._now)
        for column in sorted(free):
            self._tracks.append(Track(self.motion, seen[column], self._now))
        self._drop_unseen()
        for track in [track for track in self._tracks if not track.is_confirmed]:
            self._confirm(track)
        for track in self._tracks:
            self._slip(track)

    def _unpaired(self, pairs: dict[Track, int]) -> list[Track]:
        return [track for track in self._tracks if track.is_confirmed and track not in pairs]

    def _open(self) -> list[Track]:
        """Confirmed tracks that did not begin anew in this step."""
        return [track for track in self._tracks if track.is_confirmed and track.time < self._now]

    def _merge(self, pairs: dict[Track, int], free: set[int], seen: list[Measurement]) -> None:
        """Tracks that are not seen, but whose force is in another's contact."""
        for goes in self._unpaired(pairs):
            best: tuple[float, Track, int] | None = None
            for stays in self._open() if goes in self._open() else []:
                if stays is goes:
                    continue
                for column in [pairs[stays]] if stays in pairs else sorted(free):
                    score = merged_score(stays, goes, seen[column], self.near, self.gate.floor)
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
        stays.absorbed += [absorbed(goes, stays, self._now), *goes.absorbed]
        stays.restart(seen, self._now, rates)
        self._tracks.remove(goes)
        self._changes.append(("merged", stays, (stays.known.number, goes.known.number)))

    def _split(self, pairs: dict[Track, int], free: set[int], seen: list[Measurement]) -> None:
        """Contacts without a track whose force was in another's."""
        for column in sorted(free):
            best: tuple[float, Track, int] | None = None
            for whole in self._open():
                others = [pairs[whole]] if whole in pairs else sorted(free - {column})
                for other in others if column in free else []:
                    score = split_score(
                        whole, seen[other], seen[column], self.near, self.gate.floor
                    )
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
        whole.restart(seen[near], self._now, whole.mean[3:].copy())
        child = Track(self.motion, seen[far], self._now)
        child.parent = whole
        self._tracks.append(child)

    def _drop_unseen(self) -> None:
        """Tracks that coasted for too long, and unconfirmed ones at once."""
        patience = self.coast + ROUNDING
        unseen = [(track, self._now - track.time) for track in self._tracks]
        self._lose([each for each, t in unseen if t > (patience if each.is_confirmed else 0.0)])

    def _lose(self, gone: Sequence[Track]) -> None:
        self._tracks = [track for track in self._tracks if track not in gone]
        for track in gone:
            if track.identity is not None:
                self._changes.append(("lost", track, (track.identity.number,)))

    def _confirm(self, track: Track) -> None:
        """A strong contact at once; a weak one, and a part of another, when it was seen again."""
        force, std = track.seen.value[2], math.sqrt(track.seen.noise[2, 2])
        strong = force >= self.strong * std and track.parent is None
        if not strong and track.readings < self.weak_readings:
            return
        parent, track.parent = track.parent, None
        if parent is None or parent not in self._tracks or parent.identity is None:
            track.identity = self._identity(track)
            self._changes.append(("made", track, (track.identity.number,)))
            return
        if not parent.absorbed:
            track.identity = self._identity(track)
        else:
            memory = max(parent.absorbed, key=lambda one: one.time)
            parent.absorbed.remove(memory)
            track.identity = memory.identity
            if is_exchanged(memory, parent, track, self.motion.pushes, self.gate.floor):
                track.identity, parent.identity = parent.identity, track.identity
        numbers = parent.identity.number, track.identity.number
        self._changes.append(("split", parent, numbers))

    def _identity(self, track: Track) -> Identity:
        self._next_number += 1
        return Identity(self._next_number - 1, track.first, track.first)

    def _slip(self, track: Track) -> None:
        """A place moves if its speed is above the threshold beyond doubt, or has hardly slowed."""
        identity = track.identity
        if identity is None or track.time < self._now:
            return
        x, y = track.mean[3:5].tolist()
        speed = math.hypot(x, y)
        if speed <= self.slip_speed:
            identity.slips = False
            return
        (a, b), (_, c) = track.covariance[3:5, 3:5].tolist()
        std = math.sqrt(a * x * x + 2.0 * b * x * y + c * y * y) / speed
        sigmas = 1.0 if identity.slips else self.slip_sigmas
        moves = speed - sigmas * std > self.slip_speed
        if moves and not identity.slips:
            self._changes.append(("moved", track, (identity.number,)))
        identity.slips = moves
        if moves:
            identity.slipped = self._now
