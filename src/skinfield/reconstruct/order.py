"""Order of taxels in a recording: whether those that read together are neighbours in the layout.

What touches a skin is read by taxels side by side. Where the taxels that go up and down together
lie anywhere on the patch, the layout is another skin's, or the columns are in another order.
"""

import numpy as np

from skinfield.errors import Floats
from skinfield.skin import Patch

READINGS = 1000  # that are looked at: those in which most is read
PART = 0.34  # of the taxels: readings in which more are touched tell no order
TOGETHER = 0.7  # correlation of taxels that read together
FEWEST = 30  # taxels that read together with another, and readings, by which an order is judged
NEAR = 2.5  # distances of taxels, within which they are read side by side
LEAST = 2.5  # times more partners side by side than in any order


def partners(counts: Floats, patch: Patch) -> tuple[int, float, float]:
    """Taxels with a partner, and the share of these nearby, as it is and in any order.

    A partner is the taxel that reads most alike, of the same touches.

    Parameters
    ----------
    counts : (T, L) array
        NaN where a taxel did not answer.
    patch : Patch
    """
    from scipy.spatial import cKDTree

    known = np.where(np.isnan(counts).all(axis=0), 0.0, counts)
    apart = np.nan_to_num(np.abs(known - np.nanmedian(known, axis=0)))
    most = apart[np.argsort(-apart.sum(axis=1), kind="stable")[:READINGS]]
    noise = 1.4826 * np.median(apart, axis=0) + 0.05 * float(np.max(most, initial=0.0))
    stands = most > 5.0 * noise
    part = stands.mean(axis=1)
    most = most[(part > 0.0) & (part < PART)]
    touched = np.flatnonzero(stands[(part > 0.0) & (part < PART)].any(axis=0))
    if min(touched.size, len(most)) < FEWEST:
        return 0, 0.0, 0.0
    values = most[:, touched] - most[:, touched].mean(axis=0)
    left, sizes, right = np.linalg.svd(values, full_matrices=False)
    values = values - sizes[0] * np.outer(left[:, 0], right[0])  # what all read together
    spread = np.maximum(np.linalg.norm(values, axis=0), 1e-12)
    alike = (values.T @ values) / np.outer(spread, spread)
    np.fill_diagonal(alike, -1.0)
    other, sure = alike.argmax(axis=1), alike.max(axis=1) > TOGETHER
    places = patch.positions[touched]
    near = np.linalg.norm(places - places[other], axis=1)[sure] < NEAR * patch.pitch
    pairs = len(cKDTree(places).query_pairs(NEAR * patch.pitch))
    chance = pairs / (0.5 * len(touched) * (len(touched) - 1))
    return int(sure.sum()), float(near.mean()) if sure.any() else 0.0, chance


def order_note(counts: Floats, patch: Patch) -> tuple[str, ...]:
    """A sentence where taxels that read together lie anywhere on the patch."""
    count, near, chance = partners(counts, patch)
    if not (count >= FEWEST and near < LEAST * chance < 0.5):
        return ()
    return (
        f"of {count} taxels that read together with another, {100 * near:.0f} % lie side by side "
        f"on {patch.name!r}, as {100 * chance:.0f} % do in any order: is it the layout of the "
        "recording's skin, with its taxels in the recording's order?",
    )
