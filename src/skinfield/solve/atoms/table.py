r"""Table of what round atoms do to a layer, and the profiles of pressure that they have.

On a layer much thicker than the contact is wide they are Hertz's
:math:`\frac{3F}{2\pi a^2}\sqrt{1 - r^2/a^2}` and Boussinesq's
:math:`\frac{F}{2\pi a^2}/\sqrt{1 - r^2/a^2}`; on a thinner one, the exact solution of
`elastic.axisymmetric`. Both depend on the force as a factor alone. A ring is a narrow, even
annulus: what a rim or the edge of a cup leaves, as far as taxels below a layer can tell.

A reading at the distance r of a contact of radius a that is pressed with the force F is

.. math:: F\,s(a)\,\frac{\sum_k u^k\,C_k(r, \ln a)}{1 - u}, \quad u = F\,s(a),

for a pad that reads the capacitance: s is the strain of the gap where it is highest, per newton,
and the denominator what a uniform gap would have. A quantity that is linear in the force is
:math:`F\,C_0(r, \ln a)`. The tables :math:`C_k` are cubic B-splines over r and ln a.
"""

import hashlib
import math
import os
import tempfile
from collections.abc import Hashable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast
from zipfile import BadZipFile

import numpy as np

from skinfield.compiled import cache_folder, inner, njit
from skinfield.elastic import BondedLayer, Capacitance, Layer, Mechanics, Physics
from skinfield.errors import Floats, Ints
from skinfield.processes import processors
from skinfield.skin import Grid, Patch
from skinfield.solve.atoms.shear_table import Traction, shear_readings

if TYPE_CHECKING:
    from skinfield.elastic.axisymmetric import Indentation


class PointResponse(NamedTuple):
    """Response to a point load, as cubics between nodes in two even meshes.

    `mesh` (M,) m, the first `near` of them `near_step` apart, the others `far_step`; `cubics`
    (M - 1, 4), of the distance from the node before, the highest power first.
    """

    mesh: Floats
    cubics: Floats
    near_step: float
    far_step: float
    near: int


@inner
def _response(distance: float, point: PointResponse) -> float:
    """At a distance in m; the last cubic goes on beyond the mesh."""
    border = point.mesh[point.near]
    if distance < border:
        at = int(distance / point.near_step)
    else:
        at = point.near + int((distance - border) / point.far_step)
    at = min(at, len(point.cubics) - 1)
    x = distance - point.mesh[at]
    c = point.cubics[at]
    return float(((c[0] * x + c[1]) * x + c[2]) * x + c[3])


SIXTH, TWO_THIRDS = 1.0 / 6.0, 2.0 / 3.0


@inner
def cubic(t: float) -> tuple[float, float, float, float]:
    """Cubic B-splines of four nodes, 0 to 1 past the second."""
    s, tt = 1.0 - t, t * t
    ss = s * s
    second, third = (0.5 * t - 1.0) * tt + TWO_THIRDS, (0.5 * s - 1.0) * ss + TWO_THIRDS
    return SIXTH * ss * s, second, third, SIXTH * tt * t


@inner
def cubic_slopes(t: float) -> tuple[float, float, float, float]:
    """Slopes of `cubic`, per node."""
    s = 1.0 - t
    return -0.5 * s * s, 1.5 * t * t - 2.0 * t, 2.0 * s - 1.5 * s * s, 0.5 * t * t


@njit(heavy=True)
def ring_sums(
    r: Floats, radii: Floats, forces: Floats, counts: Ints, point: PointResponse
) -> Floats:
    """Response (N,) at distances `r` (N,) m from the axis of rings (M,) that bear `forces`.

    A ring stands for as many point loads on half of it as `counts` says.
    """
    out = np.zeros(len(r))
    for m in range(len(radii)):
        ring, count = radii[m], counts[m]
        cosine = np.empty(count)
        for k in range(count):
            cosine[k] = math.cos((k + 0.5) * math.pi / count)
        for n in range(len(r)):
            total = 0.0
            for k in range(count):
                square = r[n] * r[n] + ring * ring - 2.0 * ring * r[n] * cosine[k]
                total += _response(math.sqrt(max(square, 0.0)), point)
            out[n] += forces[m] * total / count
    return out


