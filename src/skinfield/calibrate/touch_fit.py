"""Joint fit of presses and of the skin that reads them (Gauss-Newton with a Schur complement).

Each press has four parameters of its own: x, y, ln force, ln radius of contact. All share ln
thickness, Poisson's ratio and the logarithm of each taxel's gain. The presses' parameters are
eliminated press by press (Triggs et al. 2000, Bundle adjustment), so the cost grows with their
number only linearly. How far readings are trusted follows from the readings, not from what is
predicted of them, so that least squares stay least squares from step to step.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from skinfield.calibrate.press_tables import RADII, RATIOS, PressTables
from skinfield.elastic import Quantity
from skinfield.errors import Floats
from skinfield.solve.atoms.atom_readings import predict

OWN, SHARED = 4, 2
GAIN_STD, GAIN_LEAST = 0.15, 0.01  # of ln gain, before any press, and after
THICKNESS_STD = 0.5  # of ln thickness
RATIO_STD = 0.15
FORCE_STD, RADIUS_STD = 3.0, 0.8  # of ln force and ln radius, before any press
PLACE_STD = 1.0  # m
COMMON = 1e-5  # to which the mean of ln gains is 0
BESIDE = 0.03  # part of the highest reading that the model error is a part of anywhere
STEP = np.array([0.02, 0.004])  # for derivatives by ln thickness and Poisson's ratio
STARTS = (0.35, 0.7, 1.4)  # radii of contact in thicknesses
AROUND, AWAY = 12, (0.3, 0.6, 0.9)  # places about the highest reading: in directions, and pitches
MATCHES, REFINED = 2, 8
PEAK = 0.15  # of the highest reading, above which taxels tell the place
LONGEST = np.array([3e-3, 3e-3, 1.0, 0.5])  # step of a press
LONGEST_SKIN = np.array([0.15, 0.03])
ALONE, FOLLOW, TOGETHER = 25, 4, 40  # steps at most
DONE = 1e-2  # gain in cost of the last step
DAMPING = 1e-6  # to begin with: the valley between thickness, gains and forces is long and flat


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
    """Readings (T, L) of presses without gains, and derivatives (T, 4, L).

    Beyond the radii that are tabulated, readings stay: smaller contacts look the same.
    """
    thickness = float(np.exp(skin[0]))
    table, family = tables.at(skin[0], skin[1]), np.zeros(1, np.int64)
    atoms = np.zeros((len(touches), 1, 6))
    atoms[:, 0, :2] = touches[:, :2] / thickness
    atoms[:, 0, 2] = touches[:, 2]
    wanted = touches[:, 3] - skin[0]
    atoms[:, 0, 3] = np.clip(wanted, *np.log(RADII))
    places = np.ascontiguousarray(taxels / thickness)
    out, slopes = np.empty((len(touches), len(taxels))), np.empty((len(touches), OWN, len(taxels)))
    room = np.empty((1, 6, len(taxels)))
    for row, atom in enumerate(atoms):
        predict(atom, family, places, table, out[row], room)
        slopes[row] = room[0, :OWN]
    slopes[:, :2] /= thickness
    slopes[atoms[:, 0, 3] != wanted, 3] = 0.0
    return out, slopes


@dataclass(frozen=True, eq=False)
class Priors:
    """What gains and presses are like, as those of this skin show (empirical Bayes).

    Attributes
    ----------
    skin : (2,) array
        ln thickness and Poisson's ratio, in the middle.
    gain_std : float
        Of ln gain.
    centre : (2,) array, or (T, 2)
        Of ln force and ln radius.
    precision : (2, 2) array
        Inverse of their covariance.
    """

    skin: Floats
    gain_std: float
    centre: Floats
    precision: Floats

    @classmethod
    def wide(cls, skin: Floats, centre: Floats) -> "Priors":
        """Before presses have shown anything."""
        return cls(skin, GAIN_STD, centre, np.diag([FORCE_STD**-2.0, RADIUS_STD**-2.0]))

    @cached_property
    def block(self) -> Floats:
        """Information (4, 4) on each press."""
        block = np.eye(OWN) / PLACE_STD**2
        block[2:, 2:] = self.precision
        return block

    def pull(self, touches: Floats) -> Floats:
        """By which presses (T, 4) are drawn to what is usual."""
        out = np.zeros_like(touches)
        out[:, 2:] = (self.centre - touches[:, 2:]) @ self.precision
        return out

    def squares(self, touches: Floats) -> Floats:
        """Of each press's distance (T,) from what is usual, in deviations."""
        off = touches[:, 2:] - self.centre
        return np.asarray(((off @ self.precision) * off).sum(axis=1))

    def updated(self, state: State, normal: "Normal") -> "Priors":
        """As the most likely ones are, given a fit with these (Dempster, Laird and Rubin 1977)."""
        spread = np.linalg.inv(normal.schur)
        gains = state.log_gain**2 + np.diag(spread)[SHARED:]
        centre = state.touches[:, 2:].mean(axis=0)
        off = state.touches[:, 2:] - centre
        joint = normal.coupling[:, :, 2:]
        own = normal.own[:, 2:, 2:] + joint.transpose(0, 2, 1) @ spread @ joint
        covariance = (off.T @ off) / len(off) + own.mean(axis=0)
        gain_std = max(float(np.sqrt(gains.mean())), GAIN_LEAST)
        return Priors(self.skin, gain_std, centre, np.linalg.inv(covariance))


