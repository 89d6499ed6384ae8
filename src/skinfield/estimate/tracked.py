"""Tracked contacts, what happens to them, and how they may move: motion and gate."""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from skinfield.errors import Floats
from skinfield.estimate.contact import Contact
from skinfield.settings import Positive, Range, Section

EventKind = Literal["made", "moved", "merged", "split", "lost"]
KINDS: tuple[EventKind, ...] = (
    "made",
    "moved",
    "merged",
    "split",
    "lost",
)  # of the kernel


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

    def moved(self, pose: Floats) -> "TrackedContact":
        """See `Contact.moved`; `velocity` turns, and `measured` moves as well."""
        known = vars(super().moved(pose))
        rest = known.pop("_rest")
        measured, velocity = self.measured.moved(pose), pose[:3, :3] @ self.velocity
        return TrackedContact.later(rest, **known, measured=measured, velocity=velocity)

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


@dataclass(frozen=True, kw_only=True)
class Motion(Section):
    """How contacts move and how fast forces change.

    Velocity and rate of the force are random walks (continuous white noise acceleration;
    Bar-Shalom, Li and Kirubarajan 2001, section 6.2.2), whose intensity does not depend on how
    often the skin is read. A reading that this cannot explain is taken for the onset of a touch or
    of a motion: the rates are then as unknown as those of a new contact.

    Parameters
    ----------
    acceleration : float, m/s²
        Typical, along the skin, each lasting 0.1 s.
    force_rate : float, N/s
        By which the rate of the force changes within 0.1 s.
    first_speed : float, m/s
        One standard deviation of the velocity of a new contact, along each tangent.
    first_force_rate : float, N/s
        One standard deviation of its force's rate.
    top_speed : float, m/s
        No contact moves faster along the skin: a jump of a solver's answer is no velocity.
    false_onsets : float, 1/s
        How often noise may be taken for an onset, however often the skin is read. From 0.05 an
        onset is a squared Mahalanobis distance from what is foretold of 17.7 at 100 Hz, of 22.6 at
        1 kHz.
    """

    acceleration: Annotated[float, Positive("along the skin, in m/s²")] = 0.2
    force_rate: Annotated[float, Positive("change of it within 0.1 s, in N/s")] = 4.0
    first_speed: Annotated[float, Positive("of a new contact, in m/s")] = 0.06
    first_force_rate: Annotated[float, Positive("of a new contact, in N/s")] = 15.0
    top_speed: Annotated[float, Positive("of a contact along the skin, in m/s")] = 0.25
    false_onsets: Annotated[float, Range(0.0, 1e3, "a second, of a resting contact")] = 0.05


@dataclass(frozen=True, kw_only=True)
class Gate(Section):
    """How far from what is foretold a contact may be.

    Parameters
    ----------
    distance : float
        Squared Mahalanobis distance of the place: 18.4 is exceeded with a chance of 1e-4.
    floor : float, m
        Standard deviation of the place, on each axis, that is added: what solvers do not state.
    reach : float, m
        Farthest distance, whatever the covariance.
    """

    distance: Annotated[float, Positive("squared Mahalanobis distance")] = 18.4
    floor: Annotated[float, Positive("standard deviation of the place, in metres")] = 1e-3
    reach: Annotated[float, Positive("from what is foretold, in metres")] = 8e-3
