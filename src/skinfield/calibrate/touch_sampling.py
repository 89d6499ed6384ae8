"""Presses integrated out by sampling them: skin and gains by their marginal likelihood.

Presses that are fitted, and not integrated out, make the skin look thinner than it is (Neyman and
Scott 1948); and two taxels leave a press on a long, bent ridge that no Gaussian follows, so that
Laplace's approximation errs as far the other way. So chains walk over the posterior of each press
(differential evolution, ter Braak 2006), and skin and gains go where the mean of their scores is 0
(Fisher's identity), by steps of the information that complete data have (Dempster, Laird and Rubin
1977), less what presses take of it (Louis 1982). As skin and gains move, chains go along with them,
so that neither scores nor chains change much: what is left to sample is what is not linear.
"""

from dataclasses import dataclass, replace

import numpy as np

from skinfield.calibrate.press_tables import RATIOS
from skinfield.calibrate.touch_fit import (
    ALONE,
    COMMON,
    OWN,
    RATIO_STD,
    SHARED,
    STEP,
    THICKNESS_STD,
    JointFit,
    State,
    alone,
    read,
    readings,
    starts,
)
from skinfield.errors import Floats, InputError

CHAINS = 32  # a press
JUMP, WHOLE = 2.38 / np.sqrt(2.0 * OWN), 0.1  # of the way between two chains; from peak to peak
BURN, BETWEEN = 150, 3  # steps before the first sample, and between two
ROUNDS, SAMPLES = 20, 10
EVERY, OTHERS, WIDE = 4, 16, 0.5  # of starts; deviations about them
LONGEST = 1.0  # deviations of a step of the skin
MOMENTUM = 0.6  # of the step before: the way is long where presses take most of what is known
MOST_LOST = 0.95  # of what is known in any direction
NEWER = 0.2  # weight of a round's information beside that before


@dataclass(frozen=True, eq=False)
class Moments:
    """Means over samples.

    Attributes
    ----------
    score : (S,) array
        Slope of the log likelihood by what is shared.
    complete, lost : (S, S) arrays
        Information were presses known, and what they take of it.
    coupling : (T, S, 4) array
        By which presses go along with what is shared.
    """

    score: Floats
    complete: Floats
    lost: Floats
    coupling: Floats


