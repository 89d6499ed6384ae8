"""Developed plane of a surface: contacts as a tracker follows them, and back."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError
from skinfield.estimate.contact import Contact
from skinfield.estimate.link_chart import LinkChart
from skinfield.estimate.track_memory import FLOORS
from skinfield.estimate.tracked import TrackedContact
from skinfield.skin import Grid

CLOSE, MOST = 1e-8, 50  # m: a step that ends the search; and steps after which it has failed


class Chart:
    """Ways between a patch's surface and its developed plane.

    Parameters
    ----------
    grid : Grid
        Whose nodes are where a search on a curved surface starts.
    """

    def __init__(self, grid: Grid) -> None:
        from scipy.spatial import cKDTree

        self.patch, self.surface = grid.patch, grid.patch.surface
        self._plane, self.height = grid.plane, grid.height
        zero = np.zeros((1, 2))
        self._flat = bool(self.surface.is_flat)
        self._origin = self.surface.position_from_plane(zero)[0]
        self._axes = self.surface.frame_from_plane(zero)[0][:, :2]
        self._nodes = None if self._flat else cKDTree(grid.positions)

    def plane_of(self, contacts: Sequence[Contact]) -> Floats:
        """Places (N, 2) m of contacts in the plane."""
        return self.plane_from_position(np.array([one.position for one in contacts]))

    def plane_from_position(self, positions: Floats) -> Floats:
        """Points (N, 3) m of the surface in its plane, (N, 2) m.

        On a curved surface by Newton's method with the tangents, which are orthonormal while the
        plane is true to lengths up to the surface's `distortion`: so the error shrinks by this
        factor per step.

        Raises
        ------
        InputError
            If a point is so far from the surface that none of it is the nearest.
        """
        if self._nodes is None:
            return np.asarray((positions - self._origin) @ self._axes)
        plane = self._plane[self._nodes.query(positions)[1]]
        for _ in range(MOST):
            frames = self.surface.frame_from_plane(plane)
            off = positions - self.surface.position_from_plane(plane)
            off -= self.height * frames[:, :, 2]
            tangents = frames[:, :, :2]
            step = np.einsum("nij,ni->nj", tangents, off)
            plane = plane + step
            if np.abs(step).max(initial=0.0) < CLOSE:
                return np.asarray(plane)
        worst = int(np.abs(step).max(axis=1).argmax())
        raise InputError(
            f"a contact's position is {positions[worst]} m, expected a point of the patch's "
            "surface: take contacts of the same patch as the grid"
        )


def measurements_of(contacts: Sequence[Contact], chart: Chart | LinkChart) -> tuple[Floats, Floats]:
    """Place in the developed plane and force (N, 3), m and N, with covariances (N, 3, 3).

    Raises
    ------
    InputError
        If one has a number that is not finite, or a covariance that is none.
    """
    values, noise = np.empty((len(contacts), 3)), np.empty((len(contacts), 3, 3))
    if not contacts:
        return values, noise
    values[:, :2] = chart.plane_of(contacts)
    values[:, 2] = [one.normal_force for one in contacts]
    noise[:] = [one.covariance for one in contacts]
    noise += FLOORS
    area = noise[:, 0, 0] * noise[:, 1, 1] - noise[:, 0, 1] ** 2
    wrong = ~np.isfinite(values).all(axis=1) | ~np.isfinite(noise).all(axis=(1, 2)) | ~(area > 0.0)
    if wrong.any():
        index = int(wrong.argmax())
        raise InputError(
            f"contacts[{index}] has position {contacts[index].position} m, force "
            f"{values[index, 2]} N and covariance {contacts[index].covariance.tolist()}, expected "
            "finite numbers and a positive covariance: a tracker weighs contacts by it"
        )
    return values, noise


def contacts_of(
    tracks: NDArray[np.void], measured: Sequence[Contact], chart: Chart | LinkChart, now: int
) -> list[TrackedContact]:
    """Contacts of confirmed tracks at `now` ns, each with the contact that was measured last."""
    if not measured:
        return []
    means, covariances = tracks["mean"], tracks["covariance"]
    frames = chart.surface.frame_from_plane(means[:, :2])
    positions = chart.surface.position_from_plane(means[:, :2]) + chart.height * frames[:, :, 2]
    velocities = np.einsum("nij,nj->ni", frames[:, :, :2], means[:, 3:5])
    forces = np.array([contact.normal_force for contact in measured])
    pushed = forces > 0.0
    shares = np.where(pushed, np.maximum(means[:, 2], 0.0) / np.where(pushed, forces, 1.0), 0.0)
    resultants = shares[:, None] * np.array([contact.force for contact in measured])
    rate_stds = np.sqrt(covariances[:, 5, 5])
    found = []
    for index, (track, contact) in enumerate(zip(tracks, measured, strict=True)):
        made, slipped, last = (int(track[name]) for name in ("made", "slipped", "last"))
        found.append(
            TrackedContact.later(
                contact,  # has all that is not filtered
                position=positions[index],
                force=resultants[index],
                moment=shares[index] * contact.moment,
                normal=frames[index, :, 2],
                tangents=frames[index, :, :2],
                covariance=covariances[index, :3, :3],
                track_id=int(track["number"]),
                velocity=velocities[index],
                velocity_covariance=covariances[index, 3:5, 3:5],
                force_rate=float(means[index, 5]),
                force_rate_std=float(rate_stds[index]),
                age=1e-9 * (now - made),
                duration=1e-9 * (last - made),
                since_slip=1e-9 * (now - slipped),
                is_slipping=bool(track["slips"]),
                is_coasting=last < now,
                measured=contact,
            )
        )
    return found
