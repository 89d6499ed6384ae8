"""Quadrature rules on a disc for integrands with kinks and end singularities."""

from itertools import pairwise

import numpy as np


def graded(*cuts: float):
    """Nodes and weights on the angles 0 to pi/2, crowded at cuts, where integrands may break."""
    nodes, weights = [], []
    u, share = np.polynomial.legendre.leggauss(60)
    u, share = (u + 1) / 2, share / 2
    for low, high in pairwise(sorted({0.0, *cuts, np.pi / 2})):
        half = (high - low) / 2
        for end, way, inner in ((low, half, low > 0), (high, -half, high < np.pi / 2)):
            power = 4 if inner else 1
            nodes.append(end + way * u**power)
            weights.append(half * power * u ** (power - 1) * share)
    return np.hstack(nodes), np.hstack(weights)


def disc_rule(kink: float = 0.0):
    """Radii in a unit disc, and weights of 2 pi r dr, for pressures with a kink."""
    angle, weight = graded(np.arcsin(kink))
    return np.sin(angle), weight * 2 * np.pi * np.sin(angle) * np.cos(angle)
