r"""The Cramér-Rao bound of presses by one or several balls, interpolated between solved ones.

Balls are solved on a grid of radii and depths. In between, readings per newton and the force are
splines in the logarithms of both, whose derivatives give those by the force at a known radius, and
by the radius at a known force. Several balls are taken to act each by itself: they are 10 mm or
more apart, five thicknesses, and the joint information of all their parameters is inverted.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.experiments.cases.unseen import BALLS
from skinfield.experiments.scoring.bound import bound_of
from skinfield.experiments.scoring.rows import Row
from skinfield.experiments.trust.plan import Level, TrustPlan
from skinfield.simulate import Sphere, press

DEPTHS = (0.05, 0.75)  # thicknesses
FAR = 24e-3  # m: beyond, a ball is not felt
SPACING = 0.2e-3  # m
SIZE_PRIOR = 0.6  # standard deviation of ln radius where the size is not known
DRAWS = 64  # of errors at the bound, per case
KNOWN, UNKNOWN = "bound, size known", "bound, size unknown"


def _distances() -> Floats:
    return np.arange(0.0, FAR + SPACING / 2, SPACING)


def ball_profiles(plan: TrustPlan, radius: float) -> dict[str, Any]:
    """Readings over the distance from a ball of a radius in m, at each depth of the grid."""
    h, pad = plan.layer.thickness, plan.patch.pad_diameter
    depths = np.geomspace(*DEPTHS, plan.bound_grid[1]) * h
    line = np.column_stack([_distances(), np.zeros_like(_distances())])
    profiles: dict[str, list[list[float]]] = {quantity: [] for quantity in plan.quantities}
    forces = []
    for depth in depths:
        wide = 2.2 * np.sqrt(2 * radius * depth) + 4 * plan.cell
        body = Sphere(radius=radius, depth=float(depth))
        solved = press(plan.layer, [body], 2 * float(wide), plan.cell)
        forces.append(solved.force)
        for quantity, kept in profiles.items():
            kept.append((solved.readings(line, pad, quantity) / solved.force).tolist())
    return {"radius": radius, "depths": depths.tolist(), "forces": forces, "profiles": profiles}


def radii(plan: TrustPlan) -> list[float]:
    """Of the balls that are solved, m."""
    return (
        np.geomspace(BALLS[0], BALLS[1], plan.bound_grid[0]).tolist() if plan.bound_grid[0] else []
    )


@dataclass(frozen=True, eq=False)
class BallTable:
    """Readings of any ball, from those of some.

    Parameters
    ----------
    parts : sequence of dict
        Of `ball_profiles`, by rising radius.
    quantity : str
    """

    parts: Sequence[dict[str, Any]]
    quantity: str

    @cached_property
    def _axes(self) -> tuple[Floats, Floats]:
        radius = np.log([part["radius"] for part in self.parts])
        return radius, np.log(self.parts[0]["depths"])

    @cached_property
    def _force(self) -> Any:
        from scipy.interpolate import RectBivariateSpline

        forces = np.log([part["forces"] for part in self.parts])
        degrees = [min(3, count - 1) for count in forces.shape]
        return RectBivariateSpline(*self._axes, forces, kx=degrees[0], ky=degrees[1])

    @cached_property
    def _profiles(self) -> Any:
        """Spline in ln radius of splines in ln depth, of readings per newton at all distances."""
        from scipy.interpolate import CubicSpline

        values = np.array([part["profiles"][self.quantity] for part in self.parts])
        return CubicSpline(self._axes[0], values, axis=0)

    def _depth(self, radius: float, force: float) -> float:
        """Logarithm of the depth."""
        from scipy.optimize import brentq

        low, high = self._axes[1][[0, -1]]

        def excess(depth: float) -> float:
            return float(self._force.ev(radius, depth)) - float(np.log(force))

        if excess(low) > 0.0 or excess(high) < 0.0:
            raise InputError(
                f"a ball of {np.exp(radius) * 1e3:.1f} mm with {force:.2f} N is not between those "
                "that are solved, expected a depth of 0.05 to 0.75 thicknesses"
            )
        return float(brentq(excess, low, high, xtol=1e-10))

    def jacobian(self, taxels: Floats, place: Floats, radius: float, force: float) -> Floats:
        """Derivatives (L, 4) of readings at (L, 2) m by x m, y m, ln force and ln radius."""
        from scipy.interpolate import CubicSpline

        size, deep = float(np.log(radius)), self._depth(float(np.log(radius)), force)
        at = CubicSpline(self._axes[1], self._profiles(size), axis=0)
        wider = CubicSpline(self._axes[1], self._profiles(size, 1), axis=0)
        per_newton, by_depth, by_size = at(deep), at(deep, 1), wider(deep)
        stiff = float(self._force.ev(size, deep, dy=1))  # d ln F by d ln depth
        grows = float(self._force.ev(size, deep, dx=1))  # d ln F by d ln radius
        apart = taxels - place
        away = np.hypot(apart[:, 0], apart[:, 1])
        towards = -apart / np.maximum(away, 1e-9)[:, None]  # the way a press moves, taxels recede
        spline = CubicSpline(_distances(), per_newton, bc_type="clamped")
        within = away < FAR
        slope = np.where(within, spline(np.minimum(away, FAR), 1), 0.0)

        def of(values: Floats) -> Floats:
            spline = CubicSpline(_distances(), values, bc_type="clamped")
            return np.where(within, spline(np.minimum(away, FAR)), 0.0)

        return force * np.column_stack(
            [
                slope * towards[:, 0],
                slope * towards[:, 1],
                of(per_newton + by_depth / stiff),  # of force times readings per newton
                of(by_size - by_depth * grows / stiff),
            ]
        )


def bound_rows(
    plan: TrustPlan,
    parts: Sequence[dict[str, Any]],
    balls: Sequence[dict[str, Any]],
    draws: int = DRAWS,
) -> list[Row]:
    """Errors of an estimate at the bound, `draws` for each press of balls and noise above 0.

    They are Gaussian with the bound's covariance: what an unbiased and efficient estimator of
    place and force would score. Rows are as those of `attempts.rows_of_case`, with fewer columns.
    """
    grouped: dict[str, list[dict[str, Any]]] = {}
    for ball in balls:
        grouped.setdefault(ball["case"], []).append(ball)
    tables = {quantity: BallTable(parts, quantity) for quantity in plan.quantities}
    rng, rows = np.random.default_rng(plan.seed), []
    for case, each in grouped.items():
        for quantity, table in tables.items():
            joint = _joint(table, plan.patch.plane, each)
            for level in plan.levels:
                if level.quantity != quantity or level.noise == 0.0:
                    continue
                for name, prior in ((KNOWN, None), (UNKNOWN, SIZE_PRIOR)):
                    errors = _errors(joint, each, level, prior, rng, draws)
                    head = {"case": case, "quantity": quantity, "noise": level.noise}
                    rows += [head | {"method": name} | row for row in errors]
    return rows


def _joint(table: BallTable, plane: Floats, balls: Sequence[dict[str, Any]]) -> Floats:
    """Derivatives (L, 4 C) by x, y, ln force of each ball, then by ln radius of each."""
    each = [
        table.jacobian(plane, np.array([b["x"], b["y"]]), b["radius"], b["force"]) for b in balls
    ]
    return np.concatenate([part[:, :3] for part in each] + [part[:, 3:] for part in each], axis=1)


def _errors(
    joint: Floats,
    balls: Sequence[dict[str, Any]],
    level: Level,
    prior: float | None,
    rng: np.random.Generator,
    draws: int,
) -> list[Row]:
    """Rows of errors; none where the readings cannot tell a parameter at all."""
    count = len(balls)
    used = joint if prior is not None else joint[:, : 3 * count]
    covariance = bound_of(used, level.noise, prior, 3 * count).covariance
    if not len(covariance):
        return []
    own = covariance[: 3 * count, : 3 * count]
    found = rng.multivariate_normal(np.zeros(3 * count), own, draws).reshape(draws, count, 3)
    place = np.hypot(found[..., 0], found[..., 1]).mean(axis=1)
    force = np.array([ball["force"] for ball in balls])
    total = np.abs(found[..., 2] @ force) / force.sum()
    single = np.abs(found[..., 2]).mean(axis=1)
    return [
        {"place_error_m": float(p), "force_error": float(t), "contact_force_error": float(s)}
        for p, t, s in zip(place, total, single, strict=True)
    ]
