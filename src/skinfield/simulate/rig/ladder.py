"""One indenter pressed harder and harder, as tables over the force."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints
from skinfield.simulate.indenters import Indenter
from skinfield.simulate.pressing.ladder import press_ladder
from skinfield.simulate.pressing.press import Press, press
from skinfield.simulate.rig.places import Pose
from skinfield.simulate.rig.scenario import Scenario

FINE = 4001  # forces at which depths are inverted


@dataclass(frozen=True, eq=False)
class Ladder:
    """Readings, depth and area over the force, from none to the highest.

    Between the rungs a monotone cubic in √force (PCHIP): there readings are nearly straight lines.

    Attributes
    ----------
    force : (N,) array, N
        From 0 up.
    depth : (N,) array, m
    area : (N,) array, m²
    change : (N, poses, L) array
        ΔC/C₀ of the taxels.
    loads : tuple of Press
        At the scenario's loads, in their order.
    """

    force: Floats
    depth: Floats
    area: Floats
    change: Floats
    loads: tuple[Press, ...]

    def depth_at(self, force: Floats) -> Floats:
        """Of the lowest point, m."""
        return self._between(self.depth, force)

    def area_at(self, force: Floats) -> Floats:
        """Of contact, m²."""
        return self._between(self.area, force)

    def force_at(self, depth: Floats) -> Floats:
        """Elastic force at depths of the lowest point, N: the inverse of `depth_at`."""
        force = self.force[-1] * np.linspace(0.0, 1.0, FINE) ** 2
        root = np.interp(depth, self.depth_at(force), np.sqrt(force))
        return np.asarray(root**2)

    def change_at(self, pose: int, force: Floats, skew: Ints) -> Floats:
        """ΔC/C₀ (T, L) at one pose, under forces (T, S) at the moments of each distinct skew.

        Parameters
        ----------
        pose : int
        force : (T, S) array, N
        skew : (L,) int array
            Column of `force` that counts for each taxel.
        """
        out = np.empty((len(force), self.change.shape[2]))
        for column in range(force.shape[1]):
            taxels = skew == column
            out[:, taxels] = self._between(self.change[:, pose, taxels], force[:, column])
        return out

    def _between(self, values: Floats, force: Floats) -> Floats:
        from scipy.interpolate import PchipInterpolator

        held = np.sqrt(np.clip(force, 0.0, self.force[-1]))
        return np.asarray(PchipInterpolator(np.sqrt(self.force), values)(held))


def solve_ladder(scenario: Scenario, indenter: Indenter, poses: Sequence[Pose]) -> Ladder:
    """Press an indenter of the scenario up to its highest load."""
    loads = _loads(scenario, indenter)
    highest = max(found.force for found in loads)
    rungs = _solve(scenario, indenter, _steps(loads, highest, scenario.solving.rungs))
    every = sorted([*loads, *rungs], key=lambda found: found.force)
    kept = [every[0]]
    kept += [b for a, b in pairwise(every) if b.force > a.force * 1.0001]
    plane = scenario.patch.plane
    seen = np.concatenate([pose.taxels(plane) for pose in poses])
    change = [found.capacitance(seen, scenario.patch.pad_diameter) for found in kept]
    none = np.zeros(1)
    return Ladder(
        np.concatenate([none, [found.force for found in kept]]),
        np.concatenate([none, [float(found.approach[0]) for found in kept]]),
        np.concatenate([none, [found.contact_area for found in kept]]),
        np.stack([np.zeros(len(seen)), *change]).reshape(len(kept) + 1, len(poses), len(plane)),
        tuple(loads),
    )


def press_with(scenario: Scenario, indenter: Indenter, force: float) -> Press:
    """One press at the origin."""
    return _solve(scenario, indenter, np.array([force]))[0]


def _loads(scenario: Scenario, indenter: Indenter) -> list[Press]:
    """Presses at the loads, by force or depth."""
    if scenario.loads.forces:
        return _solve(scenario, indenter, np.array(scenario.loads.forces))
    body: Any = indenter
    solving = scenario.solving
    return [
        press(
            scenario.layer,
            [replace(body, force=None, depth=depth)],
            solving.extent,
            solving.cell,
            scenario.mechanics,
        )
        for depth in scenario.loads.depths
    ]


def _solve(scenario: Scenario, indenter: Indenter, forces: Floats) -> list[Press]:
    solving = scenario.solving
    return press_ladder(
        scenario.layer,
        indenter,
        forces.tolist(),
        solving.extent,
        solving.cell,
        scenario.mechanics,
    )


def _steps(loads: Sequence[Press], highest: float, count: int) -> Floats:
    """Even steps of √force, without those that a load stands near to."""
    steps = np.sqrt(highest) * np.arange(1, count) / count
    taken = np.sqrt([found.force for found in loads])
    distance = np.abs(steps[:, None] - taken).min(axis=1)
    kept: NDArray[np.bool_] = distance > 0.25 * steps[0]
    return np.asarray(steps[kept] ** 2)
