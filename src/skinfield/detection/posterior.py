"""Where and how hard, if anything touches: moments over all templates."""

import numpy as np
from numpy.typing import NDArray

from skinfield.detection.detection import Detection
from skinfield.detection.lookback import Lookback
from skinfield.detection.statistics import Matches, log_evidence
from skinfield.errors import Floats

# What templates leave out: touches that are deep, or of other sizes. About the root mean square
# errors of balls of 6 to 20 mm that press with 0.5 and 1.5 N, which noise does not explain. They
# are skewed: between taxels, where less is felt, the force is taken for a smaller one.
FORCE_ERROR = 0.5  # of the force
PLACE_ERROR = 0.25  # of the distance of two taxels


def detection(
    lookback: Lookback,
    matches: Matches,
    positions: Floats,
    statistic: float,
    threshold: float,
    touch_rate: float,
    pitch: float,
    valid: NDArray[np.bool_],
) -> Detection:
    r"""What one row of matches says.

    By template the posterior of the force is a normal distribution of mean
    :math:`(d - \lambda)/g^2` and deviation 1/g, cut off at 0: with z = (d - lambda)/g and the
    hazard r = phi(z)/Phi(z) it has the mean (z + r)/g and the variance (1 - z r - r²)/g².

    Parameters
    ----------
    positions : (P, 3) array, m
        Of the places, in the patch's frame.
    pitch : float, m
        Of the taxels.
    valid : (T, L) bool array
        Values that are there, of all readings that take part.
    """
    templates = lookback.bank.templates
    evidence, share, hazard = log_evidence(matches)
    by_length = share.reshape(len(lookback.lengths), -1).sum(axis=1)
    by_place = share.reshape(-1, len(positions)).sum(axis=0)
    best = int(by_place.argmax())
    square = np.square(templates.places - templates.places[best]).sum(axis=1)
    z = (matches.score[0] - matches.rate) * matches.spread
    mean = (z + hazard) * matches.spread
    variance = (1.0 - hazard * (z + hazard)) * matches.spread**2
    unseen = matches.spread == 0.0  # the prior is all that is known there
    if unseen.any():
        mean = np.where(unseen, 1.0 / matches.rate, mean)
        variance = np.where(unseen, mean**2, variance)
    force = float(share @ mean)
    spread = share @ (variance + (mean - force) ** 2)
    apart = by_place @ square + templates.spacing**2 / 6
    odds = np.log(touch_rate / (1.0 - touch_rate)) + evidence[0]
    return Detection(
        statistic=statistic,
        threshold=threshold,
        detected=statistic > threshold,
        probability=float(1.0 / (1.0 + np.exp(-np.clip(odds, -700.0, 700.0)))),
        position=positions[best],
        position_std=float(np.sqrt(apart + (PLACE_ERROR * pitch) ** 2)),
        force=force,
        force_std=float(np.sqrt(max(spread, 0.0) + (FORCE_ERROR * force) ** 2)),
        readings=min(lookback.lengths[int(by_length.argmax())], len(valid)),
        left_out=int(valid.size - np.count_nonzero(valid)),
    )
