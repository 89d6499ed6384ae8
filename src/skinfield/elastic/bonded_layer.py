"""Green's functions of an elastic layer bonded to a rigid base: exact, compressible or not."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from skinfield.elastic.cell_integrals import (
    Kernel,
    integrate_over_cell,
    integrate_with_pole,
    inverse_distance_integrals,
    mean_inverse,
    mean_inverse_distance,
)
from skinfield.elastic.elastomer import Layer
from skinfield.elastic.hankel import (
    CoveredTransfer,
    LayerTransfer,
    RadialKernel,
    electrostatic,
    jinc,
)
from skinfield.errors import Floats, check_finite, check_positive, check_range, check_shape

REACH = 32.0  # thicknesses; the slowest kernel falls as exp(-0.739 r/h), to 1e-12 here
SLOW_CUTOFF = 46.0  # transforms that fall as exp(-alpha)
FAST_CUTOFF = 26.0  # transforms that fall as exp(-2 alpha)


@lru_cache(maxsize=256)
def _table(
    nu: float, covered: bool, name: str, order: int, pad: float, smooth: bool
) -> RadialKernel:
    """Table of one response; `pad` is the pad's radius in thicknesses. Built once, then kept."""
    transfer = CoveredTransfer(nu) if covered else LayerTransfer(nu)
    response = getattr(transfer, name)
    on_base = name.startswith("base")

    def transform(alpha: Floats) -> Floats:
        value = response(alpha) * jinc(alpha, pad) / (2 * np.pi)
        value = value * alpha if on_base else value
        return np.asarray(value * electrostatic(alpha) if smooth else value)

    cutoff = SLOW_CUTOFF if on_base or smooth else FAST_CUTOFF
    return RadialKernel(transform, order, cutoff, REACH + pad, pad)


