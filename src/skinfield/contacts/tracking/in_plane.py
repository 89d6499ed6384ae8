"""Contacts into the developed plane, and tracks back onto the skin."""

from collections.abc import Sequence

import numpy as np

from skinfield.contacts.tracking.chart import Chart
from skinfield.contacts.tracking.track import Seen, Track
from skinfield.contacts.tracking.tracked import TrackedContact
from skinfield.errors import InputError
from skinfield.fields import Contact

FLOOR = np.diag([1e-5, 1e-5, 1e-3]) ** 2  # m, m, N: no solver is surer than this


def seen_of(contacts: Sequence[Contact], chart: Chart) -> list[Seen]:
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
    return [Seen(*one) for one in zip(contacts, values, noise, strict=True)]


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
                spread=None,  # the intervals are the filter's
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
