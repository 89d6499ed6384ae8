"""Developed plane of a surface: contacts as a tracker follows them, and back."""

from collections.abc import Sequence

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.estimate.contact import Contact
from skinfield.estimate.tracked import TrackedContact
from skinfield.estimate.tracks import Measurement, Track
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
        self._plane = grid.plane
        zero = np.zeros((1, 2))
        self._flat = bool(self.surface.is_flat)
        self._origin = self.surface.position_from_plane(zero)[0]
        self._axes = self.surface.frame_from_plane(zero)[0][:, :2]
        self._nodes = None if self._flat else cKDTree(grid.positions)

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
            off = positions - self.surface.position_from_plane(plane)
            tangents = self.surface.frame_from_plane(plane)[:, :, :2]
            step = np.einsum("nij,ni->nj", tangents, off)
            plane = plane + step
            if np.abs(step).max(initial=0.0) < CLOSE:
                return np.asarray(plane)
        worst = int(np.abs(step).max(axis=1).argmax())
        raise InputError(
            f"a contact's position is {positions[worst]} m, expected a point of the patch's "
            "surface: take contacts of the same patch as the grid"
        )


FLOOR = np.diag([1e-5, 1e-5, 1e-3]) ** 2  # m, m, N: no solver is surer than this


def measurements_of(contacts: Sequence[Contact], chart: Chart) -> list[Measurement]:
    """The contacts of a reading in the developed plane.

    Raises
    ------
    InputError
        If one has a number that is not finite, or a covariance that is none.
    """
    if not contacts:
        return []
    values = np.empty((len(contacts), 3))
    values[:, :2] = chart.plane_from_position(np.array([one.position for one in contacts]))
    values[:, 2] = [one.normal_force for one in contacts]
    noise = np.array([one.covariance for one in contacts]) + FLOOR
    area = noise[:, 0, 0] * noise[:, 1, 1] - noise[:, 0, 1] ** 2
    wrong = ~np.isfinite(values).all(axis=1) | ~np.isfinite(noise).all(axis=(1, 2)) | ~(area > 0.0)
    if wrong.any():
        index = int(wrong.argmax())
        raise InputError(
            f"contacts[{index}] has position {contacts[index].position} m, force "
            f"{values[index, 2]} N and covariance {contacts[index].covariance.tolist()}, expected "
            "finite numbers and a positive covariance: a tracker weighs contacts by it"
        )
    return [Measurement(*one) for one in zip(values, noise, contacts, strict=True)]


def contacts_of(tracks: Sequence[Track], chart: Chart, now: float) -> list[TrackedContact]:
    """What is told of confirmed tracks."""
    if not tracks:
        return []
    means = np.array([track.mean for track in tracks])
    covariances = np.array([track.covariance for track in tracks])
    positions = chart.surface.position_from_plane(means[:, :2])
    frames = chart.surface.frame_from_plane(means[:, :2])
    velocities = np.einsum("nij,nj->ni", frames[:, :, :2], means[:, 3:5])
    measured = np.array([track.seen.value[2] for track in tracks])
    pushed = measured > 0.0
    shares = np.where(pushed, np.maximum(means[:, 2], 0.0) / np.where(pushed, measured, 1.0), 0.0)
    forces = shares[:, None] * np.array([track.seen.contact.force for track in tracks])
    rate_stds = np.sqrt(covariances[:, 5, 5])
    found = []
    for index, track in enumerate(tracks):
        identity, contact = track.known, track.seen.contact
        found.append(
            TrackedContact.later(
                contact,  # has all that is not filtered
                position=positions[index],
                force=forces[index],
                moment=shares[index] * contact.moment,
                normal=frames[index, :, 2],
                covariance=covariances[index, :3, :3],
                track_id=identity.number,
                velocity=velocities[index],
                velocity_covariance=covariances[index, 3:5, 3:5],
                force_rate=float(means[index, 5]),
                force_rate_std=float(rate_stds[index]),
                age=now - identity.made,
                duration=track.time - identity.made,
                since_slip=now - identity.slipped,
                is_slipping=identity.slips,
                is_coasting=track.time < now,
                measured=contact,
            )
        )
    return found
