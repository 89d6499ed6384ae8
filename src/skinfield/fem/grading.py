"""Vertices along a line, close where something happens and far apart where nothing does."""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from skinfield.errors import Floats


def graded(stops: Sequence[float], size: Callable[[Floats], Floats]) -> Floats:
    """Vertices (n,) from the first to the last stop, all stops among them.

    Parameters
    ----------
    stops : increasing numbers
    size : callable
        Wanted length of the elements at given places; met from below.
    """
    pieces = []
    for start, stop in pairwise(stops):
        places = np.linspace(start, stop, 2001)
        density = 1.0 / size(places)
        steps = np.diff(places) * (density[1:] + density[:-1]) / 2
        count = np.concatenate([[0.0], np.cumsum(steps)])
        elements = max(int(np.ceil(count[-1] - 1e-9)), 1)
        pieces.append(np.interp(np.linspace(0, count[-1], elements + 1), count, places)[:-1])
    return np.concatenate([*pieces, [stops[-1]]])


def towards(
    places: Sequence[float], finest: float, growth: float, coarsest: float
) -> Callable[[Floats], Floats]:
    """Length of elements that grows with the distance from the nearest of some places.

    Parameters
    ----------
    places : numbers
    finest, coarsest : float
        Least and greatest length.
    growth : float
        Of the length per distance.
    """
    centres = np.asarray(places, dtype=float)

    def size(at: Floats) -> Floats:
        distance = np.abs(at[:, None] - centres).min(axis=1)
        return np.minimum(finest + growth * np.asarray(distance), coarsest)

    return size
