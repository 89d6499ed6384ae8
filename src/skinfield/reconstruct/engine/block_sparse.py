"""Block-sparse product of a whole skin: all kinds of patches in one call, a map for each rung."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Ints
from skinfield.reconstruct.engine.patch_kinds import PatchGroup
from skinfield.reconstruct.engine.products import CUT, PROOF, Singles
from skinfield.solve.tiles import SIDE, Tiles, aligned_blocks

Ints32 = NDArray[np.int32]
SCORES = 6  # patches whose products an idle test holds at once: `tiles_kernel.TOGETHER`


@dataclass(frozen=True, eq=False)
class Atlas:
    """Tiles of all kinds of patches, end to end.

    Attributes
    ----------
    values, taxels, firsts, cells : arrays
        Of all stamps; see `Tiles`. Each kind has one entry of `firsts` and `cells` more than
        tiles.
    table : (G, 10) int array
        Where the parts of each kind are; see `block_sparse_kernel.products`.
    dropped : float32 array
        Of all stamps: how far a product may be off, as part of the norm of a patch's readings.
    thresholds : (G,) float32 array
        Of an idle test.
    scores : float32 array
        To work in.
    """

    values: Singles
    taxels: Ints32
    firsts: Ints32
    cells: Ints32
    table: Ints
    dropped: Singles
    thresholds: Singles
    scores: Singles

    @classmethod
    def of(
        cls, stamps: Sequence[Tiles], counts: Sequence[int], thresholds: Sequence[float] = ()
    ) -> "Atlas":
        """Put stamps in float32 end to end.

        Parameters
        ----------
        stamps : sequence of Tiles
            Of each kind of patch.
        counts : sequence of int
            Patches of each kind; all arrays over patches have them side by side.
        thresholds : sequence of float, optional
            Of an idle test of each kind.
        """
        values = aligned_blocks(sum(len(each.values) for each in stamps), np.dtype(np.float32))
        np.concatenate([each.values for each in stamps], out=values)
        blocks = np.cumsum([0, *(len(each.values) for each in stamps)])[:-1]
        none = np.zeros(1, np.int32)
        dropped = np.concatenate([each.dropped for each in stamps])
        return cls(
            values=values,
            taxels=np.concatenate([each.taxels for each in stamps]),
            firsts=np.concatenate(
                [each.firsts + first for each, first in zip(stamps, blocks, strict=True)]
            ).astype(np.int32),
            cells=np.concatenate([part for each in stamps for part in (each.cells, none)]),
            table=_table(stamps, counts),
            dropped=(dropped * (1.0 + 1e-6)).astype(np.float32),  # not less by its rounding
            thresholds=np.asarray(thresholds, dtype=np.float32),
            scores=np.zeros(SCORES * max(len(each.dropped) for each in stamps), np.float32),
        )

    @cached_property
    def arrays(self) -> tuple[Any, ...]:
        """All of them, as `cycle_kernel.test_idle` takes them."""
        stamps = self.values, self.taxels, self.firsts, self.cells, self.table
        return *stamps, self.dropped, self.thresholds, self.scores

    def apply(self, readings: Singles, out: Singles) -> None:
        """Write the products of all patches' readings (N,) into `out` (M,), end to end."""
        from skinfield.reconstruct.engine.block_sparse_kernel import products

        stamps = self.values, self.taxels, self.firsts, self.cells
        products(*stamps, self.table, readings, out)


def _table(stamps: Sequence[Tiles], counts: Sequence[int]) -> Ints:
    table: Ints = np.zeros((len(stamps), 10), dtype=np.int64)
    tile = taxel = cell = bound = row = 0
    for kind, (each, count) in enumerate(zip(stamps, counts, strict=True)):
        tiles, size, width = len(each.cells), each.count, len(each.dropped)
        table[kind] = tile, tiles, each.shape[1], size, width, count, taxel, cell, bound, row
        tile, bound, row = tile + tiles + 1, bound + width, row + count
        taxel, cell = taxel + count * size, cell + count * width
    return table


def idle_tests(groups: Sequence[PatchGroup]) -> list[Atlas]:
    """Tests of all patches on each rung; none where the answers are linear.

    Products of its rows, the whole matrix's scaled to the length 1, with whitened readings without
    their offset are at most the threshold if a patch is idle.
    """
    counts, tests = [group.count for group in groups], []
    for rung in range(len(groups[0].operators)):
        stamps = []
        for group in groups:
            problem = group.operators[rung].problem
            rows = problem.unshared[:, : len(group.kind.noise_std)]
            scale = np.divide(
                1.0, problem.norms, out=np.zeros_like(problem.norms), where=problem.norms > 0
            )
            shape = group.rungs.steps[rung].grid.shape
            stamps.append(_stamps(rows * scale[:, None], shape, PROOF))
        limits = [group.operators[rung].problem.threshold for group in groups]
        tests.append(Atlas.of(stamps, counts, limits))
    return tests


def linear_answers(groups: Sequence[PatchGroup]) -> list[Atlas]:
    """Linear answers of all patches on each rung; none where a grid is too coarse for tiles."""
    counts, answers = [group.count for group in groups], []
    for rung, step in enumerate(groups[0].rungs.steps):
        if min(step.grid.shape) < SIDE:
            return []
        stamps = [
            _stamps(group.matrix_on(rung), group.rungs.steps[rung].grid.shape, CUT)
            for group in groups
        ]
        answers.append(Atlas.of(stamps, counts))
    return answers


def join_fields(groups: Sequence[PatchGroup], rung: int) -> Singles:
    """Put the linear answers' fields of all patches end to end, where an `Atlas` writes them."""
    sizes = [group.fields[rung].size for group in groups]
    field: Singles = np.zeros(sum(sizes), np.float32)
    for group, part in zip(groups, np.split(field, np.cumsum(sizes)[:-1]), strict=True):
        group.fields[rung] = part.reshape(group.count, -1)
    return field


def _stamps(matrix: NDArray[Any], shape: tuple[int, int], cut: float) -> Tiles:
    """Tiles of a matrix (K, L); a grid that is too small for tiles is filled up with zeros."""
    if min(shape) < SIDE:
        rows = max(len(matrix), SIDE**2)
        shape = (SIDE, -(-rows // SIDE))
        missing = shape[0] * shape[1] - len(matrix)
        matrix = np.concatenate([matrix, np.zeros((missing, matrix.shape[1]))])
    return Tiles.of(matrix, shape, cut)
