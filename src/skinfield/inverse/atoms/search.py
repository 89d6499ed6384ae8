"""The smallest set of atoms that explains a reading, found greedily."""

from collections.abc import Iterator

import numpy as np

from skinfield.inverse.atoms.moves import (
    as_family,
    as_line,
    as_ring,
    as_round,
    clusters,
    one_more,
    split,
    without,
)
from skinfield.inverse.atoms.problem import BURST, AtomSet, Problem
from skinfield.inverse.atoms.profiles import BALL, FLAT, RING

ODD = 1.0  # standard deviations of chi-squared, above which other shapes are tried
GAP = 3.5  # thicknesses between the rims of atoms that may be one body


def search(
    problem: Problem, start: AtomSet | None, most: int, starts: int, shapes: bool = True
) -> AtomSet:
    """Grow, prune and reshape a set of atoms while that pays.

    Parameters
    ----------
    problem : Problem
    start : AtomSet, optional
        Of the reading before.
    most : int
        Atoms.
    starts : int
        Places from which each new atom is sought.
    shapes : bool
        Whether to look at the shapes again where `start` explains the reading as it is.
    """
    found, grew = problem.nothing(), False
    if start is not None and len(start):
        found = pruned(problem, problem.refined(start.atoms, start.family, BURST))
    while not problem.late and len(found) < most:
        better = grown(problem, found, starts)
        if better is None:
            break
        found, grew = better, True
    if grew:
        found = pruned(problem, found)
    changed = start is None or grew or len(found) != len(start)
    return reshaped(problem, found) if shapes or changed else found


def grown(problem: Problem, found: AtomSet, starts: int) -> AtomSet | None:
    """One more ball, or one atom of another shape, whichever is more probable; None if not."""
    more = one_more(problem, found, starts)
    if more is None or found.cost - more.cost < problem.threshold:
        return None
    best, evidence = more, problem.evidence(more)
    for index in np.flatnonzero(~found.long & (found.family != RING)).tolist():
        for other in _bodies(problem, found, [index]):
            value = problem.evidence(other)
            if value > evidence:
                best, evidence = other, value
    return best


def _bodies(problem: Problem, found: AtomSet, members: list[int]) -> Iterator[AtomSet]:
    """The set with one body that is not round in the place of some atoms."""
    if not problem.late:
        yield as_line(problem, found, members, BALL)
    if not problem.late:
        yield as_line(problem, found, members, FLAT)
    if not problem.late:
        yield as_ring(problem, found, members)


def pruned(problem: Problem, found: AtomSet) -> AtomSet:
    """Without the atoms that the reading does not need."""
    index = 0
    while index < len(found) and not problem.late:
        less = without(problem, found, index)
        if less.cost - found.cost < problem.threshold:
            found, index = less, 0
        else:
            index += 1
    return found


def reshaped(problem: Problem, found: AtomSet) -> AtomSet:
    """Each atom in the most probable shape, and neighbours as one body where that is more so."""
    if not len(found):
        return found
    evidence = problem.evidence(found)
    for index in range(len(found)):
        for other in _alternatives(problem, found, index):
            value = problem.evidence(other)
            if value > evidence:
                found, evidence = other, value
    for members in clusters(found, GAP):
        if len(members) < 2:
            continue
        for other in _bodies(problem, found, members):
            value = problem.evidence(other)
            if value > evidence:
                return reshaped(problem, other)
    return found


def _alternatives(problem: Problem, found: AtomSet, index: int) -> Iterator[AtomSet]:
    """The set with one atom of the other family, round, or as two."""
    if problem.late or index >= len(found):
        return
    if found.family[index] == RING:
        yield as_round(problem, found, index, BALL)
        yield as_round(problem, found, index, FLAT)
        return
    yield as_family(problem, found, index, BALL + FLAT - int(found.family[index]))
    if not found.long[index] and problem.misfit(found) > ODD:
        yield from _bodies(problem, found, [index])
    if found.long[index] and not problem.late:
        yield as_round(problem, found, index, BALL)
        yield as_round(problem, found, index, FLAT)
        yield split(problem, found, index)
