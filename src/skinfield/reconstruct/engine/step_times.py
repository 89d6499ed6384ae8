"""Times of an engine's steps, measured before the first reading; and a rehearsed touch."""

from collections.abc import Callable
from functools import partial

import numpy as np

from skinfield.errors import Floats
from skinfield.reconstruct.engine.patch_kinds import PatchGroup
from skinfield.reconstruct.engine.state import MASKED, PRODUCT, ROW, TEST
from skinfield.reconstruct.engine.timing_model import NS
from skinfield.reconstruct.engine.workspace import Clockwork

LAPS = 9  # of each step; the first one, which loads what is compiled, does not count
RADIUS = 1.0  # of a rehearsed touch, pitches of the taxels
STRONG = 20.0  # standard deviations of the noise that it reads


def measure(work: Clockwork) -> None:
    """Start the cost model from laps of every step that must fit."""
    work.intake.white[:] = 0.0
    for rung in range(work.rungs):
        if not work.linear:
            _lap(work, work.groups[0], TEST, rung, partial(work.test_idle, rung))
        if work.atlases:
            _lap(work, work.groups[0], PRODUCT, rung, partial(work.answer_all, rung))
        for group in work.groups:
            white = work.white[group.index]
            if not work.atlases:
                _lap(work, group, PRODUCT, rung, partial(group.answer_all, rung, white))
            _lap(work, group, ROW, rung, partial(group.answer_one, rung, 0, white))
            if work.tests:
                _lap(work, group, MASKED, rung, partial(work.is_idle, group.first, rung))


def rehearsed_cycle(work: Clockwork) -> dict[str, Floats]:
    """Readings of a touch on the first patch of each kind, by the names of patches."""
    rng, names = np.random.default_rng(1), work.intake.names
    readings = {}
    for group in work.groups:
        for place in range(group.count):
            touch = np.zeros(len(group.kind.noise_std))
            if place == 0 and not work.linear:
                touch = rehearsed(group, work.rungs - 1, rng)
            readings[names[group.first + place]] = touch
    return readings


def _lap(
    work: Clockwork, group: PatchGroup, step: int, rung: int, action: Callable[[], object]
) -> None:
    laps = []
    for _ in range(LAPS + 1):
        start = work.clock()
        action()
        laps.append((work.clock() - start) * NS)
    work.times.model.start(work.times.which(step, group.index, rung), np.array(laps[1:]))


def rehearsed(group: PatchGroup, rung: int, rng: "np.random.Generator") -> Floats:
    """Readings (L,) of a round touch at a random taxel, without noise."""
    step = group.rungs.steps[rung]
    model = step.operator.model
    centre = model.taxels[rng.integers(len(model.taxels))]
    distance = np.linalg.norm(step.grid.plane - centre, axis=1)
    reach = max(RADIUS * step.grid.patch.pitch, 0.75 * step.grid.pitch)
    readings = model.matrix @ (distance <= reach).astype(np.float64)
    highest = float(np.abs(readings / model.noise_std).max())
    return np.asarray(readings * (STRONG / max(highest, 1e-300)))