BALL, FLAT, RING = 0, 1, 2
FAMILIES = (BALL, FLAT, RING)
RIM = 0.4  # thicknesses: width of a ring
SOURCE_CELL = 0.08  # thicknesses: side of the square that stands for a point
RIM_RINGS = 4
NEAR, FAR, REACH = 400, 3000, 60.0  # mesh of a point's response: within a thickness, and beyond
RINGS = 12  # Gauss-Legendre nodes in sqrt(1 - r²/a²), in which both pressures are smooth


def unit_pressure(
    layer: Layer, mechanics: Mechanics, family: int, radius: float, r: Floats
) -> Floats:
    """Pressure in Pa per N at distances `r` in m from the axis; 0 outside the contact.

    Parameters
    ----------
    layer : Layer
    mechanics : Mechanics
        One without reach stands for a half-space.
    family : BALL, FLAT or RING
        The pressure of a flat end is infinite at its edge.
    radius : float, m
        Of the contact.
    r : array, m
    """
    r = np.asarray(r, dtype=np.float64)
    if family == RING:
        inner, outer = _rim(layer, radius)
        return np.where((r > inner) & (r < outer), 1.0 / (np.pi * (outer**2 - inner**2)), 0.0)
    if np.isfinite(mechanics.reach(layer)):
        state = _indentation(layer, family, radius)
        return np.asarray(state.pressure(r)) / state.force
    inside = r < radius
    root = np.sqrt(np.where(inside, 1.0 - (np.minimum(r, radius) / radius) ** 2, 1.0))
    shape = 1.5 * root if family == BALL else 0.5 / root
    return np.where(inside, shape, 0.0) / (np.pi * radius**2)


def load_quadrature(
    layer: Layer, mechanics: Mechanics, family: int, radius: float
) -> tuple[Floats, Floats]:
    """Rings that carry 1 N together as the contact does.

    Returns
    -------
    radii : (M,) array, m
    forces : (M,) array, N
        Sum 1. Integrals of the pressure with a smooth function become sums.
    """
    if family == RING:
        inner, outer = _rim(layer, radius)
        radii = inner + (outer - inner) * (np.arange(RIM_RINGS) + 0.5) / RIM_RINGS
        return radii, radii / radii.sum()
    node, weight = np.polynomial.legendre.leggauss(RINGS)
    root, weight = (node + 1.0) / 2.0, weight / 2.0  # of 1 - r²/a²: r dr = a² root d(root)
    radii = radius * np.sqrt(1.0 - root**2)
    pressure = unit_pressure(layer, mechanics, family, radius, radii)
    forces = 2.0 * np.pi * radius**2 * pressure * root * weight
    return radii, forces / forces.sum()


def curvature_force(layer: Layer, radius: float) -> float:
    """Force in N times radius of curvature in m of a ball that touches within `radius` m."""
    return float(_indentation(layer, BALL, radius).force)


def unit_indentation(
    layer: Layer, mechanics: Mechanics, family: int, radius: float, r: Floats
) -> Floats:
    """Displacement into the skin, m per N, at distances `r` (N,) m from the axis."""
    if isinstance(mechanics, BondedLayer) and family != RING:
        state = _indentation(layer, family, radius)
        moved = state.covered_indentation if mechanics.inextensible_cover else state.indentation
        return np.asarray(moved(r)) / state.force
    cell = max(SOURCE_CELL * layer.thickness, radius / 25.0 if family != RING else 0.0)
    radii, forces = _fine_rings(layer, mechanics, family, radius, cell)
    point = _point_indentation(layer, cast(Hashable, mechanics), cell)
    counts = 16 + np.ceil(2.0 * np.pi * radii / cell).astype(np.int64)
    return ring_sums(np.ascontiguousarray(r, dtype=np.float64), radii, forces, counts, point)


