"""Model error of a reading, compiled: the evidence of its atoms for each size of the error.

A taxel reads s σ of noise and m A of model error: σ is its stated noise, A the amplitude that the
atoms have around it, and m what the model is wrong by. Residuals alone say little of m, as atoms
fit part of it away; their marginal likelihood (MacKay 2003, chapters 27 and 28) knows how much.
"""

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner
from skinfield.errors import Floats
from skinfield.solve.atoms.alternatives_kernel import prior_evidence
from skinfield.solve.atoms.atom_readings import PARAMETERS, free_of
from skinfield.solve.atoms.cholesky_kernel import factor
from skinfield.solve.atoms.fit_kernel import (
    DEVIATION,
    FAST,
    NEAR,
    NOW,
    READINGS,
    SHARED,
    STEP,
    TRIED_WEIGHT,
    WHITE,
    FitMemory,
    FitModel,
    add_prior,
    evaluate,
    free_system,
    gather,
    take_squares,
)
from skinfield.solve.atoms.posterior_kernel import KNOWN, STALE, UNKNOWN
from skinfield.solve.atoms.reading_memory import (
    BEFORE,
    ERRORS,
    HERE,
    LAST,
    LEARNT,
    MEAN_NOISE,
    MISFIT,
    OFFSET,
    PLACE_X,
    PLACE_Y,
    PRESSES,
    READ_STEP,
    ROOM,
    SCALE,
    SPREAD,
    TOTAL,
    WEIGHED,
    Fit,
)

QUIETEST = 1e-3  # of the stated noise, that is believed
UNCHANGED = 0.05  # deviations between two readings: less may be drift that was taken off
WIDENS = 1.2  # times, by how much the step of a board is taken for more in one reading
QUIET = 0.25  # of the expected squares of residuals: below, there is less noise than was stated
CALM = 0.7  # the same, where more noise than was stated had been assumed
UNSEEN = 12  # taxels that see no contact, and tell the noise by themselves
CLIPPED = 9.0  # squares of residuals count no more: they may be touches
LOUD = 1.2  # times the stated noise, from which it is more: less may be weak touches
LOUDEST = 4.0  # times: what is left over beyond is no noise, but more than the atoms could tell
ERROR_STD = 1.4  # of the logarithm of the model error, before any reading
AROUND = 4.5  # thicknesses over which a model error reaches
BESIDE, WIDER = 0.2, 4.0  # how much of it does, and times the error
ELSEWHERE = 1.0  # thicknesses from one press to another one
FORGET = 0.98  # of what presses before say of the model error, at each other one
TABULATED = 0.002  # of the highest reading, to which what atoms are read as is known
CHUNK = 16  # taxels: the product of as many variances is in range
MOST_SAID = 20.0  # by one press, in logarithms
WIDENESS: Floats = np.minimum(np.hypot(BESIDE, WIDER * ERRORS), 1.0)
NEW_NOISE = 1.1  # times: a noise that differs by less leaves what is open as it is


@inner(_nrt=False)
def evidence_of_errors(
    model: FitModel,
    memory: FitMemory,
    amplitude: Floats,
    common: float,
    errors: Floats,
    beside: Floats,
    out: Floats,
) -> None:
    """Write the logarithm of the marginal likelihood of the atoms of NOW for each model error.

    The atoms stay where they are. The row DEVIATION has the noise, infinite of taxels that are not
    heard.

    Parameters
    ----------
    amplitude : (2, L) array
        Squares of what a taxel reads around the atoms, and of what its neighbours do.
    common : float
        Standard deviation of an offset that all taxels share.
    errors : (N,) array
    beside : (N,) array
        How much neighbours count.
    out : (N,) array
    """
    count, readings, noise = memory.counts[NOW], memory.taxels[READINGS], memory.taxels[DEVIATION]
    size, predicted, weight = PARAMETERS * count, memory.predicted[NOW], memory.taxels[TRIED_WEIGHT]
    sums, around, aside = memory.steps[2], memory.listed[1], memory.listed[2]
    system = memory.hessian[STEP]
    known = 0.0
    memory.marks[NEAR] = 0
    if count:
        gather(model, memory, NOW, READINGS)
        memory.costs[NOW] = evaluate(model, memory, NOW, READINGS)
        known = prior_evidence(model, memory, NOW)
    else:
        for taxel in range(len(predicted)):
            predicted[taxel] = 0.0
    for taxel in range(len(weight)):
        square = 1.0 / (noise[taxel] * noise[taxel])
        around[taxel], aside[taxel] = amplitude[0, taxel] * square, amplitude[1, taxel] * square
    for k in range(len(errors)):
        if k and not count:
            out[k] = out[0]
            continue
        weights, total, squares, volume = weigh_by(
            errors[k] * errors[k],
            beside[k] * beside[k],
            around,
            aside,
            noise,
            readings,
            predicted,
            weight,
        )
        for at in range(memory.marks[NEAR]):
            memory.listed[0, at] = weight[memory.near[at]]
        take_squares(memory, NOW, system, sums)
        shared = common * common / (1.0 + common * common * weights)
        for i in range(size):
            for j in range(i + 1):
                system[i * size + j] -= shared * sums[i] * sums[j]
        prior = 0.0
        for n in range(count):
            atom, family = memory.atoms[NOW, n], memory.family[NOW, n]
            prior += add_prior(n, atom, family, model, memory.gradient[STEP], system, size)
        out[k], determinant = -np.inf, 0.0
        free = free_system(memory, NOW, system, 0, 0.0)
        if factor(memory.system, free):
            for i in range(free):
                determinant += np.log(memory.system[i * free + i])
            cost = prior + 0.5 * (squares - shared * total * total)
            volume += np.log1p(common * common * weights)
            out[k] = known - cost - 0.5 * volume - determinant


