"""Chart of links: planes that are developed where contacts are, without a layout of the skin.

Contacts of other programs come with places and normals in frames of links, and nobody tells the
surface. The first one begins a plane, the tangent plane there; each further one is developed from
the nearest place that is known: along its tangents, which are carried on by the least rotation from
normal to normal (parallel transport). So a contact that slides round an arm goes on without a seam.
Contacts on other links, or whose normals are more than 60° from all that is known, begin planes of
their own, far from the others.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skinfield.errors import Floats, Ints
from skinfield.estimate.contact_list import ListedContact

ALIKE = 0.5  # least cosine between normals of one plane: so it never folds
APART = 10.0  # m, between planes: wider than any link


class LinkChart:
    """Ways between places on links and planes; what `developed_plane.Chart` is for a patch.

    Parameters
    ----------
    spacing : float, m
        Of taxels: every half of it a place is remembered.
    """

    height = 0.0  # m of contacts over the surface that it knows

    def __init__(self, spacing: float) -> None:
        self.spacing = spacing
        self._planes = 0
        self._links: list[tuple[str, int, str]] = []
        self._plane, self._positions = np.empty((0, 2)), np.empty((0, 3))
        self._frames = np.empty((0, 3, 3))  # both tangents and the normal, as columns
        self._used = np.empty(0, np.int64)
        self.now = 0

    @property
    def surface(self) -> "LinkChart":
        """Itself: it knows places of a plane as a patch's surface does."""
        return self

    def plane_of(self, contacts: Sequence[Any]) -> Floats:
        """Places (N, 2) m of `ListedContact`s; what is new of the surface is remembered."""
        return np.array([self._develop(each) for each in contacts]).reshape(-1, 2)

    def position_from_plane(self, plane: Floats) -> Floats:
        """Places (N, 2) m on the links, (N, 3) m, by the tangents of the nearest that is known."""
        near = self._nearest_in(plane)
        off = plane - self._plane[near]
        return np.asarray(
            self._positions[near] + np.einsum("nij,nj->ni", self._frames[near][:, :, :2], off)
        )

    def frame_from_plane(self, plane: Floats) -> Floats:
        """Both tangents and the normal (N, 3, 3), as columns, of the nearest place known."""
        return np.asarray(self._frames[self._nearest_in(plane)])

    def forget(self, before: int) -> None:
        """Forget places where no contact was since `before`."""
        stay = self._used >= before
        if not stay.all():
            self._links = [link for link, known in zip(self._links, stay, strict=True) if known]
            self._plane, self._positions = self._plane[stay], self._positions[stay]
            self._frames, self._used = self._frames[stay], self._used[stay]

    def _develop(self, contact: ListedContact) -> Floats:
        link, normal = (contact.body, contact.link, contact.skin), contact.normal
        same = np.array([each == link for each in self._links], bool)
        if normal.any():
            same &= self._frames[:, :, 2] @ normal > ALIKE
        if not same.any():
            self._planes += 1
            start = np.array([APART * self._planes, 0.0])
            return self._remember(link, start, contact.position, frame_of(normal))
        apart = np.linalg.norm(self._positions - contact.position, axis=1)
        near = int(np.where(same, apart, np.inf).argmin())
        self._used[near] = self.now
        frame = self._frames[near]
        plane = self._plane[near] + (contact.position - self._positions[near]) @ frame[:, :2]
        if apart[near] <= 0.5 * self.spacing:
            return np.asarray(plane)
        return self._remember(link, plane, contact.position, carried(frame, normal))

    def _remember(
        self, link: tuple[str, int, str], plane: Floats, position: Floats, frame: Floats
    ) -> Floats:
        self._links.append(link)
        self._plane = np.vstack([self._plane, plane])
        self._positions = np.vstack([self._positions, position])
        self._frames = np.concatenate([self._frames, frame[None]])
        self._used = np.append(self._used, self.now)
        return plane

    def _nearest_in(self, plane: Floats) -> Ints:
        apart = np.linalg.norm(self._plane[None] - plane[:, None], axis=2)
        return np.asarray(apart.argmin(axis=1))


def frame_of(normal: Floats) -> Floats:
    """Tangents and normal (3, 3), as columns; of no normal the link's own axes."""
    return carried(np.eye(3), normal)


def carried(frame: Floats, normal: Floats) -> Floats:
    """A frame (3, 3) turned by the least rotation that takes its normal to another.

    Rodrigues' formula for the rotation between two unit vectors; of opposite ones, half a turn
    about the first tangent.
    """
    if not normal.any():
        return frame
    own = frame[:, 2]
    cosine = float(own @ normal)
    if cosine <= -1.0 + 1e-12:
        return np.asarray(frame * [1.0, -1.0, -1.0])
    turned = frame - np.outer(own + normal, normal @ frame) / (1.0 + cosine)
    turned[:, 2] = normal
    return np.asarray(turned)