def _fine_rings(
    layer: Layer, mechanics: Mechanics, family: int, radius: float, cell: float
) -> tuple[Floats, Floats]:
    """Rings at most half a cell apart, so that squares of that size along them do not ripple."""
    inner, outer = _rim(layer, radius) if family == RING else (0.0, radius)
    count = max(int(np.ceil(2.0 * (outer - inner) / cell)), 4)
    edge = np.linspace(inner, outer, count + 1)
    middle = np.sqrt((edge[1:] ** 2 + edge[:-1] ** 2) / 2.0)
    if family == RING:
        forces = np.diff(np.square(edge))
    else:  # by parts of the smooth integral over sqrt(1 - r²/a²): the edge of a flat end counts
        root = np.sqrt(np.maximum(1.0 - np.square(edge / radius), 0.0))
        node, weight = np.polynomial.legendre.leggauss(4)
        wide = (root[:-1] - root[1:]) / 2.0
        roots = (root[:-1] + root[1:])[:, None] / 2.0 + wide[:, None] * node
        within = radius * np.sqrt(1.0 - roots**2)
        pressure = unit_pressure(layer, mechanics, family, radius, within)
        forces = wide * ((pressure * roots) @ weight)
    return middle, forces / forces.sum()


def _rim(layer: Layer, radius: float) -> tuple[float, float]:
    """Inner and outer radius of a ring of mean radius `radius`, m."""
    half = 0.5 * RIM * layer.thickness
    return max(radius - half, 0.0), radius + half


@lru_cache(maxsize=64)
def _point_indentation(layer: Layer, mechanics: Any, cell: float) -> PointResponse:
    """Displacement in m per N on a small square, whose size hides the pole, by distance in m."""
    from scipy.interpolate import CubicSpline

    h = layer.thickness
    near, far = np.linspace(0.0, h, NEAR, endpoint=False), np.linspace(h, REACH * h, FAR)
    mesh = np.concatenate([near, far])
    offsets = np.column_stack([mesh, np.zeros_like(mesh)])
    spline = CubicSpline(mesh, mechanics.indentation(layer, offsets, cell) / cell**2)
    cubics = np.ascontiguousarray(spline.c.T)
    return PointResponse(mesh, cubics, h / NEAR, (REACH - 1.0) * h / (FAR - 1), NEAR)


@lru_cache(maxsize=256)
def _indentation(layer: Layer, family: int, radius: float) -> "Indentation":
    """The contact, with a unit radius of curvature or depth."""
    from skinfield.elastic.axisymmetric import Paraboloid, indent_to_radius, punch

    if family == BALL:
        return indent_to_radius(layer, Paraboloid(radius=1.0), radius)
    return punch(layer, radius, depth=1.0)


LOG_STEP = 0.25  # of ln(a/h)
SMALLEST, LARGEST = 0.18, 7.0  # radii a fit may try, in thicknesses: smaller ones look the same
MARGIN = 3  # nodes beyond: where a B-spline feels the end of its data
DISTANCE_STEP = 0.125  # of r/h
SIGHT = 6.0  # thicknesses beyond the rims of pad and contact, where all readings are below 1e-3
CELL = 0.02  # thicknesses: side of the square that stands for a point load
SHARE = 0.25  # thicknesses between the points of a ring
STRAINS = (0.03, 0.15, 0.34, 0.56, 0.76, 0.9)  # of the gap, at its narrowest
KEPT = 48  # tables on disk
SHARP = 0.5  # thicknesses: balls that touch within less need nodes at their rim
DEGREE = 4  # of the polynomial over these


