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
    inverse_distances,
    matrices,
    mean_direction,
    mean_direction_integral,
    mean_inverse,
    mean_inverse_distance,
    surface_tensor,
    tensor,
)
from skinfield.elastic.elastomer import Layer, in_thicknesses
from skinfield.elastic.hankel import (
    CoveredTransfer,
    LayerTransfer,
    RadialKernel,
    electrostatic,
    jinc,
)
from skinfield.errors import Floats

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
        """See `Mechanics.base_stress`."""
        offset, cell, pad = in_thicknesses(layer, offset, cell, pad_diameter)
        kernel = self._kernel(layer, "base_normal", 0, pad)
        return _integrate(lambda x, y: kernel(np.hypot(x, y)), offset, cell, pad)

    def base_traction(
        self, layer: Layer, offset: Floats, cell: float, pad_diameter: float = 0.0
    ) -> Floats:
        """See `Mechanics.base_traction`."""
        offset, cell, pad = in_thicknesses(layer, offset, cell, pad_diameter)
        normal = self._kernel(layer, "base_normal", 0, pad)
        shear_from_normal = self._kernel(layer, "base_shear_from_normal", 1, pad)
        if self.inextensible_cover:

            def covered(x: Floats, y: Floats) -> Floats:
                rho = np.hypot(x, y)
                one, zero = -shear_from_normal(rho), np.zeros(np.shape(rho))
                return tensor([zero, zero, zero, zero, x * one, y * one, zero, zero, normal(rho)])

            return matrices(_integrate(covered, offset, cell, pad))
        shear = self._in_plane(layer, ("base_shear", 1.0), ("base_antiplane", 1.0), pad)
        normal_from_shear = self._kernel(layer, "base_normal_from_shear", 1, pad)

        def kernel(x: Floats, y: Floats) -> Floats:
            rho = np.hypot(x, y)
            xx, xy, yy = shear(x, y, rho)
            down, up = -shear_from_normal(rho), normal_from_shear(rho)
            return tensor([xx, xy, xy, yy, x * down, y * down, x * up, y * up, normal(rho)])

        return matrices(_integrate(kernel, offset, cell, pad))

    def surface_displacement(self, layer: Layer, offset: Floats, cell: float) -> Floats:
        """See `Mechanics.surface_displacement`; symmetric if source and point change places."""
        if self.inextensible_cover:
            out = np.zeros((len(offset), 3, 3))
            out[:, 2, 2] = self.indentation(layer, offset, cell)
            return out
        nu = float(layer.poisson_ratio)
        offset, cell, _ = in_thicknesses(layer, offset, cell, 0.0)
        total = integrate_with_pole(
            self._displacement_rest(layer),
            lambda x, y: surface_tensor(nu, inverse_distances(x, y)),
            lambda place, side: surface_tensor(nu, inverse_distance_integrals(place, side)),
            offset,
            cell,
            depth=1.0,
            reach=REACH,
        )
        return matrices(total) * (layer.thickness / layer.young_modulus)

    def indentation(
        self,
        layer: Layer,
        offset: Floats,
        cell: float,
        pad_diameter: float = 0.0,
        electrostatic: bool = False,
    ) -> Floats:
        """See `Mechanics.indentation`."""
        nu = layer.poisson_ratio
        scale = 2 * (1 - nu**2) * layer.thickness / layer.young_modulus
        offset, cell, pad = in_thicknesses(layer, offset, cell, pad_diameter)
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

    def lift(
        self,
        layer: Layer,
        offset: Floats,
        cell: float,
        pad_diameter: float = 0.0,
        electrostatic: bool = False,
    ) -> Floats:
        """See `Mechanics.lift` and, for `electrostatic`, `Mechanics.indentation`.

        It is 0 under a cover, which takes every tangential load.
        """
        if self.inextensible_cover:
            return np.zeros((len(offset), 2))
        nu = layer.poisson_ratio
        scale = (1 + nu) * layer.thickness / layer.young_modulus
        offset, cell, pad = in_thicknesses(layer, offset, cell, pad_diameter)
        kernel = self._kernel(
            layer, "coupling" if electrostatic else "coupling_rest", 1, pad, smooth=electrostatic
        )
        smooth: Kernel = lambda x, y: np.stack([x, y]) * kernel(np.hypot(x, y))  # noqa: E731
        if electrostatic or nu == 0.5:
            return scale * _integrate(smooth, offset, cell, pad).T
        factor = -(1 - 2 * nu) / (2 * np.pi)
        total = integrate_with_pole(
            smooth,
            lambda x, y: factor * mean_direction(x, y, pad),
            lambda place, side: factor * mean_direction_integral(place, side, pad),
            offset,
            cell,
            depth=1.0,
            reach=REACH + pad,
            rim=pad,
        )
        return scale * total.T

    def _displacement_rest(self, layer: Layer) -> Kernel:
        """The layer's displacement less the half-space's, smooth: entries as in `tensor`."""
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
            return tensor([xx, xy, xy, yy, -x * across, -y * across, x * across, y * across, deep])

        return kernel

    def _kernel(
        self, layer: Layer, name: str, order: int, pad: float = 0.0, smooth: bool = False
    ) -> RadialKernel:
        nu = float(layer.poisson_ratio)
        return _table(nu, self.inextensible_cover, name, order, pad, smooth)

    def _in_plane(
        self, layer: Layer, along: tuple[str, float], across: tuple[str, float], pad: float = 0.0
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