@dataclass(frozen=True)
class BondedLayer:
    """Exact mechanics of a layer bonded to the robot, its top free or under a taut cover.

    Every method takes loads that are uniform over a square cell, and is exact for any thickness,
    modulus and Poisson's ratio from 0 to 0.5, the incompressible limit included. Tables depend on
    Poisson's ratio and on the pad's size in thicknesses alone; the rest is a scaling.

    Parameters
    ----------
    inextensible_cover : bool
        Whether a fabric that bends freely but does not stretch lies on the elastomer, such as a
        woven ground electrode. It then takes every tangential load.

    Notes
    -----
    Closed forms in Fourier space are in `hankel`; the half-space's part of the surface
    displacement is integrated in closed form (Love, Cerruti), and the rest, smooth, by quadrature.
    """

    inextensible_cover: bool = False

    def reach(self, layer: Layer) -> float:
        """Distance in m, from pad to cell, beyond which responses are below 1e-12 of their peak."""
        return REACH * layer.thickness

    def base_stress(
        self, layer: Layer, offset: Floats, cell: float, pad_diameter: float = 0.0
    ) -> Floats:
        """Normal stress on the base under a unit pressure on one cell.

        Parameters
        ----------
        layer : Layer
        offset : (N, 2) array, m
            From the cell's centre to the taxels.
        cell : float, m
            Side of the cell.
        pad_diameter : float, m
            Of the round pad that averages; 0 for a point.

        Returns
        -------
        (N,) array, Pa/Pa
            Positive in compression.
        """
        offset, cell, pad = _scaled(layer, offset, cell, pad_diameter)
        kernel = self._kernel(layer, "base_normal", 0, pad)
        return _integrate(lambda x, y: kernel(np.hypot(x, y)), offset, cell, pad)

    def base_traction(
        self, layer: Layer, offset: Floats, cell: float, pad_diameter: float = 0.0
    ) -> Floats:
        """Traction on the base under a unit traction on one cell, as `base_stress`.

        Returns
        -------
        (N, 3, 3) array, Pa/Pa
            [n, i, j]: component i that the layer exerts on the plane of the base (outward normal
            +z, tension positive) per component j on the surface.
        """
        offset, cell, pad = _scaled(layer, offset, cell, pad_diameter)
        normal = self._kernel(layer, "base_normal", 0, pad)
        shear_from_normal = self._kernel(layer, "base_shear_from_normal", 1, pad)
        if self.inextensible_cover:

            def covered(x: Floats, y: Floats) -> Floats:
                rho = np.hypot(x, y)
                one, zero = -shear_from_normal(rho), np.zeros(np.shape(rho))
                return _tensor([zero, zero, zero, zero, x * one, y * one, zero, zero, normal(rho)])

            return _matrix(_integrate(covered, offset, cell, pad))
        shear = self._in_plane(layer, ("base_shear", 1.0), ("base_antiplane", 1.0), pad)
        normal_from_shear = self._kernel(layer, "base_normal_from_shear", 1, pad)

        def kernel(x: Floats, y: Floats) -> Floats:
            rho = np.hypot(x, y)
            xx, xy, yy = shear(x, y, rho)
            down, up = -shear_from_normal(rho), normal_from_shear(rho)
            return _tensor([xx, xy, xy, yy, x * down, y * down, x * up, y * up, normal(rho)])

        return _matrix(_integrate(kernel, offset, cell, pad))

    def surface_displacement(self, layer: Layer, offset: Floats, cell: float) -> Floats:
        """Displacement of the surface under a unit traction on one cell.

        Parameters
        ----------
        layer, offset, cell
            See `base_stress`.

        Returns
        -------
        (N, 3, 3) array, m/Pa
            [n, i, j]: component i per component j; symmetric under exchange of source and point.
        """
        if self.inextensible_cover:
            out = np.zeros((len(offset), 3, 3))
            out[:, 2, 2] = self.indentation(layer, offset, cell)
            return out
        nu = float(layer.poisson_ratio)
        offset, cell, _ = _scaled(layer, offset, cell, 0.0)
        total = integrate_with_pole(
            self._displacement_rest(layer),
            lambda x, y: _half_space(nu, *_inverse_distances(x, y)),
            lambda place, side: _half_space(nu, *inverse_distance_integrals(place, side)),
            offset,
            cell,
            depth=1.0,
            reach=REACH,
        )
        return _matrix(total) * (layer.thickness / layer.young_modulus)

    def indentation(
        self,
        layer: Layer,
        offset: Floats,
        cell: float,
        pad_diameter: float = 0.0,
        electrostatic: bool = False,
    ) -> Floats:
        """Displacement into the skin above a pad, under a unit pressure on one cell.

        Parameters
        ----------
        layer, offset, cell, pad_diameter
            See `base_stress`.
        electrostatic : bool
            Smooth as the field lines between the electrodes do (`radial.electrostatic`).

        Returns
        -------
        (N,) array, m/Pa
        """
        nu = layer.poisson_ratio
        scale = 2 * (1 - nu**2) * layer.thickness / layer.young_modulus
        offset, cell, pad = _scaled(layer, offset, cell, pad_diameter)
        name = "normal" if electrostatic else "normal_rest"
        kernel = self._kernel(layer, name, 0, pad, smooth=electrostatic)
        smooth: Kernel = lambda x, y: kernel(np.hypot(x, y))  # noqa: E731
        if electrostatic:
            return scale * _integrate(smooth, offset, cell, pad)
        limit = CoveredTransfer(nu).half_space_factor if self.inextensible_cover else 1.0
        factor = limit / (2 * np.pi)
        total = integrate_with_pole(
            smooth,
            lambda x, y: factor * mean_inverse(np.hypot(x, y), pad),
            lambda place, side: factor * mean_inverse_distance(place, side, pad),
            offset,
            cell,
            depth=1.0,
            reach=REACH + pad,
            rim=pad,
        )
        return scale * total

    def _displacement_rest(self, layer: Layer) -> Kernel:
        """The layer's displacement less the half-space's, smooth: entries as in `_tensor`."""
        nu = layer.poisson_ratio
        along, across_k = 2 * (1 - nu**2), 2 * (1 + nu)
        shear = self._in_plane(layer, ("tangential_rest", along), ("antiplane_rest", across_k))
        normal = self._kernel(layer, "normal_rest", 0)
        coupling = self._kernel(layer, "coupling_rest", 1)

        def kernel(x: Floats, y: Floats) -> Floats:
            rho = np.hypot(x, y)
            xx, xy, yy = shear(x, y, rho)
            across = (1 + nu) * coupling(rho)
            deep = 2 * (1 - nu**2) * normal(rho)
            return _tensor([xx, xy, xy, yy, -x * across, -y * across, x * across, y * across, deep])

        return kernel

    def _kernel(
        self, layer: Layer, name: str, order: int, pad: float = 0.0, smooth: bool = False
    ) -> RadialKernel:
        nu = float(layer.poisson_ratio)
        return _table(nu, self.inextensible_cover, name, order, round(pad, 12), smooth)

    def _in_plane(
        self,
        layer: Layer,
        along: tuple[str, float],
        across: tuple[str, float],
        pad: float = 0.0,
    ) -> Callable[[Floats, Floats, Floats], tuple[Floats, Floats, Floats]]:
        """Tensor xx, xy, yy whose parts along and across k are the named, weighted responses."""
        p0, p2 = (self._kernel(layer, along[0], order, pad) for order in (0, 2))
        q0, q2 = (self._kernel(layer, across[0], order, pad) for order in (0, 2))

        def tensor(x: Floats, y: Floats, rho: Floats) -> tuple[Floats, Floats, Floats]:
            mean = (along[1] * p0(rho) + across[1] * q0(rho)) / 2
            rest = across[1] * q2(rho) - along[1] * p2(rho)
            half = (x**2 - y**2) / 2 * rest
            return mean + half, x * y * rest, mean - half

        return tensor