class Tables(NamedTuple):
    """Readings of round contacts, as compiled functions take them; lengths in thicknesses.

    The steps go along: what is compiled is kept on disk, and a constant would be kept with it.

    Attributes
    ----------
    coefficients : (families, radii, terms, distances) array
        Of the B-splines, in the reading's unit per newton, or per strain of the gap.
    strain : (families, radii) array, 1/N
        B-spline coefficients of ln s; empty where readings are proportional to the force.
    curvature : (radii,) array
        B-spline coefficients of ln(F R), N m, of a ball of radius of curvature R.
    shear : (families, radii, distances) array
        Of the B-splines of what a force along the skin adds ahead of it, per newton into the skin,
        ratio of the two, and distance; no distances where that is not known.
    first_log, log_step : float
        ln(a/h) of the first node, and from node to node.
    distance_step : float
        r/h from node to node.
    sight : float
        Beyond the rims of pad and contact, where all readings are 0.
    pad_radius : float
    """

    coefficients: Floats
    strain: Floats
    curvature: Floats
    shear: Floats
    first_log: float
    log_step: float
    distance_step: float
    sight: float
    pad_radius: float

    @classmethod
    def of(cls, arrays: Sequence[Floats]) -> "Tables":
        """Of arrays in the order of the attributes, those of one number without a dimension."""
        coefficients, strain, curvature, shear, *numbers = arrays
        return cls(coefficients, strain, curvature, shear, *(float(each) for each in numbers))


def log_radii(smallest: float, largest: float, step: float) -> Floats:
    """Nodes of ln(a/h), with `MARGIN` more at each end."""
    count = int(np.ceil((np.log(largest) - np.log(smallest)) / step)) + 2 * MARGIN + 1
    return np.asarray(np.log(smallest) - MARGIN * step + step * np.arange(count))


@lru_cache(maxsize=24)
def atom_tables(physics: Physics) -> Tables:
    """Tabulate, once for all taxels of a patch; of this package's physics, once per machine."""
    parts = physics.layer, physics.mechanics, physics.quantity
    if any(not type(part).__module__.startswith("skinfield.") for part in parts):
        return tabulate(physics)
    folder = cache_folder(Path(__file__))  # named after the sources that all of this is made from
    file = folder / f"{hashlib.sha256(repr(physics).encode()).hexdigest()[:16]}.npz"
    try:
        with np.load(file) as known:
            arrays = [known[name] for name in Tables._fields]
        return Tables.of(arrays)
    except (OSError, ValueError, KeyError, EOFError, BadZipFile):
        made = tabulate(physics)
    with suppress(OSError):
        with tempfile.TemporaryDirectory(dir=folder) as room:
            np.savez(f"{room}/{file.name}", **made._asdict())
            Path(room, file.name).replace(file)  # at once: other processes see all of it, or none
        for old in sorted(folder.glob("*.npz"), key=os.path.getmtime)[:-KEPT]:
            old.unlink(missing_ok=True)  # another process may be faster
    return made


def tabulate(
    physics: Physics,
    families: Sequence[int] = FAMILIES,
    bounds: tuple[float, float] = (SMALLEST, LARGEST),
) -> Tables:
    """Readings of families by radius, within bounds in thicknesses, and by distance."""
    h = physics.layer.thickness
    logs = log_radii(*bounds, LOG_STEP)
    furthest = np.exp(logs[-1]) + physics.pad_diameter / 2 / h + SIGHT
    distances = np.arange(0.0, furthest, DISTANCE_STEP)
    nonlinear = isinstance(physics.quantity, Capacitance) and physics.quantity.order != 1
    make = _nonlinear if nonlinear else _linear
    values, strain = make(physics, families, np.exp(logs) * h, distances * h)
    pushes = [_push(physics, family, a) for family in families for a in np.exp(logs)]
    shear = shear_readings(physics, pushes, distances).reshape(len(families), len(logs), -1)
    curvature = [np.log(curvature_force(physics.layer, a)) for a in np.exp(logs) * h]
    return Tables(
        coefficients=splines(values, (1, 3)),
        strain=splines(np.log(strain), (1,)) if nonlinear else strain,
        curvature=splines(np.array(curvature), (0,)),
        shear=splines(shear, (1, 2)) if shear.size else shear,
        first_log=float(logs[0]),
        log_step=LOG_STEP,
        distance_step=DISTANCE_STEP,
        sight=SIGHT,
        pad_radius=physics.pad_diameter / 2 / h,
    )


