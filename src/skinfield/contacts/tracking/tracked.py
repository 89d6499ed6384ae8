"""What a tracker hands out: contacts that last, and what happened to them."""

from dataclasses import dataclass
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
