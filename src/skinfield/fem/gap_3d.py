"""Laplace's equation below a surface of any shape, on a box that is stretched to the gap.

With z = ζ g(x, y) the box 0 <= ζ <= 1 is flat, and the gap's slope is in the coefficients. Fields
are summed axis by axis, and conjugate gradients are preconditioned with the flat gap's operator,
inverted exactly as in `skinfield.fem.box`. Lengths are in thicknesses.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, InputError, as_floats, check_positive, check_shape
from skinfield.fem.box import along_axes
from skinfield.fem.grading import graded, towards
from skinfield.fem.lines import Line
from skinfield.fem.solution_3d import densities
from skinfield.fem.trace import shapes, slopes

BEYOND = 5.0  # thicknesses around the pads and the dents
POINTS, WEIGHTS = (a / 2 for a in np.polynomial.legendre.leggauss(4))
POINTS = POINTS + 0.5


@dataclass(frozen=True, eq=False)
class Gap:
    """A gap on a mesh.

    Attributes
    ----------
    lines : (Line, Line, Line)
    depth : callable
        Indentation (N,) at x and y (N,), in thicknesses.
    """

    lines: tuple[Line, Line, Line]
    depth: Callable[[Floats, Floats], Floats]

    @cached_property
    def _values(self) -> list[Floats]:
        """Shape functions at the Gauss points of each line, (points, nodes)."""
        return [_at_gauss(line, shapes(POINTS), False) for line in self.lines]

    @cached_property
    def _slopes(self) -> list[Floats]:
        return [_at_gauss(line, slopes(POINTS), True) for line in self.lines]

    @cached_property
    def _coefficients(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Weight times gap, and the gap's slopes over the gap, at the Gauss points."""
        nodes = [line.nodes for line in self.lines]
        x, y = np.meshgrid(nodes[0], nodes[1], indexing="ij")
        gap = 1.0 - self.depth(x.ravel(), y.ravel()).reshape(x.shape)
        if not gap.min() > 0:
            raise InputError(
                f"indentation reaches {1 - gap.min():.2f} of the thickness, expected below 1: the "
                "ground plane would touch the pads"
            )
        at = self._values[0] @ gap @ self._values[1].T
        along = self._slopes[0] @ gap @ self._values[1].T / at
        across = self._values[0] @ gap @ self._slopes[1].T / at
        dx, dy, dz = (np.repeat(np.diff(n[::2]), 4) * np.tile(WEIGHTS, len(n) // 2) for n in nodes)
        height = self._values[2] @ nodes[2]
        weight = (dx[:, None] * dy * at)[:, :, None] * dz
        tilt_x, tilt_y = along[:, :, None] * height, across[:, :, None] * height
        return weight, tilt_x, tilt_y, 1.0 / at[:, :, None]

    def charges(self, potential: Floats) -> Floats:
        """Nodal charges (nx, ny, nz) of a potential, per permittivity."""
        value, slope = self._values, self._slopes
        weight, tilt_x, tilt_y, inverse = self._coefficients
        ways = [[slope[0], *value[1:]], [value[0], slope[1], value[2]], [*value[:2], slope[2]]]
        x, y, up = (along_axes(way, potential) for way in ways)
        field_x, field_y, field_z = x - tilt_x * up, y - tilt_y * up, up * inverse
        fluxes = (
            weight * field_x,
            weight * field_y,
            weight * (field_z * inverse - tilt_x * field_x - tilt_y * field_y),
        )
        back = [[matrix.T for matrix in way] for way in ways]
        return np.asarray(
            sum(along_axes(way, flux) for way, flux in zip(back, fluxes, strict=True))
        )

    def density(self) -> Floats:
        """Charge (nx, ny) of the base at its nodes, relative to that of plates."""
        from scipy.sparse.linalg import LinearOperator, cg

        shape = tuple(len(line.nodes) for line in self.lines)
        inner = slice(1, -1)
        modes = [
            line.modes(free)
            for line, free in zip(self.lines, (slice(None), slice(None), inner), strict=True)
        ]
        vectors = [vector for vector, _ in modes]
        x, y, z = (values for _, values in modes)
        inverse = 1.0 / (x[:, None, None] + y[:, None] + z)
        back = [vector.T for vector in vectors]

        def apply(unknown: Floats) -> Floats:
            potential = np.zeros(shape)
            potential[..., inner] = unknown.reshape(*shape[:2], -1)
            return self.charges(potential)[..., inner].ravel()

        def precondition(charge: Floats) -> Floats:
            whole = np.zeros(shape)
            whole[..., inner] = charge.reshape(*shape[:2], -1)
            return along_axes(vectors, inverse * along_axes(back, whole))[..., inner].ravel()

        start = np.broadcast_to(1.0 - self.lines[2].nodes, shape).copy()
        right = -self.charges(start)[..., inner].ravel()
        size = 2 * (len(right),)
        found, status = cg(
            LinearOperator(size, matvec=apply, dtype=float), right, rtol=1e-9, maxiter=1000,
            M=LinearOperator(size, matvec=precondition, dtype=float),
        )  # fmt: skip
        if status != 0:
            raise InputError("1000 conjugate gradients did not converge: the gap is too narrow")
        start[..., inner] += found.reshape(*shape[:2], -1)
        return densities(self.lines[:2], self.charges(start)[..., 0])


def pad_capacitance_3d(
    thickness: float,
    indentation: Callable[[Floats], Floats],
    pads: ArrayLike,
    pad_diameter: float,
    *,
    around: ArrayLike,
    cell: float = 0.15,
) -> Floats:
    """Relative change of capacitance of guarded pads below a surface of any shape.

    Parameters
    ----------
    thickness : float, m
        Of the gap where nothing presses.
    indentation : callable
        Depths (N,) m at points (N, 2) m, as `BoxSolution.indentation`.
    pads : (L, 2) array, m
        Centres of the pads.
    pad_diameter : float, m
    around : (2, 2) array, m
        Lowest and highest x and y of what is bent: meshed with `cell`.
    cell : float
        Side of the bricks, in thicknesses.

    Returns
    -------
    (L,) array
        ΔC/C₀, positive where the gap is narrower.

    Raises
    ------
    InputError
        If the indentation reaches the pads, or scikit-fem is missing.
    """
    check_positive("thickness", thickness, "of the gap, in metres")
    check_positive("pad_diameter", pad_diameter, "of the electrode, in metres")
    check_positive("cell", cell, "side of the bricks, in thicknesses")
    centres, bent = as_floats("pads", pads) / thickness, as_floats("around", around) / thickness
    check_shape("pads", centres, (None, 2), "x and y of their centres, in metres")
    check_shape("around", bent, (2, 2), "lowest and highest x and y of what is bent, in metres")
    radius = pad_diameter / 2 / thickness
    plane = [_line(bent[:, axis], centres[:, axis], radius, cell) for axis in range(2)]
    upwards = Line.along(1.0 - graded([0.0, 1.0], towards([0.0], cell, 0.3, 0.2))[::-1])

    def depth(x: Floats, y: Floats) -> Floats:
        return np.asarray(indentation(np.column_stack([x, y]) * thickness)) / thickness

    density = Gap((plane[0], plane[1], upwards), depth).density() - 1.0
    return np.array([_disc(plane[0], plane[1], density, centre, radius) for centre in centres])


def _line(bent: Floats, centres: Floats, radius: float, cell: float) -> Line:
    low = min(bent[0], float(centres.min()) - radius)
    high = max(bent[1], float(centres.max()) + radius)

    def size(at: Floats) -> Floats:
        away = np.maximum(np.maximum(bent[0] - at, at - bent[1]), 0.0)
        return np.minimum(cell + 0.3 * np.asarray(away), 0.8)

    return Line.along(graded([low - BEYOND, high + BEYOND], size))


def _at_gauss(line: Line, local: Floats, derivative: bool) -> Floats:
    """Local functions (4, 3) of every element at its Gauss points, (points, nodes)."""
    lengths = np.diff(line.nodes[::2])
    whole = np.zeros((4 * len(lengths), len(line.nodes)))
    for element, length in enumerate(lengths):
        block = local / length if derivative else local
        whole[4 * element : 4 * element + 4, 2 * element : 2 * element + 3] = block
    return whole


def _disc(x: Line, y: Line, density: Floats, centre: Floats, radius: float) -> float:
    """Mean over a disc."""
    points, weights = np.polynomial.legendre.leggauss(16)
    ring = radius * (points + 1) / 2
    angle = (np.arange(48) + 0.5) * 2 * np.pi / 48
    at_x = (centre[0] + ring[:, None] * np.cos(angle)).ravel()
    at_y = (centre[1] + ring[:, None] * np.sin(angle)).ravel()
    values = np.einsum("pi,ij,pj->p", x.interpolation(at_x), density, y.interpolation(at_y))
    weight = np.repeat(weights * ring, 48)
    return float(values @ weight / weight.sum())