def marginal(fit: JointFit, state: State) -> tuple[State, Floats]:
    """Most likely skin and gains, presses at their means; and the covariance (S, S)."""
    fit.aim(state)
    chains = Chains(fit, state, np.random.default_rng(0))
    for _ in range(BURN):
        chains.step()
    ends: list[State] = []
    complete = lost = np.zeros(0)
    before = np.zeros(SHARED + len(state.log_gain))
    for round_ in range(ROUNDS):
        found = chains.moments()
        early = round_ < 3
        complete = found.complete if early else complete + NEWER * (found.complete - complete)
        lost = found.lost if early else lost + NEWER * (found.lost - lost)
        covariance = _inverse(complete, lost, MOST_LOST)
        step = _inverse(complete, 0.5 * lost, 0.5 * MOST_LOST) @ found.score
        step += MOMENTUM * before
        size = np.abs(step[:SHARED]) / np.sqrt(np.diag(covariance)[:SHARED])
        before = step * min(1.0, LONGEST / max(float(size.max()), 1e-12))
        chains.move(before, found.coupling)
        chains.learn(covariance)
        ends.append(chains.state)
    late = ends[ROUNDS // 2 :]
    skin = np.mean([each.skin for each in late], axis=0)
    log_gain = np.mean([each.log_gain for each in late], axis=0)
    return State(chains.state.touches, skin, log_gain), covariance


def _inverse(complete: Floats, lost: Floats, most: float) -> Floats:
    """Inverse of what is left of the information, whatever samples make of what is lost."""
    try:
        lower = np.linalg.inv(np.linalg.cholesky(complete))
    except np.linalg.LinAlgError:
        raise InputError(
            "the touches do not tell layer and gains apart, expected presses of single bodies, one "
            "at a time, all over the patch"
        ) from None
    part, across = np.linalg.eigh(lower @ lost @ lower.T)
    back = lower.T @ across
    return np.asarray((back / (1.0 - np.clip(part, 0.0, most))) @ back.T)


class Chains:
    """Chains over the posteriors of presses, given skin and gains.

    Parameters
    ----------
    fit : JointFit
        Its priors follow what is found.
    state : State
        Where chains begin.
    rng : Generator
    """

    def __init__(self, fit: JointFit, state: State, rng: np.random.Generator) -> None:
        self.fit, self.rng, self.skin, self.log_gain = fit, rng, state.skin, state.log_gain
        normal = fit.normal(state)
        self.coupling = normal.coupling
        self.places = self._begins(state, np.asarray(np.linalg.cholesky(normal.own), np.float64))
        self.value = self._logs(self.places)

    def _begins(self, state: State, lower: Floats) -> Floats:
        """Where chains (T, C, 4) begin: about the press that is fitted, and about other minima."""
        fit, weight, count = self.fit, self.fit.weight, len(state.touches)
        begins = [
            state.touches,
            *starts(fit.data, fit.tables, state, weight)[: EVERY * OTHERS : EVERY],
        ]
        ends, costs = zip(
            *(
                alone(fit.data, fit.tables, replace(state, touches=each), weight, fit.priors, ALONE)
                for each in begins
            ),
            strict=True,
        )
        likely = np.exp(np.min(costs, axis=0) - np.array(costs)).cumsum(axis=0)  # (N, T)
        drawn = self.rng.random((CHAINS, count)) * likely[-1]
        chosen = (likely[None] < drawn[:, None]).sum(axis=1)
        places = np.array(ends)[chosen, np.arange(count)]
        away = self.rng.standard_normal((*places.shape[:2], OWN, 1))
        return np.asarray((places + WIDE * (lower @ away)[..., 0]).transpose(1, 0, 2))

    @property
    def state(self) -> State:
        """Where they are, presses at their means."""
        return State(self.places.mean(axis=1), self.skin, self.log_gain)

    def _read(self, places: Floats, skin: Floats) -> Floats:
        flat = np.ascontiguousarray(places.reshape(-1, OWN))
        out = readings(self.fit.tables, flat, skin, self.fit.data.taxels)
        return out.reshape(*places.shape[:2], -1)

    def _logs(self, places: Floats) -> Floats:
        rest = self._read(places, self.skin)
        rest *= -np.exp(self.log_gain)
        rest += self.fit.data.readings[:, None]
        squares = self.fit.data.squared(rest, self.fit.weight).sum(axis=-1)
        return np.asarray(-0.5 * (squares + self.fit.squares(places)))

    def step(self) -> None:
        """Move each half of the chains along differences of the other half."""
        half, count, rng = CHAINS // 2, len(self.places), self.rng
        rows, order = np.arange(count)[:, None], rng.permutation(CHAINS)
        for mine, others in ((order[:half], order[half:]), (order[half:], order[:half])):
            first = rng.integers(half, size=(count, half))
            second = (first + rng.integers(1, half, size=(count, half))) % half
            size = np.where(rng.random((count, half)) < WHOLE, 1.0, JUMP)
            size *= np.exp(0.4 * rng.standard_normal((count, half)))
            apart = self.places[rows, others[first]] - self.places[rows, others[second]]
            tried = self.places[:, mine] + size[..., None] * apart
            value = self._logs(tried)
            taken = np.log(rng.random(value.shape)) < value - self.value[:, mine]
            self.places[:, mine] = np.where(taken[..., None], tried, self.places[:, mine])
            self.value[:, mine] = np.where(taken, value, self.value[:, mine])

    def _skin_slopes(self, gain: Floats) -> list[Floats]:
        """Derivatives of readings by ln thickness and Poisson's ratio."""
        out = []
        for index, step in enumerate(STEP):
            up, down = self.skin.copy(), self.skin.copy()
            up[index], down[index] = up[index] + step, down[index] - step
            up[1] = min(up[1], RATIOS[-1])
            rise = self._read(self.places, up) - self._read(self.places, down)
            out.append(rise * gain / (up[index] - down[index]))
        return out

    def moments(self) -> Moments:
        """Go on, and take samples."""
        fit, gain = self.fit, np.exp(self.log_gain)
        size, count = SHARED + len(gain), len(self.places)
        total = [np.zeros(shape) for shape in ((count, size), (size, size), (size, size))]
        cross, own = np.zeros((count, size, OWN)), np.zeros((count, OWN, OWN))
        for _ in range(SAMPLES):
            for _ in range(BETWEEN):
                self.step()
            flat = np.ascontiguousarray(self.places.reshape(-1, OWN))
            plain, slopes = read(fit.tables, flat, self.skin, fit.data.taxels)
            plain = plain.reshape(count, CHAINS, -1) * gain
            slopes = slopes.reshape(count, CHAINS, OWN, -1) * gain
            shared = self._skin_slopes(gain)
            rest, weight = fit.data.slopes(fit.data.readings[:, None] - plain, fit.weight)
            sums = [(each * rest).sum(axis=2) for each in shared]
            score = np.concatenate([np.stack(sums, axis=2), plain * rest], axis=2)
            pull = (slopes @ rest[..., None])[..., 0] + fit.pull(self.places)
            score -= pull @ self.coupling.transpose(0, 2, 1)
            total[0] += score.mean(axis=1)
            total[1] += score.reshape(-1, size).T @ score.reshape(-1, size) / CHAINS
            total[2] += _known(shared, plain, weight)
            felt = slopes * weight[:, :, None]
            own += (felt @ slopes.transpose(0, 1, 3, 2)).mean(axis=1)
            cross[:, SHARED:] += (felt * plain[:, :, None]).mean(axis=1).transpose(0, 2, 1)
            for index, each in enumerate(shared):
                cross[:, index] += (felt @ each[..., None])[..., 0].mean(axis=1)
        mean, square, complete = (each / SAMPLES for each in total)
        cross, own = cross / SAMPLES, own / SAMPLES + fit.priors.precision
        prior, known = self._prior()
        complete += _flat(self.coupling @ own) @ _flat(self.coupling).T + known
        mixed = _flat(cross) @ _flat(self.coupling).T
        return Moments(
            mean.sum(axis=0) + prior,
            complete - mixed - mixed.T,
            square - mean.T @ mean,
            cross @ np.linalg.inv(own),
        )

    def _prior(self) -> tuple[Floats, Floats]:
        """Score and information of priors of what is shared."""
        priors, count = self.fit.priors, len(self.log_gain)
        known = np.r_[THICKNESS_STD**-2.0, RATIO_STD**-2.0, np.full(count, priors.gain_std**-2.0)]
        score = known * np.r_[priors.skin - self.skin, -self.log_gain]
        information = np.diag(known)
        information[SHARED:, SHARED:] += (COMMON * count) ** -2.0
        return score, information

    def move(self, step: Floats, coupling: Floats) -> None:
        """Move skin and gains, and chains along with them; couple as told from now on."""
        step[1] = np.clip(step[1], RATIOS[0] - self.skin[1], RATIOS[-1] - self.skin[1])
        log_gain = self.log_gain + step[SHARED:]
        self.skin, self.log_gain = self.skin + step[:SHARED], log_gain - log_gain.mean()
        self.places -= np.einsum("tij,i->tj", self.coupling, step)[:, None]
        self.coupling = coupling
        self.value = self._logs(self.places)

    def learn(self, covariance: Floats) -> None:
        """Take priors as gains and presses make them likely."""
        flat = self.places.reshape(-1, OWN)[:, SHARED:]
        priors = self.fit.priors.learnt(
            self.log_gain, covariance, flat.mean(axis=0), np.cov(flat.T)
        )
        self.fit.priors = priors
        self.value = self._logs(self.places)


def _flat(blocks: Floats) -> Floats:
    return np.asarray(blocks.transpose(1, 0, 2).reshape(blocks.shape[1], -1))


def _known(shared: list[Floats], plain: Floats, weight: Floats) -> Floats:
    """Information (S, S) on what is shared were presses known, mean over chains."""
    size = SHARED + plain.shape[2]
    out = np.zeros((size, size))
    for row, each in enumerate(shared):
        felt = each * weight
        out[row, :SHARED] = [(felt * other).sum() for other in shared]
        out[row, SHARED:] = out[SHARED:, row] = (felt * plain).sum(axis=(0, 1))
    np.einsum("ii->i", out)[SHARED:] = (plain**2 * weight).sum(axis=(0, 1))
    return out / CHAINS
