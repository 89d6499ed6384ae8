"""Contacts of a snapshot in the frames and numbers of skinDynLib."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.estimate.row_contacts import force_of
from skinfield.estimate.wrench import moments_about_origin
from skinfield.loop import Answer
from skinfield.loop.snapshot import Snapshot
from skinfield.skin import Grid, Patch, Skin
from skinfield.wire.yarp import SkinContact, parts_of

SIGMAS = 4.0  # of a taxel's noise, from which on it is active
WIDER = 1.5  # times a contact's radius, within which its pressure and its taxels lie
KILO = 1e3


class ContactList:
    """Makes skinDynLib's contacts of a live skin.

    Parameters
    ----------
    skin : Skin
    given : mapping of str to sequence of int
        See `wire.yarp.parts_of`.
    """

    def __init__(self, skin: Skin, given: Mapping[str, Sequence[int]]) -> None:
        self._patches = tuple(skin)
        self.parts = parts_of([patch.name for patch in skin], given)

    def of(self, snapshot: Snapshot) -> list[SkinContact]:
        """One for each contact of a snapshot."""
        rows = snapshot.contacts
        return [self._contact(snapshot, rows[rows["patch"] == row["patch"]], row) for row in rows]

    def _contact(self, snapshot: Snapshot, beside: NDArray[Any], row: Any) -> SkinContact:
        place = int(row["patch"])
        patch = self._patches[place]
        pose = patch.link_from_patch
        turn, shift = pose[:3, :3], pose[:3, 3]
        force, moment = self._wrench(snapshot, patch, beside, row)
        taxels = active_taxels(snapshot, patch, beside, row)
        return SkinContact(
            number=int(row["track"]),
            part=self.parts[place],
            place=turn @ row["position"] + shift,
            force=turn @ force,
            moment=turn @ moment,
            centre=turn @ patch.positions[taxels].mean(axis=0) + shift,
            normal=turn @ row["normal"],
            taxels=patch.channel[taxels].tolist(),
            pressure=mean_pressure(row),
        )

    def _wrench(
        self, snapshot: Snapshot, patch: Patch, beside: NDArray[Any], row: Any
    ) -> tuple[Floats, Floats]:
        """Force (3,) N and moment (3,) N m about the centre of pressure, in the patch's frame."""
        if snapshot.patches["answer"][row["patch"]] >= int(Answer.LINEAR):
            estimate = snapshot[patch.name]
            force, moment = wrench_of(estimate.grid, estimate.pressure, beside, row)
            return force + row["shear"], moment
        return force_of(row), np.zeros(3)


def wrench_of(
    grid: Grid, pressure: Floats, beside: NDArray[Any], row: Any
) -> tuple[Floats, Floats]:
    """What a contact's pressure does to the robot.

    Each cell's force points into the skin. Their sum is the force, and their moment about their own
    centre the moment: zero on a flat skin, and on one that is curved evenly; torsion is not felt,
    and not invented.

    Parameters
    ----------
    grid : Grid
        Nodes of equal area.
    pressure : (K,) array, Pa
    beside : array of CONTACT
        All contacts of the patch: each cell belongs to the nearest.
    row : record of CONTACT
        Whose `normal_force` is the sum of the cells' normal forces.

    Returns
    -------
    force : (3,) array, N
    moment : (3,) array, N m
    """
    force = float(row["normal_force"])
    mine = belongs(grid.positions, beside, row, grid.pitch) & (pressure > 0.0)
    total = float(pressure[mine].sum())
    if not total > 0.0:
        return -force * row["normal"], np.zeros(3)
    share = pressure[mine] / total
    forces = -force * share[:, None] * grid.normals[mine]
    arms = grid.positions[mine] - share @ grid.positions[mine]
    wrench = moments_about_origin(arms, forces)
    return wrench[:3], wrench[3:]


def belongs(positions: Floats, beside: NDArray[Any], row: Any, pitch: float) -> NDArray[np.bool_]:
    """Which places (K, 3) m are within a contact's reach, and nearer to it than to the others."""
    apart = np.linalg.norm(positions[:, None] - beside["position"][None], axis=2)
    own = np.linalg.norm(positions - row["position"], axis=1)
    area = float(row["area"])
    radius = math.sqrt(area / math.pi) if area > 0.0 and math.isfinite(area) else 0.0
    return np.asarray((own <= apart.min(axis=1)) & (own <= WIDER * radius + 2.0 * pitch))


def active_taxels(
    snapshot: Snapshot, patch: Patch, beside: NDArray[Any], row: Any
) -> NDArray[np.intp]:
    """Rows of the taxels that feel a contact; the nearest one where none stands out."""
    values, valid, noise = snapshot.taxels(patch.name)
    feel = valid & (np.abs(values) > SIGMAS * noise)
    found = np.flatnonzero(feel & belongs(patch.positions, beside, row, patch.pitch))
    if len(found):
        return found
    return np.array([np.argmin(np.linalg.norm(patch.positions - row["position"], axis=1))])


def mean_pressure(row: Any) -> float:
    """Force by area, kPa; the peak where the area is not known."""
    area = float(row["area"])
    if area > 0.0 and math.isfinite(area):
        return float(row["normal_force"]) / area / KILO
    peak = float(row["peak_pressure"])
    return peak / KILO if math.isfinite(peak) else 0.0
