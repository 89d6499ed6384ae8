"""Contacts over time: stable numbers, filtered place and force, and what happened."""

from typing import TYPE_CHECKING, Any, cast

import numpy as np

from skinfield.errors import InputError, check_type
from skinfield.estimate.estimate import Estimate
from skinfield.estimate.ranking import falling_order
from skinfield.estimate.tracked import ContactEvent, EventKind, TrackedContact, TrackerSettings

if TYPE_CHECKING:
    from skinfield.estimate.developed_plane import Chart


class Tracker(TrackerSettings):
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

    def __post_init__(self) -> None:
        super().__post_init__()
        from skinfield.estimate.tracks import Follower

        self._follower = Follower(self)
        self._chart: Chart | None = None
        self._stamp = 0
        self._started = False
        self.events: tuple[ContactEvent, ...] = ()

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
        from skinfield.estimate.tracks import Follower

        self._follower = Follower(self, self._follower.next_number)
        self._stamp, self._started, self.events = 0, False, ()

    def _follow(
        self, estimate: Estimate
    ) -> tuple[tuple[TrackedContact, ...], tuple[ContactEvent, ...]]:
        from skinfield.estimate.developed_plane import contacts_of, measurements_of

        chart, stamp = self._chart_of(estimate), int(estimate.stamp_ns)
        seen = measurements_of(estimate.contacts, chart)
        follower = self._follower
        follower.step(seen, self._step_to(stamp))
        self._stamp, self._started = stamp, True
        tracks = [track for track in follower.tracks if track.is_confirmed]
        named = [one[1][0] for one in follower.changes]
        everyone = list(dict.fromkeys([*tracks, *named]))
        contacts = dict(zip(everyone, contacts_of(everyone, chart, follower.now), strict=True))
        events = tuple(
            ContactEvent(
                kind=cast(EventKind, kind),
                stamp_ns=stamp,
                time=follower.now,
                ids=ids,
                position=contacts[first].position,
            )
            for kind, (first, *_), ids in follower.changes
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

    def _chart_of(self, estimate: Estimate) -> "Chart":
        from skinfield.estimate.developed_plane import Chart

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
