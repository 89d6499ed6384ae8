r"""Readings of pads beside a round indentation, from Laplace's equation in the gap below it.

As in `deformed_gap`, the potential is 1 - zeta plus modes in zeta = z/g times functions of the
distance r from the axis, which make the field's energy least. Here they are finite elements of the
second degree in r, so that one band matrix of some thousand rows holds a whole indentation. A pad
reads the charge on the plane, which is the energy's derivative with respect to the potential there:
one product with a matrix that pads and elements alone determine.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, as_floats, check_finite, check_range, check_shape
from skinfield.observation.gap_modes import gap_modes

MODES = 6  # polynomials in zeta, up to degree 7
FINEST, COARSEST, GROWTH = 0.04, 0.25, 0.12  # elements: thicknesses on the axis, far, and per r
BEYOND = 3.0  # thicknesses of surface around the furthest pad: the field forgets as exp(-pi r/h)
RADII, ANGLES = 24, 48  # of the points that average over a pad
_POINTS = 3  # of Gauss and Legendre in each half of an element


@dataclass(frozen=True, eq=False)
class RoundGap:
    """A mesh along the radius and the pads that read it; all lengths in thicknesses.

    Made by `RoundGap.of`.

    Attributes
    ----------
    nodes : (M,) array
        Radii at which the strain is to be given, from 0.
    averages : (N, M) array
        Readings from the charge at the nodes.
    """

    nodes: Floats
    averages: Floats
    _mesh: "_Mesh" = field(repr=False)

    @classmethod
    def of(cls, pad_diameter: float, distances: ArrayLike) -> "RoundGap":
        """Prepare for pads whose centres are at some distances from the axis.

        Parameters
        ----------
        pad_diameter : float
            In thicknesses; 0 for the density of charge at the point itself.
        distances : (N,) array
            In thicknesses.
        """
        away = np.abs(as_floats("distances", distances))
        check_shape("distances", away, (None,), "one per pad")
        check_finite("distances", away, "of the pads' centres from the axis, in thicknesses")
        check_range("pad_diameter", pad_diameter, 0.0, 1e3, "in thicknesses")
        nodes = _nodes(float(away.max(initial=0.0)) + pad_diameter / 2 + BEYOND)
        return cls(nodes, _averages(nodes, away, pad_diameter / 2), _Mesh.of(nodes))

    def charge(self, strain: ArrayLike) -> Floats:
        """Density of charge at the nodes, relative to that of plates at rest, less one.

        Parameters
        ----------
        strain : (P, M) array
            Of the gap, w/h, at the nodes, below 1: one row per indentation.

        Returns
        -------
        (P, M) array

        Raises
        ------
        InputError
            If the surface reaches the pads.
        """
        v = as_floats("strain", strain)
        check_shape("strain", v, (None, len(self.nodes)), "one row per indentation, at the nodes")
        check_finite("strain", v, "of the gap, in thicknesses")
        if v.size and v.max() >= 1.0:
            raise InputError(
                f"strain reaches {v.max():.2f}, expected below 1: the skin would touch its base; "
                "lower the load or raise the modulus"
            )
        return np.stack([self._mesh.charge(*pair) for pair in zip(*self._gaps(v), strict=True)])

    def readings(self, strain: ArrayLike) -> Floats:
        """Relative change of capacitance (P, N) of the pads; see `charge`."""
        return np.asarray(self.charge(strain) @ self.averages.T)

    def _gaps(self, strain: Floats) -> tuple[Floats, Floats]:
        """Gap and its slope at the quadrature points, by cubics that never leave their data."""
        from scipy.interpolate import PchipInterpolator

        mirrored = np.concatenate([-self.nodes[1:2], self.nodes])
        values = np.concatenate([strain[:, 1:2], strain], axis=1)
        curve = PchipInterpolator(mirrored, 1.0 - values, axis=1)
        return curve(self._mesh.points), curve.derivative()(self._mesh.points)


def _nodes(furthest: float) -> Floats:
    """Ends and middles of the elements."""
    ends = [0.0]
    while ends[-1] < furthest:
        ends.append(ends[-1] + min(FINEST + GROWTH * ends[-1], COARSEST))
    edge = np.array(ends)
    return np.sort(np.concatenate([edge, (edge[1:] + edge[:-1]) / 2]))


def _shapes(at: Floats) -> tuple[Floats, Floats]:
    """Values and slopes (3, ...) of an element's functions at 0 to 1 along it."""
    x = np.asarray(at)
    values = np.stack([(1 - x) * (1 - 2 * x), 4 * x * (1 - x), x * (2 * x - 1)])
    return values, np.stack([4 * x - 3, 4 - 8 * x, 4 * x - 1])


