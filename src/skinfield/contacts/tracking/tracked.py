"""What a tracker hands out: contacts that last, and what happened to them."""

from dataclasses import dataclass, fields
from typing import Literal

import numpy as np

from skinfield.errors import Floats
from skinfield.fields import Contact

EventKind = Literal["made", "moved", "merged", "split", "lost"]


@dataclass(frozen=True, eq=False, kw_only=True)
class TrackedContact(Contact):
    """A contact that is followed from reading to reading.

    Place, normal force and their covariance are filtered, so that the intervals are those of the
    filter. The direction of the force is that of the latest reading that saw the contact, and so
    is all else that a `Contact` has: moment (in proportion to the force), area, outline, shape.

    Attributes
    ----------
    velocity : (3,) array, m/s
        Of the place along the skin, in the patch's frame.
    velocity_covariance : (2, 2) array, m²/s²
        Along the surface's two tangents at `position`.
    force_rate : float, N/s
        Of the normal force.
    force_rate_std : float, N/s
    age : float, s
        Since the first reading that saw it.
    duration : float, s
        From the first reading that saw it to the latest one.
    since_slip : float, s
        Since the place last moved over the skin, or since it was made.
    is_slipping : bool
        Whether the place moves, beyond doubt; sliding and rolling look the same.
    is_coasting : bool
        Whether this reading does not see it, so that place and force are foretold.
    measured : Contact
        As the latest reading that saw it has it, not filtered.
    """

    velocity: Floats
    velocity_covariance: Floats
    force_rate: float
    force_rate_std: float
    age: float
    duration: float
    since_slip: float
    is_slipping: bool
    is_coasting: bool
    measured: Contact

    @property
    def speed(self) -> float:
        """Of the place along the skin, m/s."""
        return float(np.linalg.norm(self.velocity))


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactEvent:
    """What happened to contacts between two readings.

    Attributes
    ----------
    kind : "made", "moved", "merged", "split" or "lost"
        "moved" is told when a contact begins to move over the skin, the others once.
    stamp_ns : int
        Of the reading; 0 where it has none.
    time : float, s
        Since the tracker's first reading.
    ids : tuple of int
        Merged: the one that stays, then the one that is absorbed. Split: the one that stays, then
        the other, which is an old id if it was absorbed shortly before. Else one id.
    position : (3,) array, m
        Where, in the patch's frame: of the first id.
    """

    kind: EventKind
    stamp_ns: int
    time: float
    ids: tuple[int, ...]
    position: Floats


_FILTERED = {"position", "force", "moment", "normal", "covariance", "track_id", "spread"}
_KEPT = tuple(field.name for field in fields(Contact) if field.name not in _FILTERED)


@dataclass(frozen=True, eq=False)
class Filtered:
    """State of a filter at a place of the surface.

    Attributes
    ----------
    position : (3,) array, m
    frame : (3, 3) array
        Two tangents and the normal there.
    mean : (6,) array
        x and y m, normal force N, and their rates per s.
    covariance : (6, 6) array
    """

    position: Floats
    frame: Floats
    mean: Floats
    covariance: Floats


@dataclass(frozen=True)
class Times:
    """Spans of a track, s; see `TrackedContact`."""

    age: float
    duration: float
    since_slip: float


def tracked_contact(
    measured: Contact, track_id: int, state: Filtered, times: Times, *, slips: bool, coasts: bool
) -> TrackedContact:
    """The contact of a track; its `spread` is gone, as that of a filtered contact is another."""
    mean, covariance, normal = state.mean, state.covariance, state.frame[:, 2]
    force, seen = max(float(mean[2]), 0.0), measured.normal_force
    share = force / seen if seen > 0 else 0.0
    return TrackedContact(
        **{name: getattr(measured, name) for name in _KEPT},
        position=state.position,
        force=share * measured.force if seen > 0 else -force * normal,
        moment=share * measured.moment,
        normal=normal,
        covariance=covariance[:3, :3].copy(),
        track_id=track_id,
        velocity=state.frame[:, :2] @ mean[3:5],
        velocity_covariance=covariance[3:5, 3:5].copy(),
        force_rate=float(mean[5]),
        force_rate_std=float(np.sqrt(covariance[5, 5])),
        age=times.age,
        duration=times.duration,
        since_slip=times.since_slip,
        is_slipping=slips,
        is_coasting=coasts,
        measured=measured,
    )
