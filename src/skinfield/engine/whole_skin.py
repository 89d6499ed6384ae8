"""Maps from the readings of all patches, one for each rung."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.engine.atlas import Atlas
from skinfield.engine.group import Group
from skinfield.engine.products import Singles
from skinfield.engine.searching import idle_test_of
from skinfield.engine.stamped_product import CUT, PROOF
from skinfield.inverse.stamps import SIDE, Stamps


def idle_tests(groups: Sequence[Group]) -> list[Atlas]:
    """Tests of all patches on each rung; none where the answers are linear."""
    counts, tests = [group.count for group in groups], []
    for rung in range(len(groups[0].searches)):
        stamps, thresholds = [], []
        for group in groups:
            operator = group.rungs.steps[rung].operator
            assert operator is not None  # a group has searches of such alone
            matrix = idle_test_of(group.searches[rung][0], len(group.kind.noise_std))
            stamps.append(_stamps(matrix, group.rungs.steps[rung].grid.shape, PROOF))
            thresholds.append(group.thresholds[rung])
        tests.append(Atlas.of(stamps, counts, thresholds))
    return tests


def linear_answers(groups: Sequence[Group]) -> list[tuple[Atlas, Singles]]:
    """Linear answers of all patches on each rung, and where they are written: `Group.fields`.

    None where a grid is too coarse for tiles.
    """
    counts, answers = [group.count for group in groups], []
    for rung, step in enumerate(groups[0].rungs.steps):
        if min(step.grid.shape) < SIDE:
            return []
        stamps = [
            _stamps(
                group.rungs.steps[rung].matrix * group.kind.noise_std,
                group.rungs.steps[rung].grid.shape,
                CUT,
            )
            for group in groups
        ]
        field: Singles = np.zeros(sum(group.fields[rung].size for group in groups), np.float32)
        at = 0
        for group in groups:
            size = group.fields[rung].size
            group.fields[rung] = field[at : at + size].reshape(group.count, -1)
            at += size
        answers.append((Atlas.of(stamps, counts), field))
    return answers


def _stamps(matrix: NDArray[Any], shape: tuple[int, int], cut: float) -> Stamps:
    """Stamps of a matrix (K, L); a grid that is too small for tiles is filled up with zeros."""
    if min(shape) < SIDE:
        rows = max(len(matrix), SIDE**2)
        shape = (SIDE, -(-rows // SIDE))
        missing = shape[0] * shape[1] - len(matrix)
        matrix = np.concatenate([matrix, np.zeros((missing, matrix.shape[1]))])
    return Stamps.of_cells(matrix, shape, cut)