def start(data: Data, tables: PressTables, state: State, error: float) -> Floats:
    """Each press for itself (T, 4), for a skin that is taken to be known.

    Readings have many minima between and beside taxels: the best of many places and radii, by the
    force that explains most, are refined.
    """
    rows, weight = np.arange(len(data.readings)), data.weight(error)
    peak = np.where(data.heard, data.readings, -np.inf).argmax(axis=1)
    above = np.maximum(data.readings - PEAK * data.readings[rows, peak, None], 0.0)
    above = np.where(data.heard, above, 0.0)
    middle = above @ data.taxels / above.sum(axis=1, keepdims=True)
    apart, _ = cKDTree(data.taxels).query(data.taxels, [2])
    pitch = float(np.median(apart))
    angles = 2.0 * np.pi * np.arange(AROUND) / AROUND
    circle = pitch * np.column_stack([np.cos(angles), np.sin(angles)])
    away = np.concatenate([np.zeros((1, 2)), *(part * circle for part in AWAY)])
    places = [middle, *(data.taxels[peak] + offset for offset in away)]
    tried, costs = [], []
    for radius in STARTS:
        for place in places:
            touches, cost = _matched(data, tables, state, weight, place, np.log(radius))
            tried.append(touches)
            costs.append(cost)
    best = np.argsort(costs, axis=0)[:REFINED]
    begins = [replace(state, touches=np.array(tried)[order, rows]) for order in best]
    usual = Priors.wide(state.skin, begins[0].touches[:, 2:])
    return refined(data, tables, begins, weight, usual).touches


def _matched(
    data: Data, tables: PressTables, state: State, weight: Floats, place: Floats, radius: float
) -> tuple[Floats, Floats]:
    """Presses (T, 4) at places with the force that explains most, and what is left (T,)."""
    linear, gain = data.quantity.linearise, np.exp(state.log_gain)
    wanted = linear(data.readings, np.empty_like(data.readings))
    touches = np.empty((len(place), OWN))
    touches[:, :2], touches[:, 2], touches[:, 3] = place, -2.0, state.skin[0] + radius
    for _ in range(MATCHES):
        found = gain * read(tables, touches, state.skin, data.taxels)[0]
        found = linear(found, np.empty_like(found))
        size = np.maximum((weight * found**2).sum(axis=1), 1e-300)
        factor = np.maximum((weight * found * wanted).sum(axis=1) / size, 1e-3)
        touches[:, 2] += np.log(factor)
    left = gain * read(tables, touches, state.skin, data.taxels)[0] - data.readings
    return touches, (weight * left**2).sum(axis=1)


def alone(
    data: Data, tables: PressTables, state: State, weight: Floats, priors: Priors, steps: int
) -> tuple[Floats, Floats]:
    """Refine each press for itself; the presses (T, 4), and their costs (T,)."""
    gain, touches = np.exp(state.log_gain), state.touches
    damping = np.full(len(touches), DAMPING)

    def cost_of(touches: Floats) -> tuple[Floats, Floats, Floats]:
        predicted, slopes = read(tables, touches, state.skin, data.taxels)
        rest = data.readings - gain * predicted
        square = (weight * rest**2).sum(axis=1) + priors.squares(touches)
        return 0.5 * square, rest, gain * slopes

    costs, rest, slopes = cost_of(touches)
    for _ in range(steps):
        hessian = _blocks(slopes, weight) + priors.block
        downhill = np.einsum("til,tl->ti", slopes, weight * rest) + priors.pull(touches)
        np.einsum("tii->ti", hessian)[:] *= 1.0 + damping[:, None]
        step = np.linalg.solve(hessian, downhill[..., None])[..., 0]
        tried = touches + np.clip(step, -LONGEST, LONGEST)
        new, new_rest, new_slopes = cost_of(tried)
        better = new < costs
        gained = np.where(better, costs - new, 0.0).max()
        touches = np.where(better[:, None], tried, touches)
        costs = np.where(better, new, costs)
        rest[better], slopes[better] = new_rest[better], new_slopes[better]
        damping = np.where(better, damping * 0.1, np.clip(damping * 10.0, 1e-3, 1e6))
        if better.any() and gained < DONE / 10.0:
            break
    return touches, costs