@inner(fastmath=FAST, _nrt=False)
def weigh_by(
    square: float,
    wideness: float,
    around: Floats,
    aside: Floats,
    noise: Floats,
    readings: Floats,
    predicted: Floats,
    weight: Floats,
) -> tuple[float, float, float, float]:
    """Weigh taxels for the square of a model error; sums of weights, residuals, squares, volume."""
    weights, total, squares, volume = 0.0, 0.0, 0.0, 0.0
    for begin in range(0, len(weight), CHUNK):
        more = 1.0
        for taxel in range(begin, min(begin + CHUNK, len(weight))):
            times = 1.0 + square * (around[taxel] + wideness * aside[taxel])
            its = 1.0 / (noise[taxel] * noise[taxel] * times)
            residual = readings[taxel] - predicted[taxel]
            weight[taxel] = its
            weights += its
            total += its * residual
            squares += its * residual * residual
            more *= times
        volume += np.log(more)
    return weights, total, squares, volume


@inner(_nrt=False)
def take_noise(fit: Fit, valid: NDArray[np.bool_]) -> float:
    """Take the stated noise of valid taxels; its mean."""
    own, post, changed, total, count = fit.own, fit.post, False, 0.0, 0
    for taxel in range(len(own.noise)):
        now = own.noise[taxel] if valid[taxel] else np.inf
        changed = changed or (now < np.inf) != (own.heard[taxel] < np.inf)
        own.heard[taxel] = now
        if now < np.inf:
            total += now
            count += 1
    mean = total / max(count, 1)
    known = own.numbers[MEAN_NOISE]
    if changed or not known < NEW_NOISE * mean < NEW_NOISE * NEW_NOISE * known:
        own.numbers[MEAN_NOISE] = mean
        for index in range(len(post.known)):
            post.known[index] = STALE if post.known[index] >= KNOWN else UNKNOWN
    return mean


@inner(_nrt=False)
def square_readings(fit: Fit) -> None:
    """Write the squares of what taxels around the atoms of NOW read, and of what is beside them.

    Of all taxels, where there are no atoms.
    """
    model, memory, near, squares = fit.model, fit.memory, fit.near, fit.own.squares
    count = memory.counts[NOW]
    for taxel in range(squares.shape[1]):
        squares[0, taxel], squares[1, taxel] = 0.0, 0.0
    for taxel in range(squares.shape[1]):
        touched = count == 0
        for n in range(count):
            atom = memory.atoms[NOW, n]
            x, y = model.taxels[taxel, 0] - atom[0], model.taxels[taxel, 1] - atom[1]
            reach = AROUND + np.exp(atom[3]) + np.hypot(atom[4], atom[5])
            touched = touched or x * x + y * y < reach * reach
        if touched:
            value = memory.taxels[READINGS, taxel] * memory.taxels[READINGS, taxel]
            squares[0, taxel] = value
            for at in range(near.first[taxel], near.first[taxel + 1]):
                squares[1, near.taxels[at]] += near.weights[at] * value


@inner(_nrt=False)
def table_error(memory: FitMemory) -> float:
    """What the readings of atoms are off by where the model holds."""
    highest, readings = 0.0, memory.taxels[READINGS]
    for taxel in range(len(readings)):
        highest = max(highest, abs(readings[taxel]))
    return TABULATED * highest


