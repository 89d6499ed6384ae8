"""Relaxation of the elastomer, by what taxels go on reading where a touch has been.

Nothing presses once a touch is gone: what is read then is what the layer remembers, in the pattern
of the touch, whose place and contact are known. So each reading from a touch on until the next
gives one amplitude, that of the deformation in units of the touch; and the solid is sought whose
inverse (see `signal.creep`) makes nothing of all those after release. How hard and how steadily
somebody pressed does not matter.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.calibrate.press_tables import PressTables
from skinfield.calibrate.touch_fit import readings
from skinfield.elastic import BaseStress, StandardLinearSolid
from skinfield.errors import Floats
from skinfield.signal.creep import CreepCompensation

PARTS = np.array([0.01, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1.0, 1.15, 1.4, 2.0])
MOST = 1.8  # of a touch, in those that go on to more than `PARTS` know
GROWTH = 0.3  # exponent by which a contact's radius grows with the force, as of a ball
GONE = 0.4  # of a touch: less is what is left of it, once it has gone
CLEAR, FEWEST = 3, 8  # readings before the next touch, in which it may come; after release, to tell
EARLIER = 10  # readings before a touch, by which what was left before is known
REST = 0.25  # of the noise: how well the rest of taxels is known, as `touch_presses` has it
SEEN, BEGUN = 0.5, 0.05  # of what a touch tells; of its amplitude, below which it has not begun
UNLIKE, ELSE = 0.2, 4.0  # part by which patterns may be off, and deviations: more is another touch
SHARES, TIMES = (1e-3, 0.6), (0.02, 60.0)  # that are sought
STARTS = (0.1, 1.0, 8.0)  # s
ROBUST = 3.0  # deviations, from which on a reading counts less
SURE, SURE_TIME = 4.0, 0.5  # deviations of the share from 0, and of ln time: else nothing is told
FADES, LONG = 1.25, 5  # retardation times without a touch, after so many touches at least
MODEL = np.array([0.05, 0.05])  # of share and time: parts that patterns are off by
NS = 1e9


@dataclass(frozen=True)
class Relaxation:
    """What touches say of the relaxation.

    Attributes
    ----------
    solid : StandardLinearSolid
    share_std : float
        Of 1 - E∞ / E₀.
    time_std : float, s
        Of the time constant.
    touches : int
        That were followed after their release.
    """

    solid: StandardLinearSolid
    share_std: float
    time_std: float
    touches: int


class Trace(NamedTuple):
    """Amplitudes (T,) of one touch at times (T,) ns, from which on it is gone, and their noise.

    And that before it: what touches before it have left.
    """

    stamps: NDArray[np.int64]
    amplitude: Floats
    gone: int
    noise: float
    before: float = 0.0


def traces(
    table: Floats,
    stamps: NDArray[np.int64],
    row: NDArray[np.int64],
    touches: Floats,
    skin: Floats,
    gain: Floats,
    noise: Floats,
    places: tuple[PressTables, Floats],
) -> list[Trace]:
    """Amplitudes of touches and of what they leave.

    Parameters
    ----------
    table : (T, L) array
        Readings above rest.
    stamps : (T,) array, ns
    row : (T,) array
        Touch that each reading is part of; -1 of none.
    touches, skin : (P, 4) and (2,) arrays
        As `touch_fit.State` has them; NaN of touches that are not known.
    gain, noise : (L,) arrays
    places : tuple
        Tables of presses, and taxels (L, 2).
    """
    found, marked = [], np.flatnonzero(row >= 0)
    for press in np.flatnonzero(np.isfinite(touches).all(axis=1)):
        mine = np.flatnonzero(row == press)
        before, after = marked[marked < mine[0]], marked[marked > mine[-1]]
        first = before[-1] + CLEAR if len(before) else 0
        last = after[0] - CLEAR if len(after) else len(table)
        turned = np.flatnonzero(np.diff(stamps[mine[-1] : last]) <= 0)
        last = mine[-1] + 1 + turned[0] if len(turned) else last  # another recording
        turned = np.flatnonzero(np.diff(stamps[first : mine[0] + 1]) <= 0)
        first = first + 1 + turned[-1] if len(turned) else first
        part = slice(int(first), int(last))
        if last <= mine[-1] + FEWEST or first >= mine[0]:
            continue
        trace = _trace(table[part], stamps[part], mine[-1] - int(first), touches[press], skin,
                       gain, noise, places)  # fmt: skip
        if trace is not None:
            found.append(trace)
    return found


def _trace(
    table: Floats,
    stamps: NDArray[np.int64],
    last: int,
    touch: Floats,
    skin: Floats,
    gain: Floats,
    noise: Floats,
    places: tuple[PressTables, Floats],
) -> Trace | None:
    """Amplitudes of one touch, which stands until the reading `last`; None if it tells nothing."""
    tables, taxels = places
    log = np.log(PARTS)[:, None]
    held = np.repeat(touch[None], len(PARTS), axis=0)
    held[:, 2:3] += log
    grown = held.copy()
    grown[:, 3:] += GROWTH * log
    loads, left = (readings(tables, each, skin, taxels) * gain for each in (grown, held))
    whole, heard = loads[PARTS == 1.0][0], np.isfinite(table)
    weight = np.where(heard, whole / noise**2, 0.0)
    scale = weight @ whole
    seen = scale > SEEN * float(np.square(whole / noise).sum())
    if not seen[last]:
        return None
    rows, unit = np.nan_to_num(table), weight[last] / scale[last]
    along = np.sum(weight * rows, axis=1) / np.where(seen, scale, np.nan)
    pressed, remains = _inverse(along, loads @ unit), _inverse(along, left @ unit)
    drop = np.flatnonzero(pressed[last:] < GONE)
    if not len(drop):
        return None
    gone = last + int(drop[0]) + 1
    pattern = left[0] / PARTS[0]
    away = np.where(heard, rows - remains[:, None] * pattern, 0.0)
    spread = noise**2 + (UNLIKE * remains[:, None] * whole) ** 2
    count = heard.sum(axis=1)
    other = np.sum(away**2 / spread, axis=1) > count + ELSE * np.sqrt(2.0 * count)
    others = np.flatnonzero(other[gone:])
    end = gone + max(int(others[0]) - CLEAR, 0) if len(others) else len(table)
    begun = np.flatnonzero(~(pressed[:last] > BEGUN))
    begin = int(begun[-1]) if len(begun) else 0
    if pressed[begin:gone].max() > MOST:  # it is what a touch has left, and no touch
        return None
    earlier = remains[max(begin + 1 - EARLIER, 0) : begin + 1]
    earlier = earlier[np.isfinite(earlier)]
    joined = np.where(np.arange(len(along)) < gone, pressed, remains)
    good = np.isfinite(joined)
    good[:begin] = good[end:] = False
    if good[gone:].sum() < FEWEST:
        return None
    slope = PARTS[0] / float(left[0] @ unit)
    noise_of_part = slope / float(np.sqrt(scale[last]))
    left_before = float(earlier.mean()) if len(earlier) >= CLEAR else 0.0
    known = stamps[good], joined[good], int(good[:gone].sum()), noise_of_part
    return Trace(*known, left_before)


def _inverse(along: Floats, known: Floats) -> Floats:
    """Parts that read as along (T,), of what `PARTS` read; straight on below the least."""
    low = along * (PARTS[0] / known[0])
    return np.asarray(np.where(along < known[0], low, np.interp(along, known, PARTS)))


def relaxation(found: list[Trace]) -> Relaxation | None:
    """Solid that leaves nothing after release; None where touches do not tell one."""
    from scipy.optimize import least_squares

    if not found:
        return None
    low, high = np.array([SHARES, np.log(TIMES)]).T

    def left(sought: Floats) -> Floats:
        return np.concatenate([_left(each, *sought) for each in found])

    best: Any = None
    for start in STARTS:
        tried = least_squares(
            left, [0.1, np.log(start)], bounds=(low, high), loss="soft_l1", f_scale=ROBUST,
            x_scale=[0.05, 0.3], diff_step=[1e-3, 1e-3],
        )  # fmt: skip
        best = tried if best is None or tried.cost < best.cost else best
    count = len(best.fun) - len(found)
    larger = max(2.0 * best.cost / max(count - 2, 1), 1.0)  # than noise makes it
    gram = best.jac.T @ best.jac
    if np.linalg.cond(gram) > 1e12:
        return None
    share, log_time = best.x
    deviation = np.sqrt(larger * np.diag(np.linalg.inv(gram)))
    spans = np.array([np.ptp(each.stamps[each.gone :]) for each in found]) / NS
    long = np.sum(spans > FADES * np.exp(log_time) / (1.0 - share))
    inside = SHARES[0] < share < SHARES[1] and TIMES[0] * 1.01 < np.exp(log_time) < TIMES[1] * 0.99
    sure = share > SURE * deviation[0] and deviation[1] < SURE_TIME and long >= LONG
    if not inside or not sure:
        return None
    deviation = np.hypot(deviation, MODEL * [share, 1.0])
    solid = StandardLinearSolid(1.0 - float(share), float(np.exp(log_time)))
    time_std = solid.time_constant * float(deviation[1])
    return Relaxation(solid, float(deviation[0]), time_std, len(found))


def _left(trace: Trace, share: float, log_time: float) -> Floats:
    """What a solid leaves of a trace after release, in deviations, and how far off rest is."""
    solid = StandardLinearSolid(1.0 - float(share), float(np.exp(log_time)))
    creep = CreepCompensation.of(solid, 1, BaseStress())
    since = trace.stamps - trace.stamps[0] + int(NS)  # a stamp of 0 is none
    creep.go_on_from(np.array([trace.before / share]), int(since[0]))
    table = trace.amplitude[:, None]
    freed = creep.taken(table, np.ones(table.shape, np.bool_), since)[trace.gone :, 0]
    off = freed / trace.noise
    rest = float(off.sum()) / (len(off) + REST**-2)
    return np.append(off - rest, rest / REST)
