"""Matching of a recording's columns with the taxels of a patch."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError
from skinfield.skin import Patch
from skinfield.skin.reading import UNITS, Recording

TYPICAL = {  # columns of ports: the layouts that have as many
    72: "hexagon72, or 6 modules of 12",
    192: "an iCub hand",
    384: "an iCub forearm or foot",
    768: "an iCub arm, torso or lower leg",
    1344: "an iCub upper leg",
}
SHOWN = 5


def readings_for(recording: Recording, patch: Patch) -> Recording:
    """Readings in the order of a patch's taxels.

    Columns are found by uid where the recording has uids, else by the patch's channels.

    Parameters
    ----------
    recording : Recording
        Of T readings over C columns.
    patch : Patch
        Of L taxels.

    Returns
    -------
    Recording
        Of (T, L) counts; its uids are the patch's. A taxel that the recording lacks is NaN; notes
        say which are missing and which columns were left out.

    Raises
    ------
    InputError
        If the recording is no skin's, no uid is common to both, or there are other than
        `patch.n_channels` columns.
    """
    if recording.unit not in UNITS:
        raise InputError(
            f"{recording.source} holds {recording.unit!r}, expected readings of a skin in "
            f"{', '.join(UNITS)}: it is a force log, most likely"
        )
    if recording.uid is None:
        return replace(recording, counts=_by_channel(recording, patch), uid=patch.uid)
    counts, notes = _by_uid(recording, recording.uid, patch)
    return replace(recording, counts=counts, uid=patch.uid, notes=recording.notes + notes)


def _by_channel(recording: Recording, patch: Patch) -> NDArray[np.float64]:
    columns = recording.counts.shape[1]
    if columns != patch.n_channels:
        few = TYPICAL.get(columns, f"{columns // 12} modules of 12" if columns % 12 == 0 else "")
        hint = f"; {columns} columns fit {few}" if few else ""
        raise InputError(
            f"{recording.source} has {columns} columns, expected {patch.n_channels}, the channels "
            f"of {patch.name!r} ({len(patch)} taxels): this layout is not the recording's{hint}"
        )
    return np.ascontiguousarray(recording.counts[:, patch.channel])


def _by_uid(
    recording: Recording, uid: NDArray[np.uint64], patch: Patch
) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    distinct, first = np.unique(uid, return_index=True)
    place = np.minimum(np.searchsorted(distinct, patch.uid), len(distinct) - 1)
    found = distinct[place] == patch.uid
    if not found.any():
        raise InputError(
            f"{recording.source} has uids {_few(distinct)}, patch {patch.name!r} has "
            f"{_few(np.unique(patch.uid))}, expected common ones: this layout is not the "
            "recording's, or holds no uids (to go by channel: dataclasses.replace(rec, uid=None))"
        )
    counts = np.full((len(recording), len(patch)), np.nan)
    counts[:, found] = recording.counts[:, first[place[found]]]
    surplus, missing = uid[~np.isin(uid, patch.uid)], patch.uid[~found]
    thermal = surplus & np.uint64(15) == 0  # sensor 0 of a CySkin module
    said = (
        (missing, f"taxels of {patch.name!r} have no column"),
        (surplus[thermal], "columns of sensor 0 (CySkin: temperature) left out"),
        (surplus[~thermal], "columns of uids that the layout lacks left out"),
    )
    return counts, tuple(f"{len(its)} {text}: {_few(its)}" for its, text in said if len(its))


def _few(uid: NDArray[np.uint64]) -> str:
    return ", ".join(map(str, uid[:SHOWN].tolist())) + (", ..." if len(uid) > SHOWN else "")
