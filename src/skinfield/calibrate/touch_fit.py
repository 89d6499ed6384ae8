"""Joint fit of presses and of the skin that reads them (Gauss-Newton with a Schur complement).

Each press has four parameters of its own: x, y, ln force, ln radius of contact. All share ln
thickness, Poisson's ratio and the logarithm of each taxel's gain. The presses' parameters are
eliminated press by press (Triggs et al. 2000, Bundle adjustment), so the cost grows with their
number only linearly. How far readings are trusted follows from the readings, not from what is
predicted of them, so that least squares stay least squares from step to step.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skinfield.calibrate.press_tables import RADII, RATIOS, PressTables
from skinfield.elastic import Quantity
from skinfield.errors import Floats
from skinfield.solve.atoms.atom_readings import predict

OWN, SHARED = 4, 2
GAIN_STD = 0.15  # of ln gain, before any press
THICKNESS_STD = 0.5  # of ln thickness
RATIO_STD = 0.15
FORCE_STD, RADIUS_STD = 3.0, 0.8  # of ln force and ln radius, about the presses' medians
PLACE_STD = 0.1  # m, about where a press started
COMMON = 1e-5  # to which the mean of ln gains is 0
BESIDE = 0.03  # part of the highest reading that the model error is a part of anywhere
STEP = np.array([0.02, 0.004])  # for derivatives by ln thickness and Poisson's ratio
STARTS = (0.35, 0.7, 1.4)  # radii of contact in thicknesses
PEAK = 0.15  # of the highest reading, above which taxels tell the place
LONGEST = np.array([3e-3, 3e-3, 1.0, 0.5])  # step of a press
LONGEST_SKIN = np.array([0.15, 0.03])
ALONE, TOGETHER = 25, 40  # steps at most
DONE = 1e-3  # gain in cost of the last step, per press


@dataclass(frozen=True, eq=False)
class Data:
    """Readings of presses.

    Attributes
    ----------
    readings : (T, L) array
        0 where not heard.
    heard : (T, L) bool array
    noise : (L,) array
    taxels : (L, 2) array, m
    quantity : Quantity
    """

    readings: Floats
    heard: NDArray[np.bool_]
    noise: Floats
    taxels: Floats
    quantity: Quantity

    def only(self, kept: NDArray[np.bool_]) -> "Data":
        """Data of some presses."""
        return replace(self, readings=self.readings[kept], heard=self.heard[kept])

    def variance(self, error: float) -> Floats:
        """Of readings (T, L): noise, and a model that is wrong by a part of what is read."""
        beside = BESIDE * np.abs(self.readings).max(axis=1, keepdims=True)
        return np.asarray(self.noise**2 + error**2 * (self.readings**2 + beside**2))

    def weight(self, error: float) -> Floats:
        """Inverse variances (T, L), 0 where not heard."""
        return np.where(self.heard, 1.0 / self.variance(error), 0.0)


@dataclass(frozen=True, eq=False)
class State:
    """What is sought.

    Attributes
    ----------
    touches : (T, 4) array
        x and y in m, ln(force/N), ln(radius/m).
    skin : (2,) array
        ln(thickness/m) and Poisson's ratio.
    log_gain : (L,) array
    """

    touches: Floats
    skin: Floats
    log_gain: Floats


def read(
    tables: PressTables, touches: Floats, skin: Floats, taxels: Floats
) -> tuple[Floats, Floats]:
    """Readings (T, L) of presses without gains, and derivatives (T, 4, L)."""
    thickness = float(np.exp(skin[0]))
    table, family = tables.at(skin[0], skin[1]), np.zeros(1, np.int64)
    atoms = np.zeros((len(touches), 1, 6))
    atoms[:, 0, :2] = touches[:, :2] / thickness
    atoms[:, 0, 2] = touches[:, 2]
    atoms[:, 0, 3] = touches[:, 3] - skin[0]
    places = np.ascontiguousarray(taxels / thickness)
    out, slopes = np.empty((len(touches), len(taxels))), np.empty((len(touches), OWN, len(taxels)))
    room = np.empty((1, 6, len(taxels)))
    for row, atom in enumerate(atoms):
        predict(atom, family, places, table, out[row], room)
        slopes[row] = room[0, :OWN]
    slopes[:, :2] /= thickness
    return out, slopes


def start(data: Data, tables: PressTables, state: State, error: float) -> Floats:
    """Each press for itself (T, 4), from several radii, for a skin that is taken to be known."""
    rows = np.arange(len(data.readings))
    peak = np.argmax(np.where(data.heard, data.readings, -np.inf), axis=1)
    top = data.readings[rows, peak]
    weight = np.where(data.heard, np.maximum(data.readings - PEAK * top[:, None], 0.0), 0.0)
    middle = weight @ data.taxels / weight.sum(axis=1, keepdims=True)
    linear = data.quantity.linearise
    wanted = linear(top, np.empty_like(top))
    tried = []
    for radius in STARTS:
        touches = np.empty((len(middle), OWN))
        touches[:, :2] = 0.5 * (middle + data.taxels[peak])
        touches[:, 2], touches[:, 3] = -1.0, state.skin[0] + np.log(radius)
        for _ in range(6):
            found = read(tables, touches, state.skin, data.taxels)[0].max(axis=1)
            found = np.maximum(linear(found, np.empty_like(found)), 1e-9 * wanted)
            touches[:, 2] += np.clip(np.log(wanted / found), -5.0, 5.0)
        tried.append(alone(data, tables, replace(state, touches=touches), error))
    best = np.argmin([cost for _, cost in tried], axis=0)
    return np.array([touches for touches, _ in tried])[best, rows]


def alone(data: Data, tables: PressTables, state: State, error: float) -> tuple[Floats, Floats]:
    """Refine each press for itself; the presses (T, 4), and their costs (T,)."""
    weight, gain = data.weight(error), np.exp(state.log_gain)
    prior = np.array([PLACE_STD, PLACE_STD, FORCE_STD, RADIUS_STD]) ** -2.0
    touches = centre = state.touches
    damping = np.full(len(touches), 1e-2)

    def cost_of(touches: Floats) -> tuple[Floats, Floats, Floats]:
        predicted, slopes = read(tables, touches, state.skin, data.taxels)
        rest = data.readings - gain * predicted
        square = (weight * rest**2).sum(axis=1) + ((touches - centre) ** 2) @ prior
        return 0.5 * square, rest, gain * slopes

    costs, rest, slopes = cost_of(touches)
    for _ in range(ALONE):
        hessian = _blocks(slopes, weight) + np.diag(prior)
        downhill = np.einsum("til,tl->ti", slopes, weight * rest) - prior * (touches - centre)
        np.einsum("tii->ti", hessian)[:] *= 1.0 + damping[:, None]
        step = np.linalg.solve(hessian, downhill[..., None])[..., 0]
        tried = _moved(touches, step, state.skin)
        new, new_rest, new_slopes = cost_of(tried)
        better = new < costs
        gained = np.where(better, costs - new, 0.0).max()
        touches = np.where(better[:, None], tried, touches)
        costs = np.where(better, new, costs)
        rest[better], slopes[better] = new_rest[better], new_slopes[better]
        damping = np.where(better, damping * 0.3, np.minimum(damping * 5.0, 1e6))
        if better.any() and gained < DONE:
            break
    return touches, costs


def _blocks(slopes: Floats, weight: Floats) -> Floats:
    return (slopes * weight[:, None]) @ slopes.transpose(0, 2, 1)


def _moved(touches: Floats, step: Floats, skin: Floats) -> Floats:
    moved = touches + np.clip(step, -LONGEST, LONGEST)
    moved[:, 3] = np.clip(moved[:, 3], *(skin[0] + np.log(RADII)))
    return moved


@dataclass(frozen=True, eq=False)
class Normal:
    """Normal equations at a state, the presses eliminated.

    Attributes
    ----------
    schur : (2 + L, 2 + L) array
        Information on what is shared.
    downhill : (2 + L,) array
    own : (T, 4, 4) array
        Inverse of the presses' own blocks.
    own_downhill : (T, 4) array
    coupling : (T, 2 + L, 4) array
        Between what is shared and a press, times `own`.
    """

    schur: Floats
    downhill: Floats
    own: Floats
    own_downhill: Floats
    coupling: Floats


class JointFit:
    """Fit of presses and skin together.

    Parameters
    ----------
    data : Data
    tables : PressTables
    nominal : (2,) array
        ln thickness and Poisson's ratio about which the prior is.
    error : float
        Part of what taxels read by which the model is wrong.
    """

    def __init__(self, data: Data, tables: PressTables, nominal: Floats, error: float) -> None:
        self.data, self.tables, self.nominal = data, tables, nominal
        self.weight = data.weight(error)
        self._centre = np.zeros(2)

    def cost(self, state: State) -> float:
        """Half the weighted squares of residuals and of what priors say."""
        plain, _ = read(self.tables, state.touches, state.skin, self.data.taxels)
        rest = self.data.readings - plain * np.exp(state.log_gain)
        away = (state.skin - self.nominal) / (THICKNESS_STD, RATIO_STD)
        off = (state.touches[:, 2:] - self._centre) / (FORCE_STD, RADIUS_STD)
        total = float((self.weight * rest**2).sum()) + float(away @ away) + float((off**2).sum())
        return 0.5 * (total + float((state.log_gain**2).sum()) / GAIN_STD**2)

    def normal(self, state: State, damping: float = 0.0) -> Normal:
        """Normal equations at a state."""
        weight, gain = self.weight, np.exp(state.log_gain)
        plain, slopes = read(self.tables, state.touches, state.skin, self.data.taxels)
        predicted, slopes = plain * gain, slopes * gain
        rest = self.data.readings - predicted
        shared = self._skin_slopes(state) * gain  # (2, T, L)
        prior = np.array([PLACE_STD, PLACE_STD, FORCE_STD, RADIUS_STD]) ** -2.0
        hessian = _blocks(slopes, weight) + np.diag(prior)
        pull = np.einsum("til,tl->ti", slopes, weight * rest)
        pull[:, 2:] -= prior[2:] * (state.touches[:, 2:] - self._centre)
        np.einsum("tii->ti", hessian)[:] *= 1.0 + damping
        own = np.linalg.inv(hessian)
        size, count = SHARED + len(gain), len(plain)
        block = np.zeros((size, size))
        block[:2, :2] = np.einsum("itl,tl,jtl->ij", shared, weight, shared)
        block[:2, 2:] = np.einsum("itl,tl->il", shared, weight * predicted)
        block[2:, :2] = block[:2, 2:].T
        diagonal = np.einsum("ii->i", block)
        diagonal[2:] = (weight * predicted**2).sum(axis=0) + GAIN_STD**-2
        diagonal[:2] += np.array([THICKNESS_STD, RATIO_STD]) ** -2.0
        diagonal *= 1.0 + damping
        block[2:, 2:] += (COMMON * len(gain)) ** -2.0
        cross = np.empty((count, size, OWN))
        cross[:, :2] = np.einsum("itl,tl,tjl->tij", shared, weight, slopes)
        cross[:, 2:] = np.einsum("tl,tjl->tlj", weight * predicted, slopes)
        coupling = cross @ own
        flat = coupling.transpose(1, 0, 2).reshape(size, -1)
        schur = block - flat @ cross.transpose(1, 0, 2).reshape(size, -1).T
        downhill = np.empty(size)
        downhill[:2] = np.einsum("itl,tl->i", shared, weight * rest)
        downhill[:2] -= (state.skin - self.nominal) / np.square([THICKNESS_STD, RATIO_STD])
        downhill[2:] = (weight * rest * predicted).sum(axis=0) - state.log_gain / GAIN_STD**2
        downhill -= np.einsum("tij,tj->i", coupling, pull)
        return Normal((schur + schur.T) / 2.0, downhill, own, pull, coupling)

    def _skin_slopes(self, state: State) -> Floats:
        """Derivatives (2, T, L) by ln thickness and Poisson's ratio, without gains."""
        out = []
        for index, step in enumerate(STEP):
            sides = []
            for sign in (-1.0, 1.0):
                skin = state.skin.copy()
                skin[index] += sign * step
                sides.append(read(self.tables, state.touches, skin, self.data.taxels)[0])
            out.append((sides[1] - sides[0]) / (2.0 * step))
        return np.array(out)

    def run(self, state: State, steps: int = TOGETHER) -> State:
        """Go downhill (Levenberg 1944) until nothing is gained."""
        self._centre = np.median(state.touches[:, 2:], axis=0)
        damping, cost = 1e-3, self.cost(state)
        for _ in range(steps):
            tried = self._step(state, self.normal(state, damping))
            new = self.cost(tried)
            if new < cost:
                gained, state, cost, damping = cost - new, tried, new, damping * 0.2
                if gained < DONE * len(state.touches):
                    break
            elif damping > 1e4:
                break
            else:
                damping *= 10.0
        return state

    def _step(self, state: State, normal: Normal) -> State:
        schur, downhill = normal.schur.copy(), normal.downhill.copy()
        step = np.linalg.solve(schur, downhill)
        lows, highs = np.transpose([self.tables.range, RATIOS])
        for index in range(SHARED):  # at an end: stay there, and move the others
            place = state.skin[index]
            if (place >= highs[index] and step[index] > 0.0) or (
                place <= lows[index] and step[index] < 0.0
            ):
                schur[index], schur[:, index], downhill[index] = 0.0, 0.0, 0.0
                schur[index, index] = 1.0
                step = np.linalg.solve(schur, downhill)
        step *= min(1.0, *(LONGEST_SKIN / np.maximum(np.abs(step[:SHARED]), 1e-12)))
        own = np.einsum("tij,tj->ti", normal.own, normal.own_downhill)
        own -= np.einsum("tij,i->tj", normal.coupling, step)
        skin = np.clip(state.skin + step[:SHARED], lows, highs)
        log_gain = state.log_gain + step[SHARED:]
        return State(_moved(state.touches, own, skin), skin, log_gain - log_gain.mean())
