"""Joint fit of presses and of the skin that reads them (Gauss-Newton with a Schur complement).

Each press has four parameters of its own: x, y, ln force, ln radius of contact. All share ln
thickness, Poisson's ratio and the logarithm of each taxel's gain. The presses' parameters are
eliminated press by press (Triggs et al. 2000, Bundle adjustment), so the cost grows with their
number only linearly.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.special import log_ndtr

from skinfield.calibrate.press_tables import BOUNDS, RATIOS, PressTables
from skinfield.compiled import njit
from skinfield.elastic import Quantity
from skinfield.errors import Floats
from skinfield.solve.atoms.atom_readings import PARAMETERS, TableRoom, add_atom
from skinfield.solve.atoms.table import Tables

OWN, SHARED = 4, 2
GAIN_STD = 0.15  # of ln gain, before any press, and at most: more is a model that is wrong
USUAL_GAIN_STD, USUAL = 0.1, 8.0  # what is usual, worth so many taxels
PLACE_STD = 0.5  # pitches between a press and the taxel that feels it most
THICKNESS_STD = 0.5  # of ln thickness
RATIO_STD = 0.15
FORCE_STD, RADIUS_STD = 3.0, 0.8  # of ln force and ln radius, before any press
COMMON = 1e-5  # to which the mean of ln gains is 0
BESIDE = 0.03  # part of the highest reading that the model error is a part of anywhere
STEP = np.array([0.02, 0.004])  # for derivatives by ln thickness and Poisson's ratio
STARTS = (0.35, 0.7, 1.4)  # radii of contact in thicknesses
AROUND, AWAY = 12, (0.3, 0.6, 0.9)  # places about the highest reading: in directions, and pitches
MATCHES, REFINED = 2, 4
PEAK = 0.15  # of the highest reading, above which taxels tell the place
LONGEST = np.array([3e-3, 3e-3, 1.0, 0.5])  # step of a press
LONGEST_SKIN = np.array([0.15, 0.03])
ALONE, FOLLOW, TOGETHER = 25, 4, 40  # steps at most: of presses, and of all
DONE = 1e-3  # gain in cost of the last step
DAMPING = 1e-6  # to begin with: the valley between thickness, gains and forces is long and flat


@dataclass(frozen=True, eq=False)
class Data:
    """Readings of presses.

    Attributes
    ----------
    readings : (T, L) array
    heard : (T, L) bool array
    noise : (T, L) array
    clipped : (T, L) bool array
        Where a board does not tell less: what is read is the most that it may be (Tobin 1958).
    taxels : (L, 2) array, m
    quantity : Quantity
    place_std : float, m
        Along each axis: how well places of taxels are known.
    """

    readings: Floats
    heard: NDArray[np.bool_]
    noise: Floats
    clipped: NDArray[np.bool_]
    taxels: Floats
    quantity: Quantity
    place_std: float = 0.0

    @cached_property
    def pitch(self) -> float:
        """From taxel to taxel, m."""
        return float(np.median(cKDTree(self.taxels).query(self.taxels, [2])[0]))

    @cached_property
    def peak(self) -> NDArray[np.int64]:
        """Number (T,) of the taxel that feels each press most."""
        return np.asarray(np.where(self.heard, self.readings, -np.inf).argmax(axis=1))

    def weight(self, error: float) -> Floats:
        """One over the variance of readings (T, L) by themselves; 0 where not heard."""
        return np.where(self.heard, 1.0 / variance(self.readings, self.noise, error), 0.0)

    def only(self, kept: NDArray[np.bool_]) -> "Data":
        """Data of some presses."""
        names = "readings", "heard", "noise", "clipped"
        return replace(self, **{name: getattr(self, name)[kept] for name in names})

    def squared(self, rest: Floats, weight: Floats) -> Floats:
        """Weighted squares of residuals (T, ..., L); -2 ln of how likely less is, where clipped."""
        squares = _wide(weight, rest) * rest**2
        if len(self._ends[0]):
            at = self._ends[0], ..., self._ends[1]
            squares[at] = -2.0 * log_ndtr(_by_column(rest[at], np.sqrt(weight[self._ends])))
        return np.asarray(squares)

    def slopes(self, rest: Floats, weight: Floats) -> tuple[Floats, Floats]:
        """Slopes of the log likelihood by predictions (T, ..., L), and what is known of these."""
        known = np.broadcast_to(_wide(weight, rest), rest.shape).copy()
        slope = known * rest
        if len(self._ends[0]):
            at, root = (self._ends[0], ..., self._ends[1]), np.sqrt(weight[self._ends])
            z = _by_column(rest[at], root)
            mills = np.exp(-0.5 * z**2 - log_ndtr(z)) / np.sqrt(2.0 * np.pi)
            slope[at] = _by_column(-mills, root)
            known[at] = _by_column(mills * (mills + z), root**2)
        return slope, known

    @cached_property
    def _ends(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Presses and taxels of what is clipped."""
        rows, columns = np.nonzero(self.clipped & self.heard)
        return rows, columns