def _averages(nodes: Floats, distances: Floats, radius: float) -> Floats:
    """Means over pads (N, M) of the functions that belong to the nodes."""
    node, weight = np.polynomial.legendre.leggauss(RADII)
    share = weight * (node + 1) / (2 * ANGLES)
    rho = radius * (node[:, None] + 1) / 2
    angle = (np.arange(ANGLES) + 0.5) * np.pi / ANGLES
    out = np.zeros((len(distances), len(nodes)))
    for row, distance in zip(out, distances, strict=True):
        at = np.hypot(distance + rho * np.cos(angle), rho * np.sin(angle))
        element = np.clip(np.searchsorted(nodes[::2], at, "right") - 1, 0, len(nodes) // 2 - 1)
        start, end = nodes[2 * element], nodes[2 * element + 2]
        values = _shapes((at - start) / (end - start))[0] * share[:, None]
        for local, value in enumerate(values):
            row += np.bincount((2 * element + local).ravel(), value.ravel(), len(nodes))
    return out


@dataclass(frozen=True, eq=False)
class _Mesh:
    """Elements of three nodes.

    Attributes
    ----------
    points : (points,) array
        Of quadrature.
    products : (3, points per element, 9) array
        Of the functions of an element: slope slope, slope value, value value.
    weights : (3, elements, points per element) array
        That go with them: r dr, over the length squared, once and not at all.
    """

    points: Floats
    products: Floats
    weights: Floats
    scatter: NDArray[np.int64]
    lower: NDArray[np.int64]
    mass: Floats
    plate: Floats

    @classmethod
    def of(cls, nodes: Floats) -> "_Mesh":
        node, weight = np.polynomial.legendre.leggauss(_POINTS)
        local = np.concatenate([(node + 1) / 4, (node + 3) / 4])
        length = np.diff(nodes[::2])[:, None]
        points = nodes[:-2:2, None] + length * local
        value, slope = _shapes(local)
        pairs = [slope[:, None] * slope, slope[:, None] * value, value[:, None] * value]
        around = np.concatenate([weight, weight]) / 4 * length * points
        weights = np.stack([around / length**2, around / length, around])
        products = np.stack([pair.reshape(9, -1).T for pair in pairs])
        mass = (weights[2] @ products[2]).reshape(-1, 3, 3)
        row, column = (side.ravel() for side in np.indices((3 * MODES, 3 * MODES)))
        lower = np.flatnonzero(row >= column)
        start = 2 * MODES * np.arange(len(length))[:, None]
        count = MODES * len(nodes)
        scatter = (row - column)[lower] * count + column[lower] + start
        return cls(
            points.ravel(), products, weights, scatter, lower,
            _band(mass, len(nodes)), _sums(mass.sum(axis=2), len(nodes)),
        )  # fmt: skip

    def charge(self, gap: Floats, slope: Floats) -> Floats:
        """Nodal values of the charge less that of plates at rest."""
        from scipy.linalg import solveh_banded

        blocks = self._blocks(
            gap.reshape(self.weights[0].shape), slope.reshape(self.weights[0].shape)
        )
        count = len(self.plate)
        inner = blocks[:, :, 1:, :, 1:].reshape(len(blocks), -1)[:, self.lower]
        band = np.bincount(self.scatter.ravel(), inner.ravel(), 3 * MODES * MODES * count)
        rest = _sums(blocks[:, :, 1:, :, 0].sum(axis=3), count)
        modes = solveh_banded(band.reshape(3 * MODES, -1), -rest.ravel(), lower=True)
        near = _windows(modes.reshape(count, MODES))
        push = blocks[:, :, 0, :, 0].sum(axis=2)
        push += np.einsum("eabj,ebj->ea", blocks[:, :, 0, :, 1:], near)
        return np.asarray(solveh_banded(self.mass, _sums(push, count) - self.plate, lower=True))

    def _blocks(self, gap: Floats, slope: Floats) -> Floats:
        """Second derivatives of the energy (elements, 3, MODES + 1, 3, MODES + 1)."""
        modes = gap_modes(MODES)
        steep, once, plain = self.weights
        stretch = (steep * gap) @ self.products[0]
        mixed = -(once * slope) @ self.products[1]
        turned = mixed.reshape(-1, 3, 3).transpose(0, 2, 1).reshape(-1, 9)
        tilt = (plain * slope**2 / gap) @ self.products[2]
        across = (plain / gap) @ self.products[2]
        sides = np.stack([stretch, mixed, turned, tilt, across], axis=-1)
        heights = np.stack(
            [modes.mass, modes.mixed, modes.mixed.T, modes.stretched, modes.stiffness]
        )
        size = MODES + 1
        joined = sides.reshape(-1, 5) @ heights.reshape(5, -1)
        return np.asarray(joined.reshape(-1, 3, 3, size, size).transpose(0, 1, 3, 2, 4))


def _windows(values: Floats) -> Floats:
    """Values (elements, 3, ...) at the nodes of each element."""
    return np.stack([values[:-2:2], values[1:-1:2], values[2::2]], axis=1)


def _sums(shares: Floats, count: int) -> Floats:
    """Sums at the nodes (count, ...) of shares (elements, 3, ...)."""
    out = np.zeros((count, *shares.shape[2:]))
    out[:-2:2] = shares[:, 0]
    out[1:-1:2] = shares[:, 1]
    out[2::2] += shares[:, 2]
    return out


def _band(blocks: Floats, count: int) -> Floats:
    """Lower band (3, count) of a matrix that is the sum of the elements' (elements, 3, 3)."""
    out = np.zeros((3, count))
    for row in range(3):
        for column in range(row + 1):
            out[row - column, column : count - 2 + column : 2] += blocks[:, row, column]
    return out
