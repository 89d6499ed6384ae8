r"""Cramér-Rao bound: how well any unbiased estimator can tell place and force of contacts.

With readings y(θ) + noise, independent from taxel to taxel with standard deviation σ, and
θ = (x, y, ln F[, ln size]), the covariance of every unbiased estimator is at least

.. math:: \Big(J^T \mathrm{diag}(\sigma^{-2})\, J + P\Big)^{-1}, \quad
          J = \partial y/\partial\theta,

where P is the prior's information on the size, if that is not known (Cramér 1946, Rao 1945; with
a prior: Van Trees 1968, section 2.4).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from skinfield.elastic import Layer
from skinfield.errors import Floats, InputError, as_floats, check_positive
from skinfield.lab.score import Row
from skinfield.simulate import Press, press
from skinfield.simulate.pressing.press import readings_anywhere

Readings = Callable[[Floats], Floats]
SHIFT = 0.1e-3  # m: of the taxels, each way, in the central differences
FORCE_STEP = 0.05  # of the force, each way
SIZE_STEP = 0.05  # of the size, each way


@dataclass(frozen=True)
class Bound:
    """Smallest standard deviations of unbiased estimates of one contact.

    Attributes
    ----------
    place : float, m
        Root of the sum of the variances along x and y; infinite where the readings cannot tell.
    force : float
        Part of the force.
    covariance : (P, P) array
        Of x m, y m, ln F, and ln size if that is unknown; empty where it is infinite.
    """

    place: float
    force: float
    covariance: Floats


@dataclass(frozen=True, eq=False, kw_only=True)
class Family:
    """A press at the origin and its neighbours in load and size, as readings anywhere.

    Parameters
    ----------
    base, lighter, heavier : function of (N, 2) m
        Readings (N,) of taxels around the press; with its force, and with `force_step` of it less
        and more.
    force_step : float
    smaller, larger : function of (N, 2) m, optional
        With the size times exp(-size_step) and exp(size_step), where that is not known.
    size_step : float
    shift : float, m
        Of the taxels in the central differences.
    """

    base: Readings
    lighter: Readings
    heavier: Readings
    force_step: float = FORCE_STEP
    smaller: Readings | None = None
    larger: Readings | None = None
    size_step: float = SIZE_STEP
    shift: float = SHIFT

    def jacobian(self, taxels: Floats) -> Floats:
        """Derivatives (L, 3 or 4) of readings of taxels (L, 2) m that see the press at the origin.

        By x m and y m of the press, ln F, and ln size. A press moved one way reads as taxels moved
        the other way.
        """
        moved = [taxels - self.shift * np.array(way) for way in ((1, 0), (-1, 0), (0, 1), (0, -1))]
        right, left, up, down = np.split(self.base(np.concatenate(moved)), 4)
        log_step = np.log1p(self.force_step) - np.log1p(-self.force_step)
        columns = [
            (right - left) / (2 * self.shift),
            (up - down) / (2 * self.shift),
            (self.heavier(taxels) - self.lighter(taxels)) / log_step,
        ]
        if self.larger is not None and self.smaller is not None:
            columns.append((self.larger(taxels) - self.smaller(taxels)) / (2 * self.size_step))
        return np.stack(columns, axis=1)


def bound_of(
    jacobian: Floats, noise_std: ArrayLike, size_prior: float | None = None, sizes_from: int = 3
) -> Bound:
    """Bound from derivatives (L, P) by x m, y m, ln F and possibly ln size.

    Several contacts have x, y, ln F of each, then the sizes; `place` and `force` are of the first.

    Parameters
    ----------
    jacobian : (L, P) array
    noise_std : float or (L,) array, in the readings' unit
    size_prior : float, optional
        Standard deviation of ln size before any reading; none where all that is known of the size
        is in the readings.
    """
    noise = as_floats("noise_std", noise_std)
    check_positive("noise_std", float(noise.min()), "no reading is exact")
    white = jacobian / (noise[:, None] if noise.ndim else noise)
    information = white.T @ white
    if size_prior is not None:
        check_positive("size_prior", size_prior, "standard deviation of ln size")
        sizes = np.arange(sizes_from, len(information))
        information[sizes, sizes] += size_prior**-2
    scale = np.sqrt(np.diag(information))
    if not (scale > 0).all():
        return Bound(np.inf, np.inf, np.empty((0, 0)))
    correlation = information / np.outer(scale, scale)
    if np.linalg.eigvalsh(correlation)[0] < 1e-12:  # some change of the contact moves no reading
        return Bound(np.inf, np.inf, np.empty((0, 0)))
    covariance = np.linalg.inv(correlation) / np.outer(scale, scale)
    spread = np.sqrt(np.diag(covariance))
    return Bound(float(np.hypot(*spread[:2])), float(spread[2]), covariance)


def contact_family(
    layer: Layer,
    indenter: Any,
    quantity: str,
    pad_diameter: float,
    *,
    extent: float,
    cell: float = 0.25e-3,
    size: str | None = None,
) -> Family:
    """Simulate a press and its neighbours, once for all places.

    Parameters
    ----------
    layer : Layer
    indenter : Indenter
        At the origin, with a force.
    quantity : "capacitance", "gap" or "stress"
    pad_diameter : float, m
    extent, cell : float, m
        See `skinfield.simulate.pressing.press`.
    size : str, optional
        The indenter's field, such as "radius", that the estimator does not know.
    """
    if indenter.force is None:
        raise InputError("indenter has a depth, expected a force: its bound is asked for")

    def readings(body: Any) -> Readings:
        return readings_anywhere(_pressed(layer, body, extent, cell), pad_diameter, quantity)

    def sized(step: float) -> Readings | None:
        if size is None:
            return None
        return readings(replace(indenter, **{size: getattr(indenter, size) * np.exp(step)}))

    return Family(
        base=readings(indenter),
        lighter=readings(replace(indenter, force=indenter.force * (1 - FORCE_STEP))),
        heavier=readings(replace(indenter, force=indenter.force * (1 + FORCE_STEP))),
        smaller=sized(-SIZE_STEP),
        larger=sized(SIZE_STEP),
    )


@lru_cache(maxsize=16)
def _pressed(layer: Layer, body: Any, extent: float, cell: float) -> Press:
    """Solved once for all quantities."""
    return press(layer, [body], extent=extent, cell=cell)


def contact_bounds(
    family: Family,
    taxels: Floats,
    places: Floats,
    noise_std: ArrayLike,
    size_prior: float | None = None,
) -> list[Bound]:
    """Bound of a press at each of some places.

    Parameters
    ----------
    family : Family
    taxels : (L, 2) array, m
        In the patch's plane.
    places : (P, 2) array, m
    noise_std : float or (L,) array, in the quantity's unit
    size_prior : float, optional
        See `bound_of`.
    """
    return [
        bound_of(family.jacobian(taxels - place), noise_std, size_prior)
        for place in np.atleast_2d(places)
    ]


def errors_at_bound(
    jacobians: Sequence[Floats],
    forces: Floats,
    noise_std: ArrayLike,
    size_prior: float | None,
    white: Floats,
) -> list[Row]:
    """Errors of an estimate at the bound of several contacts, which act each by itself.

    They are Gaussian with the bound's covariance: what an unbiased and efficient estimator of
    place and force would score. None where the readings cannot tell a parameter at all.

    Parameters
    ----------
    jacobians : sequence of (L, 4) arrays
        Of each contact, by x m, y m, ln F and ln size.
    forces : (C,) array, N
    noise_std : float or (L,) array
    size_prior : float, optional
        See `bound_of`; without it the sizes are known.
    white : (draws, 3 C) array
        Standard normal numbers: the same for two bounds, their errors differ as the bounds do.
    """
    count = len(forces)
    parts = [each[:, :3] for each in jacobians]
    if size_prior is not None:
        parts += [each[:, 3:] for each in jacobians]
    covariance = bound_of(
        np.concatenate(parts, axis=1), noise_std, size_prior, 3 * count
    ).covariance
    if not len(covariance):
        return []
    own = covariance[: 3 * count, : 3 * count]
    drawn = (white @ np.linalg.cholesky(own).T).reshape(len(white), count, 3)
    place = np.hypot(drawn[..., 0], drawn[..., 1]).mean(axis=1)
    total = np.abs(drawn[..., 2] @ forces) / forces.sum()
    single = np.abs(drawn[..., 2]).mean(axis=1)
    return [
        {"place_error_mm": 1e3 * float(p), "force_error": float(t), "contact_force_error": float(s)}
        for p, t, s in zip(place, total, single, strict=True)
    ]