def _wide(weight: Floats, rest: Floats) -> Floats:
    """Weights (T, L) along (T, ..., L)."""
    return weight.reshape(len(weight), *(1,) * (rest.ndim - 2), -1)


def _by_column(values: Floats, factor: Floats) -> Floats:
    """Values (N, ...) times factors (N,)."""
    return np.asarray(values * factor.reshape(-1, *(1,) * (values.ndim - 1)))


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
    slopes = np.empty((len(touches), PARAMETERS, len(taxels)))
    out, outside = _read(tables, touches, skin, taxels, slopes)
    slopes = slopes[:, :OWN].copy()
    slopes[:, :2] /= float(np.exp(skin[0]))
    slopes[outside, 3] = 0.0
    return out, slopes


def readings(tables: PressTables, touches: Floats, skin: Floats, taxels: Floats) -> Floats:
    """Readings (T, L) as `read` has them."""
    return _read(tables, touches, skin, taxels, np.empty((1, PARAMETERS, len(taxels))))[0]


def _read(
    tables: PressTables, touches: Floats, skin: Floats, taxels: Floats, slopes: Floats
) -> tuple[Floats, NDArray[np.bool_]]:
    thickness = float(np.exp(skin[0]))
    atoms, wanted = np.zeros((len(touches), PARAMETERS)), touches[:, 3] - skin[0]
    atoms[:, :2] = touches[:, :2] / thickness
    atoms[:, 2] = touches[:, 2]
    atoms[:, 3] = np.clip(wanted, *np.log(BOUNDS))
    out = np.empty((len(touches), len(taxels)))
    places = np.ascontiguousarray(taxels / thickness)
    read_each(atoms, places, tables.at(skin[0], skin[1]), out, slopes)
    return out, atoms[:, 3] != wanted


def variance(readings: Floats, noise: Floats, error: float) -> Floats:
    """Of readings (T, L): noise, and what the model is wrong by, a part of what is read."""
    beside = BESIDE * np.abs(readings).max(axis=1, keepdims=True)
    return np.asarray(noise**2 + error**2 * (readings**2 + beside**2))


@dataclass(frozen=True, eq=False)
class Priors:
    """What gains and presses are like, as those of this skin show (empirical Bayes).

    Attributes
    ----------
    skin : (2,) array
        ln thickness and Poisson's ratio, in the middle.
    gain_std : float
        Of ln gain.
    centre : (2,) array
        Of ln force and ln radius.
    precision : (4, 4) array
        Inverse of the covariance of presses, places about the taxel that feels them most.
    """

    skin: Floats
    gain_std: float
    centre: Floats
    precision: Floats

    @classmethod
    def wide(cls, skin: Floats, touches: Floats, data: Data) -> "Priors":
        """Before presses (T, 4) have shown anything but where they start."""
        near = PLACE_STD * data.pitch
        precision = np.diag(np.array([near, near, FORCE_STD, RADIUS_STD]) ** -2.0)
        return cls(skin, GAIN_STD, np.median(touches[:, 2:], axis=0), precision)

    def expected(self, data: Data) -> Floats:
        """Presses (T, 4) in the middle of what they may be."""
        places = data.taxels[data.peak]
        return np.column_stack([places, np.broadcast_to(self.centre, places.shape)])

    def volume(self, presses: int, taxels: int) -> float:
        """Logarithm of how widely gains and presses are spread."""
        spread = -0.5 * float(np.linalg.slogdet(self.precision)[1])
        return taxels * float(np.log(self.gain_std)) + presses * spread

    def learnt(
        self, log_gain: Floats, covariance: Floats, centre: Floats, spread: Floats
    ) -> "Priors":
        """As gains and presses make them likely (MacKay 1992).

        Parameters
        ----------
        log_gain : (L,) array
        covariance : (2 + L, 2 + L) array
            Of what is shared.
        centre : (2,) array
            Of ln force and ln radius of presses.
        spread : (2, 2) array
            Their covariance.
        """
        known = np.clip(1.0 - np.diag(covariance)[SHARED:] / self.gain_std**2, 0.0, 1.0)
        square = float((log_gain**2).sum()) + USUAL * USUAL_GAIN_STD**2
        square /= float(known.sum()) + USUAL
        precision = self.precision.copy()
        precision[2:, 2:] = np.linalg.inv(spread)
        gain_std = min(float(np.sqrt(self.gain_std * square**0.5)), GAIN_STD)
        return Priors(self.skin, gain_std, centre, precision)


