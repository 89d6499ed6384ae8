"""Wrench of the contacts on a link: force, moment about the link's origin, and their covariance."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from numpy.typing import ArrayLike

from skinfield.errors import Floats
from skinfield.estimate.contact import Contact
from skinfield.plot import number

SHEAR_STD = 0.35  # of each component of the force along the skin over that into it, if not read


def moments_about_origin(positions: ArrayLike, forces: ArrayLike) -> Floats:
    """Sum of forces (N, 3) N at positions (N, 3) m, and of their moments r x f, (6,) N and N m."""
    places = np.asarray(positions, np.float64).reshape(-1, 3)
    each = np.asarray(forces, np.float64).reshape(-1, 3)
    return np.concatenate([each.sum(axis=0), np.cross(places, each).sum(axis=0)])


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Wrench(NDArrayOperatorsMixin):
    """What contacts do to a link: an array (6,) of force, N, and moment about its origin, N m.

    In the link's frame; the force points into the skin. It is the wrench of the contacts that were
    found: a press too weak to be noticed is not in it, nor in its covariance.

    Attributes
    ----------
    values : (6,) array
        Force, then moment.
    covariance : (6, 6) array
        From place and force of all contacts, to first order, each contact by itself: of forces
        along the skin that the readings do not tell, as wide as they usually are (0.35 of the
        force into it, one standard deviation).
    centre_of_pressure : (3,) array or None, m
        Mean of the places of contacts by their normal forces; None where nothing touches.
    normal_force : float, N
        Sum of the contacts'.
    stamp_ns : int, ns
        Of the oldest reading in it; 0 where it had none.
    age : float or None, s
        Of that reading, of a running skin.
    """

    values: Floats
    covariance: Floats
    centre_of_pressure: Floats | None = None
    normal_force: float = 0.0
    stamp_ns: int = 0
    age: float | None = None

    @classmethod
    def of(
        cls,
        contacts: Iterable[Contact],
        link_from_patch: Floats | None = None,
        stamp_ns: int = 0,
        age: float | None = None,
    ) -> "Wrench":
        """Wrench of contacts, in the frame that a pose leads to; default their own."""
        if link_from_patch is not None and not np.array_equal(link_from_patch, np.eye(4)):
            contacts = [contact.moved(link_from_patch) for contact in contacts]
        found = [*contacts]
        places = np.array([contact.position for contact in found]).reshape(-1, 3)
        loads = np.array([contact.normal_force for contact in found])
        own = [*(contact.moment for contact in found), np.zeros(3)]
        values = moments_about_origin(places, [contact.force for contact in found])
        values[3:] += np.sum(own, axis=0)
        total = float(loads.sum())
        return cls(
            values=values,
            covariance=np.sum([np.zeros((6, 6)), *map(covariance_of_contact, found)], axis=0),
            centre_of_pressure=loads @ places / total if total > 0.0 else None,
            normal_force=total,
            stamp_ns=int(stamp_ns),
            age=age,
        )

    @classmethod
    def sum(cls, wrenches: Iterable["Wrench"]) -> "Wrench":
        """Wrench of all, in one frame, about one origin; as old as the oldest."""
        found = [*wrenches]
        total = sum(each.normal_force for each in found)
        centres = [
            each.normal_force * each.centre_of_pressure
            for each in found
            if each.centre_of_pressure is not None
        ]
        ages = [each.age for each in found if each.age is not None]
        return cls(
            values=np.sum([np.zeros(6), *(each.values for each in found)], axis=0),
            covariance=np.sum([np.zeros((6, 6)), *(each.covariance for each in found)], axis=0),
            centre_of_pressure=np.sum(centres, axis=0) / total if centres else None,
            normal_force=float(total),
            stamp_ns=min((each.stamp_ns for each in found), default=0),
            age=max(ages, default=None),
        )

    def moved(self, pose: Floats) -> "Wrench":
        """The same in another frame and about its origin, by the pose (4, 4) of the link in it."""
        turn, (x, y, z) = pose[:3, :3], pose[:3, 3]
        adjoint = np.kron(np.eye(2), turn)
        adjoint[3:, :3] = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]) @ turn
        centre = self.centre_of_pressure
        return replace(
            self,
            values=adjoint @ self.values,
            covariance=adjoint @ self.covariance @ adjoint.T,
            centre_of_pressure=None if centre is None else turn @ centre + pose[:3, 3],
        )

    @property
    def force(self) -> Floats:
        """Of all contacts on the link, (3,) N."""
        return self.values[:3]

    @property
    def moment(self) -> Floats:
        """About the link's origin, (3,) N m."""
        return self.values[3:]

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the array: (6,)."""
        return self.values.shape

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, index: Any) -> Any:
        return self.values[index]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        """As NumPy takes it."""
        return np.array(self.values, dtype=dtype, copy=True)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **settings: Any) -> Any:
        """Arithmetic, which makes plain arrays."""
        if any(isinstance(each, Wrench) for each in settings.get("out", ())):
            return NotImplemented  # it does not change
        plain = [each.values if isinstance(each, Wrench) else each for each in inputs]
        return getattr(ufunc, method)(*plain, **settings)

    def __repr__(self) -> str:
        force, moment = (
            ", ".join(map(number, part.tolist())) for part in self.values.reshape(2, 3)
        )
        return f"Wrench(({force}) N, ({moment}) N m)"


def covariance_of_contact(contact: Contact) -> Floats:
    """Covariance (6, 6) of force and moment r x f of a contact, in its own frame.

    With place r = r0 + t x + s y and force f = -F n + g, where t, s are the tangents, n the normal
    and g the force along the skin, to first order in x, y, F and g.
    """
    position, normal, force = contact.position, contact.normal, contact.force
    along = np.eye(3) - np.outer(normal, normal)
    shear = along @ contact.force_covariance @ along
    if not np.isfinite(shear).all():  # nothing told of it
        shear = (SHEAR_STD * contact.normal_force) ** 2 * along
    moves = np.zeros((6, 3))
    moves[3:, :2] = np.cross(contact.tangents.T, force).T
    moves[:3, 2], moves[3:, 2] = -normal, np.cross(position, -normal)
    pulls = np.vstack([np.eye(3), np.cross(position, np.eye(3)).T])
    return np.asarray(moves @ contact.covariance @ moves.T + pulls @ shear @ pulls.T)


def wrenches_by_link(wrenches: Iterable[tuple[str, Wrench]]) -> dict[str, Wrench]:
    """Wrench of each link, which is the sum of those of its patches; of patches on none, none."""
    by_link: dict[str, list[Wrench]] = {}
    for link, wrench in wrenches:
        if not link:
            continue  # whose frames have nothing to do with each other
        by_link.setdefault(link, []).append(wrench)
    return {link: Wrench.sum(its) for link, its in by_link.items()}
