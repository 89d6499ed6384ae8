"""What atoms leave over of a reading: noise, less or more than was stated, or more contacts."""

import numpy as np

from skinfield.errors import Floats
from skinfield.inverse.atoms.problem import AtomSet, Problem

ODD = 1e-4  # readings that contacts explain, and that are taken not to be explained
QUIETEST = 1e-3  # of the stated noise, that is believed
QUIET = 0.25  # of the expected squares of residuals: below, there is less noise than was stated
CALM = 0.7  # the same, where more noise than was stated had been assumed
RESTLESS = 2.0  # times the stated noise on most taxels: contacts, or more noise than was stated
LOUD = 1.2  # times the stated noise, from which it is taken to be more
NORMAL_MEDIAN = 0.6745  # of the absolute value of a standard normal number


def explains(problem: Problem, found: AtomSet) -> bool:
    """Whether noise and model error account for what is left over, but for one reading in 1e4."""
    from scipy.special import chdtri

    squares = np.square(problem.left(found.predicted) * problem.white).sum()
    return bool(squares <= chdtri(len(problem.readings), ODD))


def noise_scale(problem: Problem, found: AtomSet, scale: float) -> float:
    """By how much the noise differs from what is assumed, by what the atoms leave over; or 1.

    `scale` is what is assumed already, in terms of what was stated.

    It is less where the squares are far fewer than the taxels: of all taxels, and of those that see
    a contact, the larger of the two, so that taxels that always read zero do not speak for the
    others. It is more where the atoms do not explain the readings and the median of what is left is
    as large on most taxels: a few large ones are no noise.
    """
    left = problem.left(found.predicted) * problem.white
    if not explains(problem, found):
        typical = _typical(left)
        return typical if typical > LOUD else 1.0
    if not len(found):
        return 1.0
    squares, parameters = np.square(left), int(found.free.sum())
    seen = np.abs(found.predicted) * problem.white > 1.0
    share = float(squares.sum()) / max(len(squares) - parameters, 1)
    if seen.sum() > parameters + 2:
        share = max(share, float(squares[seen].sum()) / (int(seen.sum()) - parameters))
    enough = QUIET if scale <= 1.0 else CALM
    return 1.0 if share > enough else max(float(np.sqrt(share)), QUIETEST / scale)


def first_scale(problem: Problem) -> float:
    """Noise to begin with, in terms of what was stated: more if most taxels read far more.

    Contacts that most taxels see look the same; what they explain is taken off the noise again.
    """
    typical = _typical(problem.left(np.zeros(len(problem.readings))) * problem.white)
    return typical if typical > RESTLESS else 1.0


def _typical(left: Floats) -> float:
    """Deviation by the median of the absolute values, which a few large ones do not move."""
    return float(np.median(np.abs(left))) / NORMAL_MEDIAN


def significant(false_alarm_rate: float, taxels: int) -> float:
    """Gain in cost that noise exceeds at this rate: three parameters at as many places as taxels.

    Half the quantile of chi-squared with three degrees of freedom (Wilks 1938).
    """
    from scipy.special import chdtri

    return 0.5 * float(chdtri(3, false_alarm_rate / taxels))
