"""Which contact goes on with which track: the global optimum."""

from collections.abc import Sequence

import numpy as np

from skinfield.contacts.tracking.habits import Gate
from skinfield.contacts.tracking.kernels import gains
from skinfield.contacts.tracking.track import Seen, Track

TENTATIVE = 3.0  # added to the cost of a track that is not confirmed yet
FORCE_SAYS = 9.0  # most that a force which does not fit adds to the cost


def assigned(tracks: Sequence[Track], seen: Sequence[Seen], gate: Gate) -> dict[int, int]:
    """Contact of each track that has one, by their places in the sequences.

    The sum of what the pairs are worth is the highest there is (Kuhn 1955). A pair costs the
    squared Mahalanobis distance of the place and, up to a limit, that of the force, and the
    logarithm of the place's variance: of two contacts as near, the surer one goes on.
    """
    if not tracks or not seen:
        return {}
    limits = (gate.distance, gate.floor**2, gate.reach, FORCE_SAYS)
    gain = gains(
        np.array([track.mean for track in tracks]),
        np.array([track.covariance for track in tracks]),
        np.array([0.0 if track.is_confirmed else TENTATIVE for track in tracks]),
        np.array([one.value for one in seen]),
        np.array([one.noise for one in seen]),
        (*limits, gate.distance + FORCE_SAYS + TENTATIVE),
    )
    if gain.size == 1:
        return {0: 0} if gain[0, 0] > 0.0 else {}
    from scipy.optimize import linear_sum_assignment

    rows, columns = linear_sum_assignment(gain, maximize=True)
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    return {row: column for row, column in pairs if gain[row, column] > 0.0}
