"""Which column of a recording belongs to which taxel."""

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.layout import Patch
from skinfield.reading import Recording


def taxel_counts(recording: Recording, patch: Patch) -> Floats:
    """Readings of the taxels of `patch`, (T, L), from all columns of a port.

    By uid where the recording says uids, else by channel. A taxel whose uid was not recorded is
    NaN throughout, so that it counts as absent.

    Raises
    ------
    InputError
        If no uid fits, uids repeat, or the recording has another width than the patch's port.
    """
    columns = recording.counts.shape[1]
    if recording.uid is not None:
        return _by_uid(recording, patch)
    if columns == patch.n_channels:
        return recording.counts[:, patch.channel]
    raise InputError(
        f"{recording.source or 'the recording'} has {columns} columns, expected "
        f"{patch.n_channels} channels as patch {patch.name!r} has: "
        "the layout belongs to another port"
    )


def _by_uid(recording: Recording, patch: Patch) -> Floats:
    uid = np.asarray(recording.uid)
    order = np.argsort(uid, kind="stable")
    in_order = uid[order]
    twice = np.flatnonzero((in_order[1:] == in_order[:-1]) & np.isin(in_order[1:], patch.uid))
    if len(twice):
        raise InputError(
            f"uid {in_order[twice[0]]} stands over more than one column of "
            f"{recording.source or 'the recording'}, expected each once: "
            "leave out the copy that is not the taxel"
        )
    found = np.minimum(np.searchsorted(in_order, patch.uid), len(uid) - 1)
    known = in_order[found] == patch.uid
    if not known.any():
        raise InputError(
            f"{recording.source or 'the recording'} has none of the {len(patch)} uids of patch "
            f"{patch.name!r}, its first is {uid[0]}, expected one such as {patch.uid[0]}: "
            "the layout belongs to another skin"
        )
    counts = recording.counts[:, order[found]]
    return np.where(known, counts, np.nan)
