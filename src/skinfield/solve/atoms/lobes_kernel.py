"""Lobes of readings, compiled: which atoms are one contact where the model is far off.

A soft finger on a skin that reads unlike its model is several atoms, each of which makes up for
what the others are wrong by: their evidence says nothing of how many bodies touch. The readings
themselves do. Water falls from the highest taxel (see `regions_kernel`); two lobes are two contacts
if the valley between them is deeper than the model error and the noise of the lower peak account
for, and atoms in one lobe are one. Atoms in no lobe make up for readings below rest.
"""

from typing import Any, NamedTuple

import numpy as np

from skinfield.compiled import inner
from skinfield.errors import Floats, Ints
from skinfield.estimate.regions_kernel import sort_falling, top_of
from skinfield.solve.atoms.fit_kernel import NOW, READINGS, FitMemory

UNSURE = 0.1  # model error, from which on evidence does not say how many contacts there are
RESOLVED = 1.8  # distances of taxels: lobes further apart have a taxel in the valley between them
DEVIATIONS = 2.0  # by which a valley is deeper than errors account for
LONE, NONE = -1, -2  # lobe of an atom that is as it is drawn, and of one that is no contact


class Lobes(NamedTuple):
    """Taxels by their neighbours, L, and room.

    Attributes
    ----------
    distance : float
        Of taxels, in thicknesses.
    first : (L + 1,) int array
        Neighbours of taxel i are those of `taxels` from `first[i]` on.
    taxels : (N,) int array
    wet : (L,) int array
        Place of each taxel by falling reading, -1 if the water has not left it; dry between calls.
    values : (2, L) array
    tables : (3, L) int array
    """

    distance: float
    first: Ints
    taxels: Ints
    wet: Ints
    values: Floats
    tables: Ints

    @classmethod
    def of(cls, places: Floats) -> "Lobes":
        """Of taxels at places (L, 2), in thicknesses."""
        from scipy.spatial import cKDTree

        tree, count = cKDTree(places), len(places)
        nearest = np.asarray(tree.query(places, min(2, count))[0]).reshape(count, -1)
        distance = float(np.median(nearest[:, -1]))
        near: Any = tree.query_ball_point(places, RESOLVED * distance, return_sorted=True)
        first = np.cumsum([0, *[len(own) for own in near]])
        taxels = np.concatenate([np.asarray(own, np.int64) for own in near])
        tables = np.zeros((3, count), np.int64)
        wet = np.full(count, -1, np.int64)
        return cls(distance, first.astype(np.int64), taxels, wet, np.zeros((2, count)), tables)


@inner
def number_lobes(
    readings: Floats, offset: float, noise: Floats, error: float, lobes: Lobes
) -> tuple[int, float]:
    """Number the hills of readings (L,); how many taxels are above rest, and the highest reading.

    The peak of the n-th of them, by falling reading, is `tables[0, n]`. `noise` is infinite of
    taxels that are not heard.
    """
    hill, taxels, spare = lobes.tables[0], lobes.tables[1], lobes.tables[2]
    values, wet, count = lobes.values[0], lobes.wet, 0
    for taxel in range(len(readings)):
        value = readings[taxel] - offset
        if value > DEVIATIONS * noise[taxel]:
            values[count], taxels[count] = value, taxel
            count += 1
    sort_falling(values[:count], taxels[:count], lobes.values[1], spare)
    for number in range(count):
        taxel, best = taxels[number], number
        for at in range(lobes.first[taxel], lobes.first[taxel + 1]):
            if wet[lobes.taxels[at]] >= 0:
                best = min(best, top_of(hill, wet[lobes.taxels[at]]))
        hill[number], wet[taxel] = best, number
        for at in range(lobes.first[taxel], lobes.first[taxel + 1]):
            other = wet[lobes.taxels[at]]
            lower = top_of(hill, other) if other >= 0 else best
            drop = DEVIATIONS * np.hypot(error * values[lower], noise[taxels[lower]])
            if lower != best and values[lower] - values[number] < drop:
                hill[lower] = best
    for number in range(count):
        hill[number] = top_of(hill, number)
    return count, values[0] if count else 0.0


@inner
def join_by_lobes(
    places: Floats,
    memory: FitMemory,
    offset: float,
    noise: Floats,
    error: float,
    lobes: Lobes,
    out: Ints,
) -> bool:
    """Write the lobe of each atom of NOW into `out` (W,); whether any are joined or are none.

    An atom is in the lobe of the highest reading within a distance of taxels of it. A lobe lower
    than the model error of the highest one is none. Where no atom is in any, all stay as they are.

    Parameters
    ----------
    places : (L, 2) array
        Of the taxels, in thicknesses.
    offset : float
        That all taxels share.
    noise : (L,) array
    error : float
        What the model is wrong by, part of what taxels read.
    """
    count, readings, in_lobe = memory.counts[NOW], memory.taxels[READINGS], 0
    for n in range(len(out)):
        out[n] = LONE
    if not error > UNSURE or count < 2:
        return False
    wet, values = lobes.wet, lobes.values[0]
    above, highest = number_lobes(readings, offset, noise, error, lobes)
    for n in range(count):
        atom, best = memory.atoms[NOW, n], above
        for taxel in range(len(places)):
            x, y = places[taxel, 0] - atom[0], places[taxel, 1] - atom[1]
            if wet[taxel] >= 0 and x * x + y * y < lobes.distance * lobes.distance:
                best = min(best, wet[taxel])
        out[n] = NONE
        if best < above and values[lobes.tables[0, best]] > error * highest:
            out[n] = lobes.tables[0, best]
            in_lobe += 1
    for number in range(above):
        wet[lobes.tables[1, number]] = -1
    if not in_lobe:
        for n in range(count):
            out[n] = LONE
    return in_lobe > 0