@inner(_nrt=False)
def weigh(fit: Fit, error: float, common: float) -> None:
    """Weigh the taxels for a model error, in parts of what the taxels around each read."""
    memory, own = fit.memory, fit.own
    square_readings(fit)
    white, squares, total = memory.taxels[WHITE], own.squares, 0.0
    wideness = min(np.hypot(BESIDE, WIDER * error), 1.0)
    table, scale = table_error(memory), own.numbers[SCALE]
    for taxel in range(len(white)):
        noise = scale * own.heard[taxel]
        share = error * error * (squares[0, taxel] + wideness * wideness * squares[1, taxel])
        white[taxel] = 1.0 / np.sqrt(noise * noise + table * table + share)
        total += white[taxel] * white[taxel]
    memory.sums[SHARED] = common * common / (1.0 + common * common * total)
    own.numbers[WEIGHED] = error


@inner(_nrt=False)
def take_offset(fit: Fit) -> None:
    """Write the offset that all taxels share, with the atoms of NOW."""
    memory, total = fit.memory, 0.0
    white, predicted = memory.taxels[WHITE], memory.predicted[NOW]
    for taxel in range(len(white)):
        left = memory.taxels[READINGS, taxel] - predicted[taxel]
        total += white[taxel] * white[taxel] * left
    fit.own.numbers[OFFSET] = memory.sums[SHARED] * total


@inner(_nrt=False)
def parameters_of(memory: FitMemory) -> int:
    """Numbers that were fitted: four of each atom, more of a drawn-out one, or one that pushes."""
    number = 0
    for n in range(memory.counts[NOW]):
        number += free_of(memory.atoms[NOW, n])
    return int(number)


@inner(_nrt=False)
def explains(fit: Fit) -> bool:
    """Whether noise and model error account for what is left over, but for one in 1e4."""
    memory, squares, heard = fit.memory, 0.0, 0
    take_offset(fit)
    white, predicted = memory.taxels[WHITE], memory.predicted[NOW]
    for taxel in range(len(white)):
        left = memory.taxels[READINGS, taxel] - predicted[taxel] - fit.own.numbers[OFFSET]
        squares += (left * white[taxel]) ** 2
        heard += white[taxel] > 0.0
    freedom = max(heard - parameters_of(memory), 1)
    return bool(squares <= fit.near.limits[freedom])


@inner(_nrt=False)
def take_change(fit: Fit, readings: Floats) -> None:
    """Learn the step in which a board reads: the smallest change of a taxel that is no drift.

    Of a first reading it is a guess: the smallest of what taxels read.
    """
    numbers, change, least = fit.own.numbers, np.inf, np.inf
    before, follows = fit.memory.taxels[READINGS], numbers[BEFORE] > 0.0
    for taxel in range(len(readings)):
        noise = fit.own.heard[taxel]
        now, its = abs(readings[taxel]) / noise, abs(readings[taxel] - before[taxel]) / noise
        if now > UNCHANGED:
            least = min(least, now)
        if follows and before[taxel] != 0.0 and its > UNCHANGED:
            change = min(change, its)
    known = numbers[READ_STEP]
    if change < np.inf:
        numbers[READ_STEP] = min(change, WIDENS * known) if known > 0.0 else change
    elif known == 0.0 and least < np.inf:
        numbers[READ_STEP] = -least
    if numbers[SCALE] < 1.0:
        numbers[SCALE] = max(numbers[SCALE], quietest(fit))


@inner(_nrt=False)
def quietest(fit: Fit) -> float:
    """Least noise that is believed, of the stated one: of rounding, where a board does that."""
    return float(min(max(QUIETEST, abs(fit.own.numbers[READ_STEP]) / np.sqrt(12.0)), 1.0))