def refined(
    data: Data,
    tables: PressTables,
    begins: list[State],
    weight: Floats,
    priors: Priors,
    steps: int = ALONE,
) -> State:
    """Refine each press for itself, from the one of several beginnings that leads furthest down."""
    ends = [alone(data, tables, begin, weight, priors, steps) for begin in begins]
    best = np.argmin([cost for _, cost in ends], axis=0)
    touches = np.array([touches for touches, _ in ends])[best, np.arange(len(best))]
    return replace(begins[0], touches=touches)


def _blocks(slopes: Floats, weight: Floats) -> Floats:
    return (slopes * weight[:, None]) @ slopes.transpose(0, 2, 1)


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
    priors : Priors
    error : float
        Part of what taxels read by which the model is wrong.
    """

    def __init__(self, data: Data, tables: PressTables, priors: Priors, error: float) -> None:
        self.data, self.tables, self.priors = data, tables, priors
        self.weight = data.weight(error)

    def cost(self, state: State) -> float:
        """Half the weighted squares of residuals and of what priors say."""
        plain, _ = read(self.tables, state.touches, state.skin, self.data.taxels)
        rest = self.data.readings - plain * np.exp(state.log_gain)
        away = (state.skin - self.priors.skin) / (THICKNESS_STD, RATIO_STD)
        total = float((self.weight * rest**2).sum()) + float(away @ away)
        total += float(self.priors.squares(state.touches).sum())
        return 0.5 * (total + float((state.log_gain**2).sum()) / self.priors.gain_std**2)

    def normal(self, state: State, damping: float = 0.0) -> Normal:
        """Normal equations at a state."""
        weight, gain = self.weight, np.exp(state.log_gain)
        plain, slopes = read(self.tables, state.touches, state.skin, self.data.taxels)
        predicted, slopes = plain * gain, slopes * gain
        rest = self.data.readings - predicted
        shared = self._skin_slopes(state) * gain  # (2, T, L)
        gain_prior = self.priors.gain_std**-2
        hessian = _blocks(slopes, weight) + self.priors.block
        pull = np.einsum("til,tl->ti", slopes, weight * rest) + self.priors.pull(state.touches)
        np.einsum("tii->ti", hessian)[:] *= 1.0 + damping
        own = np.asarray(np.linalg.inv(hessian), np.float64)
        size, count = SHARED + len(gain), len(plain)
        block = np.zeros((size, size))
        block[:2, :2] = np.einsum("itl,tl,jtl->ij", shared, weight, shared)
        block[:2, 2:] = np.einsum("itl,tl->il", shared, weight * predicted)
        block[2:, :2] = block[:2, 2:].T
        diagonal = np.einsum("ii->i", block)
        diagonal[2:] = (weight * predicted**2).sum(axis=0) + gain_prior
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
        downhill[:2] -= (state.skin - self.priors.skin) / np.square([THICKNESS_STD, RATIO_STD])
        downhill[2:] = (weight * rest * predicted).sum(axis=0) - state.log_gain * gain_prior
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
        """Go downhill (Levenberg 1944) until nothing is gained.

        After each step presses follow what is shared: their valleys are curved, and a straight
        step would leave them.
        """
        damping, cost = DAMPING, self.cost(state)
        for _ in range(steps):
            tried = self._step(state, self.normal(state, damping))
            begins = [tried, replace(tried, touches=state.touches)]
            tried = refined(self.data, self.tables, begins, self.weight, self.priors, FOLLOW)
            new = self.cost(tried)
            if new < cost:
                gained, state, cost, damping = cost - new, tried, new, damping * 0.1
                if gained < DONE and damping <= DAMPING:
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
        touches = state.touches + np.clip(own, -LONGEST, LONGEST)
        return State(touches, skin, log_gain - log_gain.mean())