def _push(physics: Physics, family: int, radius: float) -> Traction:
    """Traction along the skin of a contact of a radius, in thicknesses; a ring holds no skin."""
    if family != RING:
        return Traction.even(radius)
    h = physics.layer.thickness
    rings, forces = load_quadrature(physics.layer, physics.mechanics, RING, radius * h)
    return Traction(rings / h, forces, 0.0)


def splines(values: Floats, axes: tuple[int, ...]) -> Floats:
    """Coefficients of cubic B-splines through values, of the same shape."""
    from scipy.ndimage import spline_filter1d

    for axis in axes:
        values = spline_filter1d(values, 3, axis=axis, mode="mirror")
    return np.ascontiguousarray(values)


def _linear(
    physics: Physics, families: Sequence[int], radii: Floats, distances: Floats
) -> tuple[Floats, Floats]:
    """Readings per newton (families, radii, 1, distances), by rings of point loads."""
    from scipy.interpolate import CubicSpline

    h = physics.layer.thickness
    mesh = np.arange(0.0, distances[-1] + radii[-1] + h, CELL * h)
    spline = CubicSpline(mesh, _point_response(physics, mesh), bc_type="clamped")
    point = PointResponse(mesh, np.ascontiguousarray(spline.c.T), CELL * h, CELL * h, 0)
    out = np.empty((len(families), len(radii), 1, len(distances)))
    for row, family in enumerate(families):
        for index, radius in enumerate(radii):
            rings, forces = load_quadrature(physics.layer, physics.mechanics, family, radius)
            counts = 8 + np.ceil(np.pi * rings / (SHARE * h)).astype(np.int64)
            out[row, index, 0] = ring_sums(distances, rings, forces, counts, point)
    return out, np.empty((0, 0))


def _point_response(physics: Physics, distances: Floats) -> Floats:
    """What the quantity's own linear map has for 1 N on a point, at some distances."""
    cell = CELL * physics.layer.thickness
    pad = Patch(np.zeros((1, 2)), pad_diameter=physics.pad_diameter)
    grid = Grid(pad, (1, 1), cell, np.zeros(2))
    taxels = np.column_stack([distances, np.zeros_like(distances)])
    matrix = physics.quantity.matrix(
        physics.mechanics, physics.layer, grid, taxels, physics.pad_diameter
    )
    return np.asarray(matrix[:, 0] / cell**2)


def _nonlinear(
    physics: Physics, families: Sequence[int], radii: Floats, distances: Floats
) -> tuple[Floats, Floats]:
    """Polynomials in the strain at the axis (families, radii, terms, distances), strain per N."""
    from skinfield.elastic.round_gap import RoundGap

    layer, h = physics.layer, physics.layer.thickness
    pad = physics.pad_diameter if getattr(physics.quantity, "pad_averaged", True) else 0.0
    depths = np.array(STRAINS)
    powers = np.vander(depths, DEGREE + 1, increasing=True)
    fit = np.linalg.pinv(powers)
    out = np.empty((len(families), len(radii), DEGREE + 1, len(distances)))
    strain = np.empty((len(families), len(radii)))
    smooth = RoundGap.of(pad / h, distances / h)

    def tabulate_one(row: int, index: int) -> None:
        family, radius, gap = families[row], radii[index], smooth
        if family != BALL or radius < SHARP * h:  # the surface is steep, or bent, at edges
            edges = np.array(_rim(layer, radius) if family == RING else (radius,))
            gap = RoundGap.of(pad / h, distances / h, edges / h)
        each = unit_indentation(layer, physics.mechanics, family, radius, gap.nodes * h) / h
        strain[row, index] = top = each.max()
        readings = gap.readings(depths[:, None] * (each / top))
        reduced = readings * ((1 - depths) / depths)[:, None]
        out[row, index] = fit @ reduced

    with ThreadPoolExecutor(processors()) as pool:  # nearly all of it runs without the lock
        list(pool.map(tabulate_one, *np.indices(strain.shape).reshape(2, -1).tolist()))
    return out, strain