def start(data: Data, tables: PressTables, state: State, error: float) -> Floats:
    """Each press for itself (T, 4), for a skin that is taken to be known."""
    weight = data.weight(error)
    begins = starts(data, tables, state, weight)[:REFINED]
    usual = Priors.wide(state.skin, begins[0], data)
    each = [replace(state, touches=touches) for touches in begins]
    return refined(data, tables, each, weight, usual, ALONE).touches


def starts(data: Data, tables: PressTables, state: State, weight: Floats) -> Floats:
    """Where presses may be (N, T, 4), the most likely first.

    Readings have many minima between and beside taxels: many places about the taxel that feels a
    press most and many radii are tried, by the force that explains most.
    """
    rows, peak = np.arange(len(data.readings)), data.peak
    above = np.maximum(data.readings - PEAK * data.readings[rows, peak, None], 0.0)
    above = np.where(data.heard, above, 0.0)
    middle = above @ data.taxels / above.sum(axis=1, keepdims=True)
    angles = 2.0 * np.pi * np.arange(AROUND) / AROUND
    circle = data.pitch * np.column_stack([np.cos(angles), np.sin(angles)])
    away = np.concatenate([np.zeros((1, 2)), *(part * circle for part in AWAY)])
    places = [middle, *(data.taxels[peak] + offset for offset in away)]
    tried, costs = [], []
    for radius in STARTS:
        for place in places:
            touches, cost = _matched(data, tables, state, weight, place, np.log(radius))
            tried.append(touches)
            costs.append(cost)
    best = np.argsort(costs, axis=0)
    return np.asarray(np.array(tried)[best, rows])


def _matched(
    data: Data, tables: PressTables, state: State, weight: Floats, place: Floats, radius: float
) -> tuple[Floats, Floats]:
    """Presses (T, 4) at places with the force that explains most, and what is left (T,)."""
    linear, gain = data.quantity.linearise, np.exp(state.log_gain)
    wanted = linear(data.readings, np.empty_like(data.readings))
    touches = np.empty((len(place), OWN))
    touches[:, :2], touches[:, 2], touches[:, 3] = place, -2.0, state.skin[0] + radius
    for _ in range(MATCHES):
        found = gain * readings(tables, touches, state.skin, data.taxels)
        found = linear(found, np.empty_like(found))
        size = np.maximum((weight * found**2).sum(axis=1), 1e-300)
        factor = np.maximum((weight * found * wanted).sum(axis=1) / size, 1e-3)
        touches[:, 2] += np.log(factor)
    left = data.readings - gain * readings(tables, touches, state.skin, data.taxels)
    return touches, data.squared(left, weight).sum(axis=1)


def alone(
    data: Data, tables: PressTables, state: State, weight: Floats, priors: Priors, steps: int
) -> tuple[Floats, Floats]:
    """Refine each press for itself (Levenberg 1944); the presses (T, 4), and their costs (T,).

    `weight` (T, L) is one over the variance of each reading, 0 where not heard.
    """
    gain, touches, skin = np.exp(state.log_gain), state.touches, state.skin
    damping, expected = np.full(len(touches), DAMPING), priors.expected(data)

    def cost_of(touches: Floats) -> tuple[Floats, Floats, Floats]:
        predicted, slopes = read(tables, touches, skin, data.taxels)
        rest = data.readings - predicted * gain
        square = data.squared(rest, weight).sum(axis=1)
        square += squares(touches - expected, priors.precision)
        return 0.5 * square, rest, slopes * gain

    costs, rest, slopes = cost_of(touches)
    for _ in range(steps):
        felt, known = data.slopes(rest, weight)
        hessian = blocks(slopes, known) + priors.precision
        downhill = np.einsum("til,tl->ti", slopes, felt)
        downhill += (expected - touches) @ priors.precision
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
        if better.any() and gained < DONE:
            break
    return touches, costs


