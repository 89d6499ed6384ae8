"""What no taxel reads: less than pressure beside it can take away."""

import numpy as np

from skinfield.conditioning import Convention
from skinfield.errors import Floats

RISEN = 0.1  # of the capacitance: more than a layer rises beside the hardest press of a finger
SURE = 6.0  # standard deviations, of boards that are noisier


def lowest_change(board: Convention | None, calibration: Floats) -> float:
    """Least ΔC/C₀ of counts that is believed.

    A taxel that reads less was touched when its baseline was taken, or its baseline has gone.
    Pressure cannot push it there: to explain it by what rises beside a press takes ten times the
    force that was let go. So it is left out, as at the end of a board's scale: an iCub's ends 15
    bytes beyond its rest. Boards that clip at their rest never read less.

    Parameters
    ----------
    board : Convention or None
        None where nobody says what a count means.
    calibration : (N, 4) array
        Of the taxels that live, see `Tared`.
    """
    if not len(calibration):
        return -np.inf
    beyond = np.nan if board is None else _beyond_rest(board)
    if beyond == 0.0:
        return -np.inf
    gain = np.abs(calibration[:, 1])
    if np.isfinite(beyond):
        return -beyond / float(gain.min())
    return -max(RISEN, SURE * float(np.median(calibration[:, 2] / gain)))


def _beyond_rest(board: Convention) -> float:
    """Counts from a board's rest to the end of its scale on the unloaded side; NaN: not known."""
    unloaded = board.highest if board.direction < 0 else board.lowest
    return -board.direction * (unloaded - board.rest)
