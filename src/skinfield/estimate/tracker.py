"""Contacts over time: stable numbers, filtered place and force, and what happened."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError, check_count, check_positive, check_range, check_type
from skinfield.estimate.contact import Contact
from skinfield.estimate.contact_list import NEAR, REACH, ContactList
from skinfield.estimate.developed_plane import Chart, contacts_of, measurements_of
from skinfield.estimate.estimate import Estimate
from skinfield.estimate.link_chart import LinkChart
from skinfield.estimate.ranking import falling_order
from skinfield.estimate.track_memory import CONFIRMED, EVENTS, NOW, RULES, STARTED, TOP, TrackMemory
from skinfield.estimate.tracked import KINDS, ContactEvent, Gate, Motion, TrackedContact

HOLD = 0.1  # s: for which an acceleration, or a change of the force's rate, lasts
MOST = 256  # contacts that are followed, half of them in one reading: of more, the strongest


@dataclass(eq=False, kw_only=True)
class Tracker:
    """Follows the contacts of one patch; call it with each estimate in turn.

    Or the contacts of all links of a robot that another program found: call it with each
    `ContactList` in turn. Of these, what stands in `Gate.reach` and `near` is widened to three and
    six spacings of taxels, since such contacts are as coarse as the taxels.

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
        For which an absorbed contact is remembered.
    pause : float, s
        Longer than `memory`: for which there may be no reading at all. The contacts after it go on
        with those before that were at the same place, with half to twice the force; all others are
        lost, and all after a longer pause.
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
    pause: float = 10.0
    slip_speed: float = 5e-3
    slip_sigmas: float = 3.0

    def __post_init__(self) -> None:
        check_positive("period", self.period, "seconds between readings without stamps")
        check_range("coast", self.coast, 0.0, 1e6, "seconds for which a contact may be unseen")
        check_range("strong", self.strong, 0.0, 1e6, "standard deviations of the force")
        check_positive("near", self.near, "farthest distance of contacts that merge, in metres")
        check_positive("memory", self.memory, "seconds for which merged contacts are known")
        check_positive("pause", self.pause, "seconds without a reading that contacts outlast")
        check_positive("slip_speed", self.slip_speed, "from which on a contact slips, in m/s")
        check_range("slip_sigmas", self.slip_sigmas, 0.0, 1e6, "standard deviations of the speed")
        check_count("weak_readings", self.weak_readings, 1, 1000, "in a row, before a weak contact")
        check_type("motion", self.motion, Motion, "how contacts move")
        check_type("gate", self.gate, Gate, "how far from what is foretold a contact may be")
        from skinfield.estimate.tracking_kernel import track

        self._track: Any = track
        self._chart: Chart | LinkChart | None = None
        self._memory = TrackMemory.of(MOST, self.rules, np.full(1, -1))
        self.events: tuple[ContactEvent, ...] = ()
        self.reset()

    @classmethod
    def for_lists(cls) -> "Tracker":
        """Tracker of contact lists, as skinManager sends them.

        Who sends them has told contacts from noise already, so all count at once; what flickers at
        its threshold may be away for 0.5 s, and parts of a hand that come apart again within 5 s
        have their numbers. Whoever taps one place faster leaves one track.
        """
        return cls(weak_readings=1, coast=0.5, memory=5.0)

    def __call__(self, estimate: Estimate | ContactList) -> tuple[Any, ...]:
        """Contacts of an estimate as they go on from those before.

        Parameters
        ----------
        estimate : Estimate or ContactList
            Later than those before, and of the same patch; or a list, later than those before.

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
        if not isinstance(estimate, ContactList):
            check_type("estimate", estimate, Estimate, "what a Reconstructor returns for readings")
        if isinstance(estimate, ContactList) or not estimate.is_batch:
            found, self.events = self._follow(estimate)
            return found
        both = [self._follow(each) for each in estimate]
        self.events = tuple(event for _, events in both for event in events)
        return tuple(found for found, _ in both)

    @property
    def rules(self) -> NDArray[np.void]:
        """All settings (1,), as a live loop's tracker takes them."""
        motion, gate = self.motion, self.gate
        pushes = motion.acceleration**2 * HOLD, motion.force_rate**2 / HOLD
        rates = motion.first_speed**2, motion.first_force_rate**2, motion.top_speed
        gates = motion.false_onsets, gate.distance, gate.floor, gate.reach
        times = (round(1e9 * each) for each in (self.period, self.coast, self.memory, self.pause))
        rest = self.strong, self.weak_readings, self.near, self.slip_speed, self.slip_sigmas
        return np.array([(*pushes, *rates, *gates, *times, *rest)], RULES)

    def reset(self) -> None:
        """Forget all contacts; numbers go on, so that none is given twice."""
        self._memory.reset()
        self._measured: dict[int, Contact] = {}  # by place in the memory
        self._stamp = 0
        if isinstance(self._chart, LinkChart):
            self._chart = LinkChart(self._chart.spacing)
        self.events = ()

    def _follow(
        self, estimate: Estimate | ContactList
    ) -> tuple[tuple[TrackedContact, ...], tuple[ContactEvent, ...]]:
        stamp = int(estimate.stamp_ns)
        now, memory = self._now(stamp), self._memory
        chart = self._chart_of(estimate, now)
        value, noise = measurements_of(estimate.contacts, chart)
        count = min(len(value), MOST // 2)
        strongest = np.argsort(-value[:, 2], kind="stable")[:count]
        contacts, before = memory.contacts[:count], int(memory.words[EVENTS])
        contacts["mean"], contacts["covariance"] = value[strongest], noise[strongest]
        self._track(memory, count, now)
        self._stamp = stamp
        tracks = memory.tracks[: memory.words[TOP]]
        for place in np.flatnonzero(tracks["column"] >= 0).tolist():
            self._measured[place] = estimate.contacts[strongest[tracks["column"][place]]]
        places = np.flatnonzero(tracks["state"] == CONFIRMED)
        tracks, measured = tracks[places], [self._measured[place] for place in places.tolist()]
        found = contacts_of(tracks, measured, chart, now)
        order = falling_order(tracks["mean"][:, 2].tolist(), tracks["number"].tolist())
        events = self._events_since(before, chart)
        if isinstance(chart, LinkChart):
            chart.forget(now - round(1e9 * max(self.coast, self.memory, self.pause)))
        return tuple(found[index] for index in order), events

    def _events_since(self, before: int, chart: Chart | LinkChart) -> tuple[ContactEvent, ...]:
        events = self._memory.events
        events = events[np.arange(before, self._memory.words[EVENTS]) % len(events)]
        positions = chart.surface.position_from_plane(events["place"]) if len(events) else events
        return tuple(
            ContactEvent(
                kind=KINDS[event["kind"]],
                stamp_ns=self._stamp,
                time=1e-9 * int(event["time"]),
                ids=tuple(event["ids"][event["ids"] >= 0].tolist()),
                position=position,
            )
            for event, position in zip(events, positions, strict=True)
        )

    def _now(self, stamp: int) -> int:
        """Time of a reading since the first one, ns."""
        before = int(self._memory.words[NOW])
        if not self._memory.words[STARTED]:
            return 0
        if not stamp or not self._stamp:
            return before + max(round(1e9 * self.period), 1)
        if stamp <= self._stamp:
            raise InputError(
                f"stamp_ns is {stamp}, expected after {self._stamp}, that of the reading before: "
                "hand in readings in the order of time, or call reset() for another recording"
            )
        return before + stamp - self._stamp

    def _chart_of(self, estimate: Estimate | ContactList, now: int) -> Chart | LinkChart:
        """Where places are planar, at `now` ns; raises InputError where it is another's."""
        if isinstance(estimate, ContactList):
            if self._chart is None:
                self._chart = LinkChart(estimate.spacing)
                rules, spacing = self._memory.rules, estimate.spacing
                rules["reach"] = np.maximum(rules["reach"], REACH * spacing)
                rules["near"] = np.maximum(rules["near"], NEAR * spacing)
            if isinstance(self._chart, LinkChart):
                self._chart.now = now
                return self._chart
        else:
            patch = estimate.grid.patch
            if self._chart is None:
                self._chart = Chart(estimate.grid)
            if isinstance(self._chart, Chart) and (
                self._chart.patch is patch
                or np.array_equal(self._chart.patch.positions, patch.positions)
            ):
                return self._chart
        raise InputError(
            f"the estimate is of {_owner(estimate)}, expected {_owner(self._chart)} as "
            "before: take a tracker for each patch"
        )


def _owner(of: Any) -> str:
    """Whose contacts a tracker follows, in words."""
    if isinstance(of, ContactList | LinkChart):
        return "lists of contacts"
    return f"patch {(of.patch if isinstance(of, Chart) else of.grid.patch).name!r}"
