"""What atoms leave over of a reading: noise, less or more than was stated, or more contacts."""

import numpy as np

from skinfield.errors import Floats
from skinfield.inverse.atoms.problem import AtomSet, Problem

ODD = 1e-4  # readings that contacts explain, and that are taken not to be explained
QUIETEST = 1e-3  # of the stated noise, that is believed
QUIET = 0.25  # of the expected squares of residuals: below, there is less noise than was stated
CALM = 0.7  # the same, where more noise than was stated had been assumed
UNSEEN = 12  # taxels that see no contact, and tell the noise by themselves
LOUD = 1.8  # times the stated noise, from which it is more: less may be weak touches
LOUDEST = 4.0  # times: what is left over beyond is no noise, but more than the atoms could tell
NORMAL_MEDIAN = 0.6745  # of the absolute value of a standard normal number


def explains(problem: Problem, found: AtomSet) -> bool:
    """Whether noise and model error account for what is left over, but for one reading in 1e4."""
    from scipy.special import chdtri

    squares = np.square(problem.left(found.predicted) * problem.white).sum()
    return bool(squares <= chdtri(_freedom(found, problem.heard), ODD))


def _freedom(found: AtomSet, taxels: int) -> int:
    return max(taxels - int(found.free.sum()), 1)


def noise_scale(problem: Problem, found: AtomSet, scale: float, most: int) -> float:
    """By how much the noise differs from what is assumed, by what the atoms leave over; or 1.

    `scale` is what is assumed already, in terms of what was stated. It is less where the squares
    are far fewer than the taxels: of all taxels, and of those that see a contact, the larger of the
    two, so that taxels that always read zero do not speak for the others. It is more where the
    atoms do not explain the readings and taxels that see none of them are as restless: what they
    read is no touch. Where as many atoms as there may be (`most`) do not explain the readings, all
    taxels tell it.
    """
    left = problem.left(found.predicted) * problem.white
    seen = (np.abs(found.predicted) * problem.white > 1.0) | (problem.white <= 0.0)
    if not explains(problem, found):
        if len(found) >= most:
            left, seen = problem.left(np.zeros(len(left))) * problem.white, problem.white <= 0.0
        typical = _typical(left[~seen]) if np.count_nonzero(~seen) >= UNSEEN else 1.0
        return typical if LOUD < typical <= LOUDEST / scale else 1.0
    if not len(found):
        return 1.0
    squares, parameters = np.square(left), int(found.free.sum())
    share = float(squares.sum()) / _freedom(found, problem.heard)
    seen &= problem.white > 0.0
    if seen.sum() > parameters + 2:
        share = max(share, float(squares[seen].sum()) / (int(seen.sum()) - parameters))
    enough = QUIET if scale <= 1.0 else CALM
    return 1.0 if share > enough else max(float(np.sqrt(share)), QUIETEST / scale)


def _typical(left: Floats) -> float:
    """Deviation by the median of the absolute values, which a few large ones do not move."""
    return float(np.median(np.abs(left))) / NORMAL_MEDIAN


def significant(false_alarm_rate: float, taxels: int) -> float:
    """Gain in cost that noise exceeds at this rate: three parameters at as many places as taxels.

    Half the quantile of chi-squared with three degrees of freedom (Wilks 1938).
    """
    from scipy.special import chdtri

    return 0.5 * float(chdtri(3, false_alarm_rate / taxels))
