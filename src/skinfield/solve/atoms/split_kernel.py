"""Two contacts in the place of one, compiled: where they would be, and how sure their number is.

Between taxels a thin skin is nearly blind: what two close contacts read has many minima, which no
descent from the one leads to. So all pairs of templates around it are tried, each with the two
forces that explain most; the best of them are refined.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner
from skinfield.errors import Floats, Ints
from skinfield.solve.atoms.alternatives_kernel import GAP, apart
from skinfield.solve.atoms.atom_readings import PARAMETERS, free_of, parameter_of
from skinfield.solve.atoms.cholesky_kernel import factor, solve_factored
from skinfield.solve.atoms.dictionary import BLOCK, RADII, SPACING, Templates
from skinfield.solve.atoms.fit_kernel import (
    LEFT,
    NEAR,
    NOW,
    READINGS,
    WHITE,
    FitMemory,
    FitModel,
)
from skinfield.solve.atoms.posterior_kernel import laplace
from skinfield.solve.atoms.table import BALL

PLACES = 128  # around an atom, that two may be at
AWAY = 6.0  # thicknesses from it
RADIUS = 1.5  # thicknesses: of their templates,
SPACED = 2  # every so manieth place each way,
CLOSEST = 1.5  # thicknesses between the two
PAIRS = 2  # that are refined
SAME = 2.2 * SPACING  # thicknesses: pairs whose atoms differ by less are the same
NOISE_GAIN, ALIKE = 3.5, 0.02  # in cost, by a template that is not nearly what the atom may read
SURE = 0.7  # largest deviation of the logarithm of a force for which Laplace's evidence holds
MAYBE = 4.0  # ln odds within which another number of contacts is not ruled out
MOVED = 1.0  # thicknesses from reading to reading, within which a contact is the same
# Columns of `PairMemory.rivals`: how many contacts explain nearly as well as this one and those it
# is one of, 0 for none; ln odds against them; the place of the atom; and what the rival adds to the
# covariance of place, thicknesses, and force, parts of it: xx, xy, yy, x force, y force, force; and
# how probable it is.
NUMBER, ODDS, PLACE, ADDED, WEIGHT, COLUMNS = 0, 1, 2, 4, 10, 11
STATED, GATHERED = 0, 1
ATOMS, LISTED, SCANNED, FOUND = range(4)  # places of `PairMemory.state`


class PairMemory(NamedTuple):
    """Room for pairs of templates, and what rivals the atoms of an answer have.

    Attributes
    ----------
    rows : (PLACES, L) float32 array
        Whitened, per newton.
    listed : (PLACES,) int array
        Templates.
    columns : (10, L) float32 array
        Whitened: what is to be explained, what an atom leaves over, and its derivatives.
    sums : (2, PLACES) array
        Of squares of the rows, and of their products with what is to be explained.
    gains : (PLACES, PLACES) float32 array
    atoms : (2 PAIRS, 8) array
        The best pairs.
    spread : (3, 3) array
        Covariance of the middle of rivals and of the logarithm of their force.
    rivals : (2, M, COLUMNS) array
        Of the answer, and those of a comparison that is not done; see `NUMBER`.
    state : (4,) int array
        Atoms of the answer to which the former belong; templates that are listed, how many of them
        were compared with those before, and pairs found.
    """

    rows: NDArray[np.float32]
    listed: Ints
    columns: NDArray[np.float32]
    sums: Floats
    gains: NDArray[np.float32]
    atoms: Floats
    spread: Floats
    rivals: Floats
    state: Ints

    @classmethod
    def of(cls, taxels: int, most: int) -> "PairMemory":
        """Room for so many taxels and atoms."""
        return cls(
            np.zeros((PLACES, taxels), np.float32),
            np.zeros(PLACES, np.int64),
            np.zeros((2 + PARAMETERS, taxels), np.float32),
            np.zeros((2, PLACES)),
            np.zeros((PLACES, PLACES), np.float32),
            np.zeros((2 * PAIRS, PARAMETERS)),
            np.zeros((3, 3)),
            np.zeros((2, most, COLUMNS)),
            np.zeros(4, np.int64),
        )


RADIUS_AT = float(np.log(RADIUS))
assert RADIUS in RADII


@inner(fastmath=True, forceinline=True, _nrt=False)
def _product(one: NDArray[np.float32], other: NDArray[np.float32]) -> float:
    total = np.float32(0.0)
    for i in range(len(one)):
        total += one[i] * other[i]
    return float(total)


@inner(_nrt=False)
def list_templates(
    model: FitModel, bank: Templates, memory: FitMemory, pairs: PairMemory, index: int
) -> None:
    """List templates around an atom of NOW, which was just evaluated, to explain the row LEFT.

    None, if none of them would explain more than noise does of what NOW leaves over, by a linear
    model of the atom and the template.
    """
    white, middle, most = memory.taxels[WHITE], memory.atoms[NOW, index], 0.0
    near, size = memory.near[: memory.marks[NEAR]], PARAMETERS * memory.counts[NOW]
    free, system, right = free_of(middle), memory.system, memory.steps[0]
    first, count, columns = PARAMETERS * index, 0, pairs.columns
    for i in range(free):
        for j in range(free):
            at_j = first + parameter_of(middle, j)
            system[i * free + j] = memory.hessian[
                NOW, (first + parameter_of(middle, i)) * size + at_j
            ]
        system[i * free + i] += 1e-9
    known = factor(system, free)
    for taxel in range(len(white)):
        over = memory.taxels[READINGS, taxel] - memory.predicted[NOW, taxel]
        columns[0, taxel] = np.float32(memory.taxels[LEFT, taxel] * white[taxel])
        columns[1, taxel] = np.float32(over * white[taxel])
        for i in range(free):
            columns[2 + i, taxel] = np.float32(0.0)
    for k in range(memory.span[index, 0], memory.span[index, 1]):
        for i in range(free):
            slope = memory.jacobian[first + parameter_of(middle, i), k] * white[near[k]]
            columns[2 + i, near[k]] = np.float32(slope)
    for block in range(len(bank.firsts) - 1):
        corner = bank.atoms[bank.firsts[block]]
        if np.hypot(corner[0] - middle[0], corner[1] - middle[1]) > AWAY + 1.5 * BLOCK * SPACING:
            continue
        for t in range(bank.firsts[block], bank.firsts[block + 1]):
            atom = bank.atoms[t]
            x, y = atom[0] - middle[0], atom[1] - middle[1]
            if x * x + y * y > AWAY * AWAY or abs(atom[3] - RADIUS_AT) > 0.01:
                continue
            column = int(np.rint((atom[0] - model.places[0, 0]) / SPACING))
            line = int(np.rint((atom[1] - model.places[0, 1]) / SPACING))
            if column % SPACED or line % SPACED or count >= PLACES:
                continue
            row = pairs.rows[count]
            for taxel in range(len(white)):
                row[taxel] = np.float32(0.0)
            for i in range(bank.taxels.shape[1]):
                taxel = bank.taxels[block, i]
                per_newton = bank.templates[t, i] * bank.norms[t] * bank.noise[taxel]
                row[taxel] += np.float32(per_newton * white[taxel])
            squares = _product(row, row)
            if not squares > 0.0:
                continue
            pairs.sums[0, count], pairs.sums[1, count] = squares, _product(row, columns[0])
            pairs.listed[count] = t
            count += 1
            if known:
                over, rest = _product(row, columns[1]), squares
                for i in range(free):  # forward by the factor: what the atom may do as well
                    value = _product(row, columns[2 + i])
                    for k in range(i):
                        value -= system[i * free + k] * right[k]
                    right[i] = value / system[i * free + i]
                    rest -= right[i] * right[i]
                if rest > ALIKE * squares:
                    most = max(most, 0.5 * over * over / rest)
    if most < NOISE_GAIN:
        count = 0
    pairs.state[LISTED], pairs.state[SCANNED], pairs.state[FOUND] = count, 0, 0


@inner(_nrt=False)
def scan_pairs(bank: Templates, pairs: PairMemory, rows: int) -> None:
    """Compare some more templates with all before them.

    Two templates explain b^T G^-1 b / 2, b their products with what is to be explained, and G those
    with each other.
    """
    gains, squares, products = pairs.gains, pairs.sums[0], pairs.sums[1]
    end = min(pairs.state[SCANNED] + rows, pairs.state[LISTED])
    for i in range(pairs.state[SCANNED], end):
        one = bank.atoms[pairs.listed[i]]
        for j in range(i):
            other = bank.atoms[pairs.listed[j]]
            gains[i, j] = 0.0
            if np.hypot(one[0] - other[0], one[1] - other[1]) < CLOSEST:
                continue
            both = _product(pairs.rows[i], pairs.rows[j])
            first = squares[j] * products[i] - both * products[j]
            second = squares[i] * products[j] - both * products[i]
            if first > 0.0 and second > 0.0:
                determinant = squares[i] * squares[j] - both * both
                if not determinant > ALIKE * squares[i] * squares[j]:
                    continue
                gain = 0.5 * (first * products[i] + second * products[j]) / determinant
                gains[i, j] = np.float32(gain)
    pairs.state[SCANNED] = end


@inner(_nrt=False)
def choose_pairs(bank: Templates, pairs: PairMemory) -> None:
    """Write the best pairs of templates that differ."""
    gains, squares, products = pairs.gains, pairs.sums[0], pairs.sums[1]
    found, count = 0, pairs.state[LISTED]
    while found < PAIRS:
        best, one, other = np.float32(0.0), 0, 0
        for i in range(count):
            for j in range(i):
                if gains[i, j] > best:
                    best, one, other = gains[i, j], i, j
        if best <= 0.0:
            break
        both = _product(pairs.rows[one], pairs.rows[other])
        determinant = squares[one] * squares[other] - both * both
        for side in range(2):
            here, there = (one, other) if side == 0 else (other, one)
            force = squares[there] * products[here] - both * products[there]
            atom, chosen = pairs.atoms[2 * found + side], bank.atoms[pairs.listed[here]]
            for k in range(PARAMETERS):
                atom[k] = chosen[k]
            atom[2], atom[3] = np.log(force / determinant), 0.0
        first, second = pairs.atoms[2 * found], pairs.atoms[2 * found + 1]
        found += 1
        for i in range(count):
            for j in range(i):
                a, b = bank.atoms[pairs.listed[i]], bank.atoms[pairs.listed[j]]
                same = coincide(a, first) and coincide(b, second)
                if same or (coincide(a, second) and coincide(b, first)):
                    gains[i, j] = 0.0
    pairs.state[FOUND] = found


@inner(forceinline=True, _nrt=False)
def coincide(one: Floats, other: Floats) -> bool:
    """Whether two atoms are about at the same place."""
    return bool(abs(one[0] - other[0]) < SAME and abs(one[1] - other[1]) < SAME)


@inner(_nrt=False)
def are_known(model: FitModel, memory: FitMemory, local: Floats) -> bool:
    """Whether the forces of all atoms of NOW are known well enough to compare their evidence.

    Where readings do not tell two atoms from each other, or do not see one of them, the curvature
    of the cost is no width of the posterior. `local` is a (8, 8) matrix to work in.
    """
    for index in range(memory.counts[NOW]):
        laplace(model, memory, index, local)
        if not 0.0 < local[2, 2] < SURE * SURE:
            return False
    return True


@inner(_nrt=False)
def nearest_to(memory: FitMemory, index: int) -> int:
    """The atom of NOW whose rim is nearest to that of another one; -1 if none is near."""
    least, nearest = GAP, -1
    for other in range(memory.counts[NOW]):
        if other != index:
            gap = apart(memory, NOW, index, other)
            if gap < least:
                least, nearest = gap, other
    return nearest


@inner(_nrt=False)
def are_two(model: FitModel, memory: FitMemory, one: int, other: int, local: Floats) -> bool:
    """Whether two atoms of NOW are apart, and all forces known; see `are_known`."""
    return apart(memory, NOW, one, other) >= 0.0 and are_known(model, memory, local)


@inner(_nrt=False)
def take_spread(
    model: FitModel,
    memory: FitMemory,
    pairs: PairMemory,
    one: int,
    other: int,
    local: Floats,
) -> None:
    """Write the covariance of the middle and of ln force of one atom of NOW, or of two together."""
    laplace(model, memory, one, local)  # the factor of what moves, as `free` has it, stays
    size, right, first, second = 0, memory.steps[0], 0, 0
    for n in range(memory.counts[NOW]):
        first, second = size if n == one else first, size if n == other else second
        size += free_of(memory.atoms[NOW, n])
    share = 1.0
    if other != one:
        share = 1.0 / (1.0 + np.exp(memory.atoms[NOW, other, 2] - memory.atoms[NOW, one, 2]))
    for column in range(3):
        for i in range(size):
            right[i] = 0.0
        right[second + column] = 1.0 - share
        right[first + column] = share
        solve_factored(memory.system, size, right)
        for i in range(3):
            both = share * right[first + i] + (1.0 - share) * right[second + i]
            pairs.spread[i, column] = both


@inner(_nrt=False)
def leave_out(memory: FitMemory, index: int) -> None:
    """Take one atom out of NOW."""
    memory.counts[NOW] -= 1
    for n in range(index, memory.counts[NOW]):
        memory.family[NOW, n] = memory.family[NOW, n + 1]
        for i in range(PARAMETERS):
            memory.atoms[NOW, n, i] = memory.atoms[NOW, n + 1, i]


@inner(_nrt=False)
def put_pair(memory: FitMemory, pairs: PairMemory, index: int, which: int) -> None:
    """Put one of the pairs into the place of an atom of NOW, and behind the last."""
    for side in range(2):
        n = memory.counts[NOW] if side else index
        memory.family[NOW, n] = BALL
        for i in range(PARAMETERS):
            memory.atoms[NOW, n, i] = pairs.atoms[2 * which + side, i]
    memory.counts[NOW] += 1


@inner(_nrt=False)
def unite(memory: FitMemory, one: int, other: int) -> None:
    """Have an atom of NOW become a ball amid itself and another one, of the force of both."""
    its, away = memory.atoms[NOW, one], memory.atoms[NOW, other]
    force, more = np.exp(its[2]), np.exp(away[2])
    share = more / (force + more)
    for k in range(4):
        its[k] += share * (away[k] - its[k])
    its[2], its[4], its[5] = np.log(force + more), 0.0, 0.0
    for k in range(6, 8):
        its[k] += share * (away[k] - its[k])
    memory.family[NOW, one] = BALL


@inner(_nrt=False)
def forget_rivals(pairs: PairMemory) -> None:
    """Begin to gather rivals."""
    for n in range(pairs.rivals.shape[1]):
        pairs.rivals[GATHERED, n, NUMBER] = 0.0


@inner(_nrt=False)
def state_rivals(memory: FitMemory, pairs: PairMemory) -> None:
    """Have the rivals that were gathered be those of the answer NOW."""
    pairs.state[ATOMS] = memory.counts[NOW]
    for n in range(memory.counts[NOW]):
        for k in range(COLUMNS):
            pairs.rivals[STATED, n, k] = pairs.rivals[GATHERED, n, k]


@inner(_nrt=False)
def add_rival(
    pairs: PairMemory,
    n: int,
    atom: Floats,
    odds: float,
    count: int,
    one: Floats,
    other: Floats,
    share: float,
) -> None:
    r"""Note what may be in the place of the n-th atom of the answer: one atom, or it and another.

    Parameters
    ----------
    odds : float
        Logarithm of those against them; more probable ones that were noted before stay.
    share : float
        Part in which the atom would be them, and not another one of the answer.

    Notes
    -----
    By the law of total covariance, about what is stated: w times the rivals' own, `spread`, and
    :math:`w \sum_j f_j (x_j - x)(x_j - x)^T/f` are added, w the probability of the rivals. Odds are
    worth less than they say, as no skin is quite like its model: w is by their `MAYBE`-th root, so
    that an interval covers what it is taken for and what it may be.
    """
    row = pairs.rivals[GATHERED, n]
    if odds > MAYBE or (row[NUMBER] > 0.0 and row[ODDS] <= odds):
        return
    weight = share / (share + np.exp(max(odds, 0.0) / MAYBE))
    total = np.exp(one[2]) + (np.exp(other[2]) if count > 1 else 0.0)
    more = total * np.exp(-atom[2]) - 1.0
    row[NUMBER], row[ODDS], row[PLACE], row[PLACE + 1] = count, odds, atom[0], atom[1]
    for k in range(ADDED, COLUMNS):
        row[k] = 0.0
    for j in range(count):
        rival = one if j == 0 else other
        part = weight * np.exp(rival[2]) / total
        x, y = rival[0] - atom[0], rival[1] - atom[1]
        row[ADDED] += part * x * x
        row[ADDED + 1] += part * x * y
        row[ADDED + 2] += part * y * y
        row[ADDED + 3] += part * x * more
        row[ADDED + 4] += part * y * more
    row[ADDED + 5], row[WEIGHT] = weight * more * more, weight
    grown, at = 1.0 + more, ADDED
    for i, j in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)):
        own = pairs.spread[i, j]
        if j == 2:
            own *= grown * grown if i == 2 else grown
        row[at] += weight * own
        at += 1


@inner(_nrt=False)
def rival_of(memory: FitMemory, pairs: PairMemory, index: int) -> int:
    """How many contacts may be in the place of an atom of NOW, or of it and another; 0 if sure."""
    row, atom = pairs.rivals[STATED, index], memory.atoms[NOW, index]
    if pairs.state[ATOMS] != memory.counts[NOW] or row[NUMBER] == 0.0:
        return 0
    if not np.hypot(atom[0] - row[PLACE], atom[1] - row[PLACE + 1]) < MOVED:
        return 0
    row[PLACE], row[PLACE + 1] = atom[0], atom[1]
    return int(row[NUMBER])


@inner(_nrt=False)
def mix_covariance(pairs: PairMemory, index: int, covariance: Floats) -> None:
    """Mix the covariance (8, 8) of an atom with that of its rivals: of place and ln force."""
    row, at = pairs.rivals[STATED, index], ADDED
    for i in range(PARAMETERS):
        for j in range(PARAMETERS):
            covariance[i, j] *= 1.0 - row[WEIGHT]
    for i, j in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)):
        covariance[i, j] += row[at]
        if i != j:
            covariance[j, i] += row[at]
        at += 1