def _integrate(function: Kernel, offset: Floats, cell: float, pad: float) -> Floats:
    return integrate_over_cell(function, offset, cell, depth=1.0, reach=REACH + pad, rim=pad)


def _inverse_distances(x: Floats, y: Floats) -> tuple[Floats, ...]:
    """The integrands of `inverse_distance_integrals`."""
    square = x**2 + y**2
    one = 1 / np.sqrt(square)
    return (
        one,
        x**2 / square * one,
        x * y / square * one,
        y**2 / square * one,
        x / square,
        y / square,
    )


def _half_space(
    nu: float, one: Floats, xx: Floats, xy: Floats, yy: Floats, x: Floats, y: Floats
) -> Floats:
    """Displacement of the half-space's surface (Boussinesq, Cerruti), E = 1: as in `_tensor`."""
    half = (1 + nu) / np.pi
    up = half * (1 - 2 * nu) / 2
    first = [half * ((1 - nu) * one + nu * xx), half * nu * xy]
    second = [half * nu * xy, half * ((1 - nu) * one + nu * yy)]
    return _tensor([*first, *second, up * x, up * y, -up * x, -up * y, half * (1 - nu) * one])


def _scaled(
    layer: Layer, offset: Floats, cell: float, pad_diameter: float
) -> tuple[Floats, float, float]:
    """Check, and express lengths in thicknesses; the pad becomes its radius."""
    offset = np.asarray(offset, dtype=np.float64)
    check_shape("offset", offset, (None, 2), "from the cell's centre to each point, in the plane")
    check_finite("offset", offset, "a point without a place feels nothing")
    check_positive("cell", cell, "the side of the loaded square, in metres")
    check_range("pad_diameter", pad_diameter, 0.0, 1.0, "0 is a point; give it in metres")
    h = layer.thickness
    return offset / h, cell / h, pad_diameter / 2 / h


def _tensor(entries: list[Floats]) -> Floats:
    """Stack the entries 00, 01, 10, 11, 02, 12, 20, 21, 22 of a tensor kernel."""
    return np.stack(np.broadcast_arrays(*entries))


def _matrix(entries: Floats) -> Floats:
    """(9, N) entries in the order of `_tensor`, as matrices (N, 3, 3)."""
    xx, xy, yx, yy, xz, yz, zx, zy, zz = entries
    return np.stack([xx, xy, xz, yx, yy, yz, zx, zy, zz], axis=-1).reshape(-1, 3, 3)
