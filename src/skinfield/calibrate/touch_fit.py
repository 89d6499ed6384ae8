"""Joint fit of presses and of the skin that reads them (Gauss-Newton with a Schur complement).

Each press has four parameters of its own: x, y, ln force, ln radius of contact. All share ln
thickness, Poisson's ratio and the logarithm of each taxel's gain. The presses' parameters are
eliminated press by press (Triggs et al. 2000, Bundle adjustment), so the cost grows with their
number only linearly.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skinfield.calibrate.press_tables import BOUNDS, RATIOS, PressTables
from skinfield.errors import Floats
from skinfield.solve.atoms.atom_readings import predict

OWN, SHARED = 4, 2
GAIN_STD = 0.15  # of ln gain, before any press
THICKNESS_STD = 0.5  # of ln thickness
RATIO_STD = 0.15
RADIUS_STD = 0.8  # of ln radius, about the presses' median
FORCE_STD = 3.0  # of ln force, about where it started
COMMON = 1e-5  # to which the mean of ln gains is 0
BESIDE = 0.03  # part of the highest reading that the model error is a part of anywhere
STEP = np.array([0.02, 0.004])  # for derivatives by ln thickness and Poisson's ratio
STARTS = (0.35, 0.7, 1.4)  # radii of contact in thicknesses
ALONE, TOGETHER = 25, 40  # steps at most
DONE = 1e-3  # gain in cost of the last step


@dataclass(frozen=True, eq=False)
class Data:
    """Readings of presses.

    Attributes
    ----------
    readings : (T, L) array
    heard : (T, L) bool array
    noise : (L,) array
    taxels : (L, 2) array, m
    """

    readings: Floats
    heard: NDArray[np.bool_]
    noise: Floats
    taxels: Floats

    def only(self, kept: NDArray[np.bool_]) -> "Data":
        """Data of some presses."""
        return replace(self, readings=self.readings[kept], heard=self.heard[kept])


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


def variance(predicted: Floats, noise: Floats, error: float) -> Floats:
    """Of readings (T, L): noise, and what the model is wrong by."""
    beside = BESIDE * np.abs(predicted).max(axis=1, keepdims=True)
    return np.asarray(noise**2 + error**2 * (predicted**2 + beside**2))


def start(data: Data, tables: PressTables, skin: Floats, error: float) -> Floats:
    """Each press for itself (T, 4), for a skin that is taken to be known."""
    best, costs = np.zeros((0, OWN)), np.zeros(0)
    peak = np.argmax(np.where(data.heard, data.readings, -np.inf), axis=1)
    top = np.take_along_axis(data.readings, peak[:, None], axis=1)[:, 0]
    weight = np.where(data.heard, np.maximum(data.readings - 0.15 * top[:, None], 0.0), 0.0)
    middle = weight @ data.taxels / weight.sum(axis=1, keepdims=True)
    for radius in STARTS:
        touches = np.empty((len(middle), OWN))
        touches[:, :2] = 0.5 * (middle + data.taxels[peak])
        touches[:, 2], touches[:, 3] = -1.0, skin[0] + np.log(radius)
        for _ in range(6):
            found = read(tables, touches, skin, data.taxels)[0].max(axis=1)
            found, wanted = found / (1.0 + found), top / (1.0 + top)
            touches[:, 2] += np.clip(np.log(wanted / np.maximum(found, 1e-9)), -2.0, 2.0)
        touches, cost = alone(data, tables, skin, touches, error)
        if not len(best):
            best, costs = touches, cost
        better = cost < costs
        best[better], costs[better] = touches[better], cost[better]
    return best


def alone(
    data: Data, tables: PressTables, skin: Floats, touches: Floats, error: float
) -> tuple[Floats, Floats]:
    """Refine each press for itself; the presses (T, 4), and their costs (T,)."""
    spread = variance(data.readings, data.noise, error)
    weight = np.where(data.heard, 1.0 / spread, 0.0)
    prior = np.array([1e2, 1e2, FORCE_STD**-2, RADIUS_STD**-2])
    centre = touches.copy()
    damping = np.full(len(touches), 1e-2)

    def cost_of(touches: Floats) -> tuple[Floats, Floats, Floats]:
        predicted, slopes = read(tables, touches, skin, data.taxels)
        rest = data.readings - predicted
        square = (weight * rest**2).sum(axis=1) + ((touches - centre) ** 2) @ prior
        return 0.5 * square, rest, slopes

    costs, rest, slopes = cost_of(touches)
    for _ in range(ALONE):
        hessian = np.einsum("til,tl,tjl->tij", slopes, weight, slopes) + np.diag(prior)
        downhill = np.einsum("til,tl->ti", slopes, weight * rest) - prior * (touches - centre)
        diagonal = np.einsum("tii->ti", hessian)
        diagonal *= 1.0 + damping[:, None]
        step = np.linalg.solve(hessian, downhill[..., None])[..., 0]
        tried = _bounded(
            touches + np.clip(step, [-4e-3, -4e-3, -1, -0.5], [4e-3, 4e-3, 1, 0.5]), skin
        )
        new, new_rest, new_slopes = cost_of(tried)
        better = new < costs
        gain = np.where(better, costs - new, 0.0).max()
        touches = np.where(better[:, None], tried, touches)
        costs = np.where(better, new, costs)
        rest[better], slopes[better] = new_rest[better], new_slopes[better]
        damping = np.where(better, damping * 0.3, np.minimum(damping * 5.0, 1e6))
        if better.any() and gain < DONE:
            break
    return touches, costs


def _bounded(touches: Floats, skin: Floats) -> Floats:
    low, high = skin[0] + np.log(BOUNDS)
    touches[:, 3] = np.clip(touches[:, 3], low, high)
    return touches


@dataclass(frozen=True, eq=False)
class Normal:
    """Normal equations at a state, the presses eliminated.

    Attributes
    ----------
    cost : float
    evidence : float
        Logarithm of the marginal likelihood (Laplace), up to a constant.
    schur : (2 + L, 2 + L) array
    squares : (T, L) array
        Residuals over their standard deviation, squared; 0 where not heard.
    predicted : (T, L) array
        With gains.
    own : (T, 4, 4) array
        Inverse of the presses' own blocks.
    coupling : (T, 2 + L, 4) array
        Between what is shared and a press, times `own`.
    """

    cost: float
    evidence: float
    schur: Floats
    squares: Floats
    predicted: Floats
    own: Floats
    coupling: Floats
    downhill: Floats
    own_downhill: Floats


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
        self.data, self.tables, self.nominal, self.error = data, tables, nominal, error
        self.force, self.radius = 0.0, 0.0

    def aim(self, state: State) -> None:
        """Take the medians of the presses as the middle of their priors."""
        self.force, self.radius = np.median(state.touches[:, 2:], axis=0)

    def _residuals(self, state: State) -> tuple[Floats, Floats, Floats, float]:
        """Prediction without gains, slopes, weights, and cost by them."""
        data = self.data
        plain, slopes = read(self.tables, state.touches, state.skin, data.taxels)
        predicted = plain * np.exp(state.log_gain)
        spread = variance(predicted, data.noise, self.error)
        weight = np.where(data.heard, 1.0 / spread, 0.0)
        rest = data.readings - predicted
        cost = 0.5 * float((weight * rest**2 + np.where(data.heard, np.log(spread), 0.0)).sum())
        return plain, slopes, weight, cost + self._prior(state)

    def _prior(self, state: State) -> float:
        away = (state.skin - self.nominal) / (THICKNESS_STD, RATIO_STD)
        total = float(away @ away) + float((state.log_gain**2).sum()) / GAIN_STD**2
        total += float(((state.touches[:, 2] - self.force) ** 2).sum()) / FORCE_STD**2
        total += float(((state.touches[:, 3] - self.radius) ** 2).sum()) / RADIUS_STD**2
        return 0.5 * total

    def normal(self, state: State, damping: float = 0.0) -> Normal:
        """Normal equations at a state."""
        data, gain = self.data, np.exp(state.log_gain)
        plain, slopes, weight, cost = self._residuals(state)
        predicted = plain * gain
        rest = np.where(data.heard, data.readings - predicted, 0.0)
        slopes = slopes * gain
        shared = self._skin_slopes(state) * gain  # (2, T, L)
        prior = np.array([1.0, 1.0, FORCE_STD**-2, RADIUS_STD**-2])
        hessian = np.einsum("til,tl,tjl->tij", slopes, weight, slopes) + np.diag(prior)
        centre = np.array([self.force, self.radius])
        pull = np.einsum("til,tl->ti", slopes, weight * rest)
        pull[:, 2:] -= prior[2:] * (state.touches[:, 2:] - centre)
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
        taxels = size - SHARED
        block[2:, 2:] += (COMMON * taxels) ** -2.0
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
        schur = (schur + schur.T) / 2.0
        volume = float(np.linalg.slogdet(schur)[1] - np.linalg.slogdet(own)[1].sum())
        squares = weight * rest**2
        return Normal(
            cost, -cost - 0.5 * volume, schur, squares, predicted, own, coupling, downhill, pull
        )

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
        self.aim(state)
        damping, cost = 1e-3, self._residuals(state)[3]
        for _ in range(steps):
            tried = self._step(state, self.normal(state, damping))
            new = self._residuals(tried)[3]
            if new < cost:
                gained, state, cost, damping = cost - new, tried, new, damping * 0.2
                if gained < DONE * np.sqrt(len(state.touches)):
                    break
            elif damping > 1e4:
                break
            else:
                damping *= 10.0
        return state

    def _step(self, state: State, normal: Normal) -> State:
        schur, downhill = normal.schur.copy(), normal.downhill.copy()
        highest, lowest = RATIOS[-1], RATIOS[0]
        at_end = state.skin[1] >= highest and np.linalg.solve(schur, downhill)[1] > 0.0
        if at_end:  # stay there, and move the others
            schur[1], schur[:, 1], schur[1, 1], downhill[1] = 0.0, 0.0, 1.0, 0.0
        step = np.linalg.solve(schur, downhill)
        step *= min(1.0, *(np.array([0.15, 0.03]) / np.maximum(np.abs(step[:2]), 1e-12)))
        own = np.einsum("tij,tj->ti", normal.own, normal.own_downhill)
        own -= np.einsum("tij,i->tj", normal.coupling, step)
        skin = state.skin + step[:2]
        skin[1] = np.clip(skin[1], lowest, highest)
        log_gain = state.log_gain + step[2:]
        own = np.clip(own, [-3e-3, -3e-3, -1.0, -0.5], [3e-3, 3e-3, 1.0, 0.5])
        return State(_bounded(state.touches + own, skin), skin, log_gain - log_gain.mean())