def refined(
    data: Data,
    tables: PressTables,
    begins: list[State],
    weight: Floats,
    priors: Priors,
    steps: int,
) -> State:
    """Refine each press for itself, from the one of several beginnings that leads furthest down."""
    ends = [alone(data, tables, begin, weight, priors, steps) for begin in begins]
    best = np.argmin([cost for _, cost in ends], axis=0)
    touches = np.array([touches for touches, _ in ends])[best, np.arange(len(best))]
    return replace(begins[0], touches=touches)


def squares(away: Floats, precision: Floats) -> Floats:
    """Of distances (..., 4), in deviations."""
    return np.asarray(((away @ precision) * away).sum(axis=-1))


def blocks(slopes: Floats, weight: Floats) -> Floats:
    """Information (T, 4, 4) of readings on each press."""
    return np.asarray((slopes * weight[:, None]) @ slopes.transpose(0, 2, 1))


@dataclass(frozen=True, eq=False)
class Normal:
    """Normal equations at a state, the presses eliminated.

    Attributes
    ----------
    evidence : float
        Logarithm of the marginal likelihood of thickness and ratio (Laplace), up to a constant:
        presses and gains are integrated out.
    schur : (2 + L, 2 + L) array
    own : (T, 4, 4) array
        Inverse of the presses' own blocks.
    coupling : (T, 2 + L, 4) array
        Between what is shared and a press, times `own`.
    """

    evidence: float
    schur: Floats
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
    priors : Priors
    error : float
        Part of what taxels read by which the model is wrong.
    """

    def __init__(self, data: Data, tables: PressTables, priors: Priors, error: float) -> None:
        self.data, self.tables, self.priors, self.error = data, tables, priors, error
        self.weight, self.constant = np.zeros(data.readings.shape), 0.0

    def _away(self, touches: Floats) -> Floats:
        """Of presses (T, ..., 4) from what is expected of them."""
        middle = self.priors.expected(self.data)
        return touches - middle.reshape(len(middle), *(1,) * (touches.ndim - 2), OWN)

    def squares(self, touches: Floats) -> Floats:
        """Of distances of presses (T, ..., 4) from what is expected, in deviations."""
        return squares(self._away(touches), self.priors.precision)

    def pull(self, touches: Floats) -> Floats:
        """By which presses (T, ..., 4) are drawn to what is expected."""
        return np.asarray(-self._away(touches) @ self.priors.precision)

    def aim(self, state: State) -> None:
        """Weigh readings by what is predicted of them."""
        data = self.data
        predicted, slopes = read(self.tables, state.touches, state.skin, data.taxels)
        spread = variance(predicted * np.exp(state.log_gain), data.noise, self.error)
        steep = np.square(slopes[:, :2]).sum(axis=1) * np.exp(2.0 * state.log_gain)
        spread += data.place_std**2 * steep
        self.weight = np.where(data.heard, 1.0 / spread, 0.0)
        self.constant = 0.5 * float(np.where(data.heard, np.log(spread), 0.0).sum())

    def misfit(self, state: State) -> Floats:
        """Residuals (T, L) over their standard deviation, squared; 0 where not heard."""
        plain = readings(self.tables, state.touches, state.skin, self.data.taxels)
        rest = self.data.readings - plain * np.exp(state.log_gain)
        return self.data.squared(rest, self.weight)

    def cost(self, state: State) -> float:
        """Half the weighted squares of residuals and of what priors say."""
        away = (state.skin - self.priors.skin) / (THICKNESS_STD, RATIO_STD)
        total = float(self.misfit(state).sum()) + float(away @ away)
        total += float(self.squares(state.touches).sum())
        total += float((state.log_gain**2).sum()) / self.priors.gain_std**2
        return 0.5 * total + self.constant

    def normal(self, state: State, damping: float = 0.0) -> Normal:
        """Normal equations at a state."""
        gain = np.exp(state.log_gain)
        plain, slopes = read(self.tables, state.touches, state.skin, self.data.taxels)
        predicted, slopes = plain * gain, slopes * gain
        rest = np.where(self.data.heard, self.data.readings - predicted, 0.0)
        felt, weight = self.data.slopes(rest, self.weight)
        shared = self._skin_slopes(state) * gain  # (2, T, L)
        gain_prior = self.priors.gain_std**-2.0
        hessian = blocks(slopes, weight) + self.priors.precision
        pull = np.einsum("til,tl->ti", slopes, felt) + self.pull(state.touches)
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
        schur = (schur + schur.T) / 2.0
        downhill = np.empty(size)
        downhill[:2] = np.einsum("itl,tl->i", shared, felt)
        downhill[:2] -= (state.skin - self.priors.skin) / np.square([THICKNESS_STD, RATIO_STD])
        downhill[2:] = (felt * predicted).sum(axis=0) - state.log_gain * gain_prior
        downhill -= np.einsum("tij,tj->i", coupling, pull)
        gains = np.linalg.slogdet(schur[SHARED:, SHARED:])[1]
        volume = 0.5 * float(gains - np.linalg.slogdet(own)[1].sum())
        evidence = -self.cost(state) - volume - self.priors.volume(count, len(gain))
        return Normal(evidence, schur, own, coupling, downhill, pull)

    def _skin_slopes(self, state: State) -> Floats:
        """Derivatives (2, T, L) by ln thickness and Poisson's ratio, without gains."""
        out = []
        for index, step in enumerate(STEP):
            sides = []
            for sign in (-1.0, 1.0):
                skin = state.skin.copy()
                skin[index] += sign * step
                sides.append(readings(self.tables, state.touches, skin, self.data.taxels))
            out.append((sides[1] - sides[0]) / (2.0 * step))
        return np.array(out)

    def run(self, state: State, steps: int = TOGETHER) -> State:
        """Go downhill (Levenberg 1944) until nothing is gained; weights are those of the start.

        After each step presses
        follow what is shared: their valleys are curved, and a straight step would leave them.
        """
        self.aim(state)
        damping, cost = DAMPING, self.cost(state)
        for _ in range(steps):
            tried = self._step(state, self.normal(state, damping))
            begins = [tried, replace(tried, touches=state.touches)]
            tried = refined(self.data, self.tables, begins, self.weight, self.priors, FOLLOW)
            new = self.cost(tried)
            if new < cost:
                gained, state, cost, damping = cost - new, tried, new, damping * 0.1
                if gained < DONE * np.sqrt(len(state.touches)):
                    break
            elif damping > 1e4:
                break
            else:
                damping *= 10.0
        return state

    def learn(self, state: State) -> None:
        """Take priors as a fit with those before makes them likely."""
        normal = self.normal(state)
        covariance = np.asarray(np.linalg.inv(normal.schur), np.float64)
        joint = normal.coupling
        own = normal.own + joint.transpose(0, 2, 1) @ covariance @ joint
        centre = state.touches[:, 2:].mean(axis=0)
        off = state.touches[:, 2:] - centre
        spread = off.T @ off / len(off) + own[:, 2:, 2:].mean(axis=0)
        self.priors = self.priors.learnt(state.log_gain, covariance, centre, spread)

    def _step(self, state: State, normal: Normal) -> State:
        schur, downhill = normal.schur.copy(), normal.downhill.copy()
        highest, lowest = RATIOS[-1], RATIOS[0]
        at_end = state.skin[1] >= highest and np.linalg.solve(schur, downhill)[1] > 0.0
        if at_end:  # stay there, and move the others
            schur[1], schur[:, 1], schur[1, 1], downhill[1] = 0.0, 0.0, 1.0, 0.0
        step = np.linalg.solve(schur, downhill)
        step *= min(1.0, *(LONGEST_SKIN / np.maximum(np.abs(step[:SHARED]), 1e-12)))
        own = np.einsum("tij,tj->ti", normal.own, normal.own_downhill)
        own -= np.einsum("tij,i->tj", normal.coupling, step)
        skin = state.skin + step[:SHARED]
        skin[1] = np.clip(skin[1], lowest, highest)
        log_gain = state.log_gain + step[SHARED:]
        touches = state.touches + np.clip(own, -LONGEST, LONGEST)
        return State(touches, skin, log_gain - log_gain.mean())


@njit
def read_each(atoms: Floats, taxels: Floats, tables: Tables, out: Floats, slopes: Floats) -> None:
    """Write readings (N, L) of atoms (N, 8), each alone, and derivatives (N, 8, L).

    `slopes` may be of one atom, (1, 8, L): then they are of the last.
    """
    near = np.arange(len(taxels))
    room = TableRoom(
        np.empty((3, tables.coefficients.shape[3])),
        np.empty((2, tables.coefficients.shape[2])),
        np.empty((2, 4)),
        np.empty((2, tables.shear.shape[2])),
    )
    rows = slopes.reshape(-1, len(taxels))
    last = len(slopes) - 1
    out[:] = 0.0
    for n in range(len(atoms)):
        row = min(n, last)
        its = rows[PARAMETERS * row : PARAMETERS * (row + 1)]
        add_atom(0, atoms[n], 0, taxels, near, tables, room, out[n], its)
