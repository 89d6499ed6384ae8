"""Products of all kinds of patches in one call: against each kind's own matrix."""

import numpy as np
import pytest

from skinfield.errors import Floats
from skinfield.reconstruct.engine.block_sparse import SCORES, Atlas
from skinfield.reconstruct.engine.block_sparse_kernel import idle_patches
from skinfield.skin import Grid
from skinfield.solve import tiles_kernel
from skinfield.solve.tiles import Tiles
from skinfield.testing.solver import square_patch

KINDS = [((8, 8), 5, 1), ((12, 20), 9, 13), ((5, 6), 3, 4), ((4, 4), 1, 6)]  # shape, taxels, count


def kinds(cut: float) -> tuple[list[Floats], list[Tiles], list[int]]:
    rng = np.random.default_rng(0)
    matrices, stamps = [], []
    for shape, taxels, _ in KINDS:
        grid = Grid(square_patch(side=3), shape, 1e-3, np.zeros(2))
        matrix = rng.normal(size=(len(grid), taxels)) ** 5
        matrices.append(matrix / np.linalg.norm(matrix, axis=1, keepdims=True))
        stamps.append(Tiles.of(matrices[-1], grid, cut))
    return matrices, stamps, [count for _, _, count in KINDS]


def parts(array: Floats, sizes: list[int], counts: list[int]) -> list[Floats]:
    out, at = [], 0
    for size, count in zip(sizes, counts, strict=True):
        out.append(array[at : at + size * count].reshape(count, size))
        at += size * count
    assert at == len(array)
    return out


@pytest.mark.parametrize("cut", [0.0, 0.1])
def test_products_are_those_of_each_kind(cut: float) -> None:
    matrices, stamps, counts = kinds(cut)
    atlas = Atlas.of(stamps, counts)
    taxels, cells = ([m.shape[axis] for m in matrices] for axis in (1, 0))
    readings = np.random.default_rng(1).normal(size=np.dot(taxels, counts)).astype(np.float32)
    out = np.full(np.dot(cells, counts), np.nan, np.float32)
    atlas.apply(readings, out)
    assert atlas.values.ctypes.data % 64 == 0
    for stamp, given, found in zip(
        stamps, parts(readings, taxels, counts), parts(out, cells, counts), strict=True
    ):
        np.testing.assert_allclose(found, given @ stamp.dense().T, atol=1e-5)


@pytest.mark.parametrize("cut", [0.0, 0.05])
def test_idle_patches_are_idle_by_the_whole_matrices(cut: float) -> None:
    matrices, stamps, counts = kinds(cut)
    thresholds = [1.6, 2.4, 1.3, 0.5]
    atlas = Atlas.of(stamps, counts, thresholds)
    taxels = [matrix.shape[1] for matrix in matrices]
    rng, idle = np.random.default_rng(2), np.zeros(sum(counts), np.bool_)
    agreed = proven = 0
    for _ in range(200):
        readings = rng.normal(size=np.dot(taxels, counts)).astype(np.float32)
        idle[:] = rng.random(len(idle)) < 0.5
        idle_patches(*atlas.arrays[:7], readings, atlas.scores, idle)
        highest = [
            (given @ matrix.T).max(axis=1) <= threshold
            for given, matrix, threshold in zip(
                parts(readings, taxels, counts), matrices, thresholds, strict=True
            )
        ]
        truly = np.concatenate(highest)
        assert (truly | ~idle).all()  # never idle where the whole matrix says otherwise
        agreed, proven = agreed + (idle & truly).sum(), proven + truly.sum()
    assert 0.2 < proven / (200 * len(idle)) < 0.8
    assert agreed == proven if cut == 0.0 else 0.5 * proven < agreed < proven


def test_what_is_no_number_is_not_idle() -> None:
    matrices, stamps, counts = kinds(0.0)
    atlas = Atlas.of(stamps, counts, [5.0] * 4)
    readings = np.zeros(sum(m.shape[1] * n for m, n in zip(matrices, counts, strict=True)))
    readings[0] = np.nan
    idle = np.zeros(sum(counts), np.bool_)
    idle_patches(*atlas.arrays[:7], readings.astype(np.float32), atlas.scores, idle)
    assert idle.tolist() == [False] + [True] * (sum(counts) - 1)


def test_the_room_holds_what_is_computed_at_once() -> None:
    assert SCORES == tiles_kernel.TOGETHER
