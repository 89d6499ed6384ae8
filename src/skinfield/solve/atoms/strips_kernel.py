"""Fingers in readings, compiled: which atoms are one contact where the model is far off.

A soft finger on a skin that reads unlike its model is several atoms, each of which makes up for
what the others are wrong by: their evidence says nothing of how many bodies touch. Where the
readings stand out does: a finger, laid down or on its tip, is a strip as wide as a finger and at
most as long. The strips are those that cover most taxels that are touched and fewest that are not,
one after the other (the greedy cover of Nemhauser, Wolsey and Fisher 1978): as many as the touched
area says that there are fingers (see `fingers_kernel`), or, where it is no hand's, as are worth a
price. Atoms in one strip are one contact; atoms in none make up for readings below rest; and a
strip without an atom is part of the nearest that is wide enough to read for both.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner
from skinfield.errors import Floats, Ints
from skinfield.solve.atoms.fingers_kernel import FingerClasses, count_fingers
from skinfield.solve.atoms.fit_kernel import NOW, READINGS, FitMemory

UNSURE = 0.1  # model error, from which on evidence does not say how many contacts there are
HALF_WIDTH, LENGTH = 6e-3, 0.05  # m, of the axis of a finger's strip
LEAST_WIDTH = 0.9  # distances of taxels: narrower, a strip would miss those on both sides
DEVIATIONS = 3.0  # from which on a taxel is touched
PART = 0.2  # of the highest reading but one, from which on a taxel is touched
QUIET = 0.5  # of that, below which it is not
BELOW = 0.35  # of that, by which none reads below rest under a hand
GAP = 0.7  # touched taxels that one in a strip that is not outweighs
PRICE = 1.6  # touched taxels that a strip must win
MOST = 48  # touched taxels that strips are drawn between
NEAR = 200  # taxels that strips are judged by
REACH = 1.0  # squares of half a width, within which an atom is in a strip
STRIPS = 12
LONE, NONE = -1, -2  # strip of an atom that is as it is drawn, and of one that is no contact


class Strips(NamedTuple):
    """What strips are sought in, and room.

    Attributes
    ----------
    half, length : float
        Of a strip's width, and of its axis, in thicknesses.
    ends : (STRIPS, 4) array
        Of the strips that were found: x, y, x, y.
    middle : (STRIPS, 3) array
        Of them: x, y, and the sum of the readings that they were drawn for.
    counts : (2,) int array
        Strips that were found, 0 where atoms are as they are drawn; touched taxels.
    values : (2, L) array
    tables : (3, L) int array
    covered : (MOST * (MOST + 1) / 2, NEAR) bool array
    hands : FingerClasses
    """

    half: float
    length: float
    ends: Floats
    middle: Floats
    counts: Ints
    values: Floats
    tables: Ints
    covered: NDArray[np.bool_]
    hands: FingerClasses

    @classmethod
    def of(cls, places: Floats, thickness: float) -> "Strips":
        """Of taxels at places (L, 2), in thicknesses of m."""
        from scipy.spatial import cKDTree

        count = len(places)
        nearest = np.asarray(cKDTree(places).query(places, min(2, count))[0]).reshape(count, -1)
        pitch = float(np.median(nearest[:, -1]))
        half = max(HALF_WIDTH / thickness, LEAST_WIDTH * pitch)
        room = np.zeros((MOST * (MOST + 1) // 2, NEAR), np.bool_)
        tables = np.zeros((2, count), np.int64)
        ends, middle, values = np.zeros((STRIPS, 4)), np.zeros((STRIPS, 3)), np.zeros((2, count))
        counts = np.zeros(2, np.int64)
        hands = FingerClasses.of(1e3 * thickness, pitch, MOST)
        return cls(half, LENGTH / thickness, ends, middle, counts, values, tables, room, hands)


@inner
def square_away(x: float, y: float, ends: Floats) -> float:
    """Squared distance of a place from a segment."""
    east, north = ends[2] - ends[0], ends[3] - ends[1]
    x, y, square = x - ends[0], y - ends[1], east * east + north * north
    share = min(max((x * east + y * north) / square, 0.0), 1.0) if square > 0.0 else 0.0
    return float((x - share * east) ** 2 + (y - share * north) ** 2)


@inner
def gather_touched(
    places: Floats, readings: Floats, offset: float, noise: Floats, strips: Strips
) -> tuple[int, int]:
    """Gather the touched taxels, then all others near them; how many of each.

    None where one reads further below rest than a press of others makes it.

    `tables[0]` are they, `values[0]` what covering each is worth.
    """
    highest, second, lowest = 0.0, 0.0, 0.0
    for taxel in range(len(readings)):
        value = readings[taxel] - offset
        if noise[taxel] < np.inf:
            lowest = min(lowest, value + DEVIATIONS * noise[taxel])
        if value > DEVIATIONS * noise[taxel] and value > second:
            highest, second = max(highest, value), min(highest, value)
    taxels, worth, touched = strips.tables[0], strips.values[0], 0
    if -lowest > BELOW * second:
        return 0, 0
    for taxel in range(len(readings)):
        least = max(DEVIATIONS * noise[taxel], PART * second)
        if readings[taxel] - offset > least and touched < MOST:
            taxels[touched], worth[touched] = taxel, 1.0
            touched += 1
    near = touched
    reach = strips.half * strips.half
    for taxel in range(len(readings)):
        value = readings[taxel] - offset
        if not value < QUIET * max(DEVIATIONS * noise[taxel], PART * second) < np.inf:
            continue
        for n in range(touched):
            x, y = places[taxel] - places[taxels[n]]
            if x * x + y * y < 4.0 * reach and near < min(NEAR, len(taxels)):
                taxels[near], worth[near] = taxel, -GAP
                near += 1
                break
    return touched, near


@inner
def find_strips(
    places: Floats,
    readings: Floats,
    offset: float,
    touched: int,
    near: int,
    fingers: int,
    strips: Strips,
) -> int:
    """Write `ends` and `middle` of the strips that cover most of what is touched; how many.

    As many as there are fingers, as long as some cover more than they cost; 0 for any number of
    those that are worth a price.
    """
    taxels, worth, covered, ends = strips.tables[0], strips.values[0], strips.covered, strips.ends
    square, count = strips.half * strips.half, 0
    for i in range(touched):
        for j in range(i, touched):
            first, last = places[taxels[i]], places[taxels[j]]
            apart = (first[0] - last[0]) ** 2 + (first[1] - last[1]) ** 2
            row = i * touched - i * (i - 1) // 2 + j - i
            ends[0, 0], ends[0, 1], ends[0, 2], ends[0, 3] = first[0], first[1], last[0], last[1]
            for n in range(near):
                x, y = places[taxels[n], 0], places[taxels[n], 1]
                is_in = apart <= strips.length**2 and square_away(x, y, ends[0]) < square
                covered[row, n] = is_in
    while count < (min(fingers, len(ends)) if fingers else len(ends)):
        best, won = -1, 0.0 if fingers else PRICE
        for row in range(touched * (touched + 1) // 2):
            total = 0.0
            for n in range(near):
                if covered[row, n]:
                    total += worth[n]
            if total > won + 1e-9:
                best, won = row, total
        if best < 0:
            break
        i = 0
        while best >= (i + 1) * touched - (i + 1) * i // 2:
            i += 1
        j = best - (i * touched - i * (i - 1) // 2) + i
        for k in range(2):
            ends[count, k], ends[count, k + 2] = places[taxels[i], k], places[taxels[j], k]
        middle = strips.middle[count]
        middle[:] = 0.0
        for n in range(near):
            if covered[best, n]:
                if n < touched and worth[n] > 0.0:
                    value = readings[taxels[n]] - offset
                    middle[2] += value
                    for k in range(2):
                        middle[k] += value * places[taxels[n], k]
                worth[n] = 0.0
        middle[0], middle[1] = middle[0] / middle[2], middle[1] / middle[2]
        count += 1
    return count


@inner
def join_by_strips(
    places: Floats,
    memory: FitMemory,
    offset: float,
    noise: Floats,
    error: float,
    strips: Strips,
    out: Ints,
) -> bool:
    """Write the strip of each atom of NOW into `out` (W,); whether any are joined or are none.

    An atom is in the nearest strip, unless that is more than its width away. Where no atom is in
    any, or where more is touched than fingers do, all stay as they are.

    Parameters
    ----------
    places : (L, 2) array
        Of the taxels, in thicknesses.
    offset : float
        That all taxels share.
    noise : (L,) array
        Infinite of taxels that are not heard.
    error : float
        What the model is wrong by, part of what taxels read.
    """
    count, in_strip, readings = memory.counts[NOW], 0, memory.taxels[READINGS]
    strips.counts[:] = 0
    for n in range(len(out)):
        out[n] = LONE
    if not error > UNSURE or count == 0:
        return False
    touched, near = gather_touched(places, readings, offset, noise, strips)
    if touched == 0 or touched == MOST:  # no hand
        return False
    fingers = count_fingers(places, readings, offset, strips.tables[0], touched, strips.hands)
    found = find_strips(places, readings, offset, touched, near, fingers, strips)
    if count == 1 and found < 2:
        return False
    for n in range(count):
        x, y = memory.atoms[NOW, n, 0], memory.atoms[NOW, n, 1]
        nearest = REACH * strips.half * strips.half
        out[n] = NONE
        for strip in range(found):
            away = square_away(x, y, strips.ends[strip])
            if away < nearest:
                nearest, out[n] = away, strip
        in_strip += out[n] != NONE
    if not in_strip:
        for n in range(count):
            out[n] = LONE
        return False
    strips.counts[0], strips.counts[1] = found, touched
    return True