@inner(_nrt=False)
def noise_scale(fit: Fit) -> float:
    """By how much the noise differs from what is assumed, by what the atoms leave over; or 1.

    It is less where the squares are far fewer than the taxels: of all taxels, and of those that
    see a contact, the larger of the two, so that taxels that always read zero do not speak for
    the others; a board that rounds is no quieter than that makes it. It is more where the atoms
    do not explain the readings and taxels that see none of them are as restless: what they read
    is no touch. Where as many atoms as there may be do not explain the readings, all taxels tell
    it.
    """
    memory, scale = fit.memory, fit.own.numbers[SCALE]
    white, predicted, count = memory.taxels[WHITE], memory.predicted[NOW], memory.counts[NOW]
    explained, offset = explains(fit), fit.own.numbers[OFFSET]
    everywhere = not explained and count >= fit.rules.most
    if everywhere:
        offset = 0.0
        for taxel in range(len(white)):
            reading = memory.taxels[READINGS, taxel]
            offset += memory.sums[SHARED] * white[taxel] * white[taxel] * reading
    squares, own, clipped, heard, see, blind = 0.0, 0.0, 0.0, 0, 0, 0
    for taxel in range(len(white)):
        if not white[taxel] > 0.0:
            continue
        its = 0.0 if everywhere else predicted[taxel]
        left = ((memory.taxels[READINGS, taxel] - its - offset) * white[taxel]) ** 2
        heard += 1
        squares += left
        if abs(its) * white[taxel] > 1.0:
            see += 1
            own += left
        else:
            blind += 1
            clipped += min(left, CLIPPED)
    if not explained:
        typical = np.sqrt(clipped / blind) if blind >= UNSEEN else 1.0
        return float(typical) if LOUD < typical <= LOUDEST / scale else 1.0
    if not count:
        return 1.0
    parameters = parameters_of(memory)
    share = squares / max(heard - parameters, 1)
    if see > parameters + 2:
        share = max(share, own / (see - parameters))
    enough, least = (QUIET, quietest(fit) / scale) if scale <= 1.0 else (CALM, 1.0 / scale)
    return 1.0 if share > enough else max(float(np.sqrt(share)), least)


@inner(_nrt=False)
def infer(fit: Fit, common: float) -> None:
    """Infer the model error from what the atoms leave and presses before; their evidence."""
    memory, own, errors = fit.memory, fit.own, fit.own.errors
    if memory.counts[NOW]:
        square_readings(fit)
    else:
        for taxel in range(own.squares.shape[1]):
            own.squares[0, taxel], own.squares[1, taxel] = 0.0, 0.0
    room, learnt, here = errors[ROOM], errors[LEARNT], errors[HERE]
    noise, table, known = memory.taxels[DEVIATION], table_error(memory), 0.0
    for taxel in range(len(noise)):
        noise[taxel] = np.hypot(own.numbers[SCALE] * own.heard[taxel], table)
        if own.heard[taxel] < np.inf:
            known += np.log(noise[taxel] / own.heard[taxel])
    evidence_of_errors(fit.model, memory, own.squares, common, ERRORS, WIDENESS, room)
    highest, most, above = -np.inf, -np.inf, -np.inf
    for k in range(len(ERRORS)):
        off = np.log(ERRORS[k] / fit.rules.model_error) / ERROR_STD
        prior = learnt[k] - 0.5 * off * off
        above, highest = max(above, prior), max(highest, prior + room[k])
        most = max(most, room[k])
    total, before, middle, square = 0.0, 0.0, 0.0, 0.0
    for k in range(len(ERRORS)):
        off = np.log(ERRORS[k] / fit.rules.model_error) / ERROR_STD
        prior = learnt[k] - 0.5 * off * off
        share = np.exp(prior + room[k] - highest)
        total += share
        before += np.exp(prior - above)
        middle += share * np.log(ERRORS[k])
        square += share * ERRORS[k] * ERRORS[k]
        here[k] = max(room[k] - most, -MOST_SAID)
    own.numbers[MISFIT] = np.exp(middle / total)
    own.numbers[SPREAD] = np.sqrt(square / total)
    own.numbers[TOTAL] = np.log(total / before) + highest - above - known


@inner(_nrt=False)
def learn(fit: Fit) -> None:
    """Count what the press before says of the model error, where this is another one."""
    own, errors = fit.own, fit.own.errors
    unsure = own.numbers[READ_STEP] < 0.0 and own.numbers[SCALE] < 1.0  # of the noise
    if not fit.memory.counts[NOW] or unsure:
        return
    x, y = own.numbers[PLACE_X], own.numbers[PLACE_Y]
    nearest, least = 0, np.inf
    for n in range(fit.memory.counts[NOW]):
        apart = np.hypot(fit.memory.atoms[NOW, n, 0] - x, fit.memory.atoms[NOW, n, 1] - y)
        if apart < least:
            nearest, least = n, apart
    if not least <= ELSEWHERE:
        for k in range(len(ERRORS)):
            errors[LEARNT, k] = FORGET * (errors[LEARNT, k] + errors[LAST, k])
        own.marks[PRESSES] += 1
        own.numbers[PLACE_X] = fit.memory.atoms[NOW, nearest, 0]
        own.numbers[PLACE_Y] = fit.memory.atoms[NOW, nearest, 1]
    for k in range(len(ERRORS)):
        errors[LAST, k] = errors[HERE, k]
